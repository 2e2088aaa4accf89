// SPDX-License-Identifier: GPL-3.0-or-later
// How late a thread wakes up on this machine: an absolute-time loop, its histogram as a file and as a
// picture.
#pragma once

#include "cli/progress.hpp"
#include "study/gnuplot.hpp"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace voxshell {

struct Lateness {
    std::vector<float> late_ns, work_ns; ///< a tick each
    std::uint64_t missed = 0;            ///< periods that were skipped
    std::string scheduling, memory;      ///< granted, or why not and what helps
};

/// Wakes up `ticks` times at start + n / rate on the monotonic clock, as vxs_servo_thread does, with its
/// priority and its locked memory where they are granted, and calls `work` each time. Throws
/// Failure(interrupted).
Lateness measure_lateness(double rate_hz, std::uint64_t ticks, const std::function<void()> &work,
                          Progress &progress);

/// Two histograms in bins of 1 us up to 1 ms and of 1 ms from there: `from_us,late,work`, rows that hold none
/// left out.
std::string histogram_csv(const Lateness &lateness);
std::vector<std::uint8_t> plot_histogram(const Lateness &lateness, const std::string &title, Picture picture);

} // namespace voxshell
