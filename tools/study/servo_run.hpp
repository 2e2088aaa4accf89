// SPDX-License-Identifier: GPL-3.0-or-later
// A plan on a simulated device, a replay or hardware through the runtime's own servo: in virtual time, or on
// the servo thread.
#pragma once

#include "cli/progress.hpp"
#include "study/durations.hpp"
#include "study/open_device.hpp"
#include "study/planned_servo.hpp"
#include "study/trace.hpp"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

struct RunOptions {
    double seconds = 0;
    bool realtime = false;  ///< on the servo thread, at the wall clock's rate; otherwise virtual time, and as
                            ///< fast as it goes
    bool keep_rows = false; ///< fill ServoRun::rows
    bool keep_recording = false; ///< fill ServoRun::recording
    OpenDevice *device =
        nullptr;      ///< in place of the plan's own, READY; hardware only in real time. The hand's path is
                      ///< of no account then, but for where hardware's middle is: at its start
    std::string live; ///< real time: a file that shows the newest row (live.h); empty: none
};

struct ServoRun {
    std::uint64_t ticks = 0;
    double collision_peak = 0, output_peak = 0; ///< |force| [N]
    double output_mean = 0;                     ///< |force| over the ticks in contact [N]
    std::uint64_t contact_ticks = 0;
    std::uint32_t points_most = 0;   ///< in contact at once
    std::uint32_t probed_most = 0;   ///< looked at in a tick
    std::uint32_t level_most = 0;    ///< coarsest level of detail
    std::uint32_t budget_points = 0; ///< what the scene's budget buys on this machine, 0: none
    double depth_most = 0;           ///< [m], of a point under the plane of its cell
    double reach_most = 0;           ///< how far the hand's target was ahead of the device [m]
    double step_most = 0;            ///< |change of force at the hand| from one tick to the next [N]
    double energy_least = 0;         ///< taken from the hand, as passivity observed it [J]; 0 without
    std::uint32_t flags = 0;         ///< of all ticks, or-ed (VXS_SERVO_*, VXS_CONTACT_*)
    std::array<std::uint64_t, 32> flag_ticks{}; ///< ticks with bit n set
    Durations tick; ///< exchange and tick; of the thread's histogram (powers of two) in real time
    struct Realtime {
        std::string scheduling, memory; ///< granted, or why not
        std::uint64_t missed = 0;
        std::uint64_t rows_dropped = 0; ///< too late for the trace
        Durations lateness;             ///< upper ends of the thread's histogram bins, and the largest
    };
    std::optional<Realtime> realtime;
    std::vector<TraceRow> rows;
    std::vector<vxs_servo_trace> recording;
    std::string device_end; ///< "READY", "FAULT, watchdog": what became of RunOptions::device
};

/// Runs the loop: options.seconds at the plan's rate, the device armed at the start of the hand's path.
/// Throws Failure: usage (no such device; seconds), requirement (hardware with motors, and a plan without its
/// guards), interrupted.
ServoRun run_servo(const PlannedServo &planned, const RunOptions &options, Progress &progress);

/// Name of flag bit n ("deep", "saturated"), empty for none such.
std::string flag_name(unsigned bit);

} // namespace voxshell
