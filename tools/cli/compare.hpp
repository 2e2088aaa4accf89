// SPDX-License-Identifier: GPL-3.0-or-later
// Two assets held against each other.
#pragma once

#include "plan/plan_file.hpp"
#include "pointshell/pointshell_file.hpp"
#include "voxmap/voxmap_file.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace voxshell {

struct Comparison {
    struct Structure {
        std::string what, a, b;
    };
    struct Change {
        std::array<double, 3> at; ///< [m]: a cell's centre, a point
        std::string what;
    };
    const char *noun = "";            ///< "cells", "points"
    std::vector<Structure> structure; ///< facts about the files that differ
    bool compared = false;            ///< values can be compared: the voxels are equal
    std::uint64_t changed = 0;        ///< values that differ by more than the tolerance
    double largest = 0;               ///< the furthest that one moved [m]
    bool largest_is_bound = false;    ///< one has no counterpart within `largest`
    std::vector<Change> first;        ///< ten of them, in the order of cells
    std::vector<std::string> notes;   ///< differences that do not count: source, options

    bool equal() const { return structure.empty() && changed == 0; }
};

/// A cell changed if its state did. With a tolerance of n cells' edges, one whose old and new state both
/// occur no more than n cells away in the other map did not.
Comparison compare(const VoxmapFile &a, const VoxmapFile &b, double tolerance);

/// Points are matched cell by cell. Without a tolerance every bit counts; with one, a point changed if the
/// other shell has none that near.
Comparison compare(const PointshellFile &a, const PointshellFile &b, double tolerance);

/// All that plans say, fact by fact.
Comparison compare(const PlanFile &a, const PlanFile &b);

} // namespace voxshell
