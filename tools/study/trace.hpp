// SPDX-License-Identifier: GPL-3.0-or-later
// What a servo loop did, tick by tick: as numbers (CSV) and as the picture of the paper's figure 12.
#pragma once

#include "import/scene.hpp"
#include "study/gnuplot.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace voxshell {

struct TraceRow {
    double t = 0;             ///< [s]
    Point device{};           ///< measured position of the device [m]
    Point hand{};             ///< where the hand wants to be [m]
    Point body{};             ///< what feels the contact: the device, or what hangs on it [m]
    Point collision_force{};  ///< from the contact, before the coupling [N]
    Point collision_torque{}; ///< [N m], about the dynamic object's reference point
    Point output_force{};     ///< what the device renders [N]
    std::uint32_t contacts = 0;
    std::uint32_t flags = 0;
    double energy = 0; ///< taken from the hand [J], of the guard passivity; 0 without
};

/// One header line, one line a row; each number reads back as the same double.
std::string trace_csv(const std::vector<TraceRow> &rows);

/// Collision force (thin) and output force (thick) in newtons over time, drawn by gnuplot. Throws
/// Failure(system) if gnuplot is not installed or fails.
std::vector<std::uint8_t> plot_trace(const std::vector<TraceRow> &rows, const std::string &title,
                                     Picture picture);

} // namespace voxshell
