// SPDX-License-Identifier: GPL-3.0-or-later
// Cells put together from the nodes of a tree, in whatever order they come. For the .vdb parsers; without
// OpenVDB.
#pragma once

#include "cli/failure.hpp"
#include "voxmap/cells.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace voxshell {

inline constexpr std::array<std::uint64_t, 8> no_cells{};
inline constexpr std::array<std::uint64_t, 8> all_cells{~0ull, ~0ull, ~0ull, ~0ull,
                                                        ~0ull, ~0ull, ~0ull, ~0ull};

/// A box of bricks, absolute, max inclusive; empty at first.
struct BrickBox {
    Cell min{INT64_MAX, INT64_MAX, INT64_MAX}, max{INT64_MIN, INT64_MIN, INT64_MIN};
    void grow(const Cell &low, const Cell &high);
    bool empty() const { return min[0] > max[0]; }
    Cell origin() const; ///< Cells::origin for it
};

/// Throws Failure(code) if the box is beyond what a .voxmap or the 32-bit indices of a .vdb hold: to be asked
/// before a hostile tile of 4096^3 cells is spread out.
void check_box(const BrickBox &box, const std::string &grid, ExitCode code);

/// Sorts runs and joins those that touch.
void join(std::vector<SolidRun> &runs);

/// Sorts bricks and removes what is there twice.
void make_unique(std::vector<BrickAt> &bricks);

/// Takes the bricks `taken` (sorted, unique) out of the runs (joined). Returns for each whether a run had it.
std::vector<bool> take_out(std::vector<SolidRun> &runs, const std::vector<BrickAt> &taken);

/// Where a channel speaks, there is a brick: adds those of `spoken` (sorted, unique) that are solid or free
/// so far.
void add_spoken(const std::vector<BrickAt> &spoken, Cells &cells);

} // namespace voxshell
