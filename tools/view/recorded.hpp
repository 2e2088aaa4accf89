// SPDX-License-Identifier: GPL-3.0-or-later
// What moved, over time: a trace of simulate, a recording, or the path that the hand is to go.
#pragma once

#include "scene/scene_file.hpp"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

struct Moment {
    double t = 0; ///< [s]
    Pose body;    ///< what feels the contact
    Point device{}, hand{};
    Point collision_force{};  ///< from the contact [N]
    Point collision_torque{}; ///< [N m]
    Point output_force{};     ///< what the device renders [N]
    std::uint32_t contacts = 0;
};

struct Recorded {
    std::string source; ///< file name, or "the hand's path"
    bool forces = true;
    std::size_t of = 0;       ///< rows that there were
    std::vector<Moment> rows; ///< most_rows at most: of as many as fall together the one of most force
    static constexpr std::size_t most_rows = 20000;
};

/// Of simulate --trace (CSV, known by its head) or --record (known by its first bytes). A trace has no
/// orientation: the body's is that of `hand` at the time; without, it is not turned. Throws Failure: system
/// (cannot be read), invalid with the line or row.
Recorded read_recorded(const std::filesystem::path &path, const HandPath *hand);

/// Where a part on a path is at a time: between two stops as the effect motion has it (effect.h), before the first
/// and after the last at rest. `stops`: at least one, ascending.
struct Stop {
    double t; ///< [s]
    Pose pose;
};
Pose on_the_way(const std::vector<Stop> &stops, double t);

/// The path itself, a hundred rows a second, more where it is short and fewer where it is long.
Recorded planned(const HandPath &hand, double end);

} // namespace voxshell
