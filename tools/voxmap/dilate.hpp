// SPDX-License-Identifier: GPL-3.0-or-later
// Growing sets of cells, brick by brick: what layers, bands and closed gaps are made of.
#pragma once

#include "cli/progress.hpp"
#include "voxmap/cells.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

using CellMask = std::array<std::uint64_t, 8>; ///< 512 cells of a brick, in Brick's bit order

/// Adds to `cells` every brick that has a cell within `reach` cells, Chebyshev, of a surface cell; solid runs
/// give way. (Beyond a reach of 8: more around bricks without a surface cell.) The cells' states stay; the
/// origin may move down by chunks.
void widen(Cells &cells, int reach, Progress &progress);

/// The 27 bricks around each brick (itself in the middle, at 13), or `none`.
struct BrickNeighbours {
    static constexpr std::uint32_t none = UINT32_MAX;
    BrickNeighbours(const Cells &cells, Progress &progress);
    std::vector<std::array<std::uint32_t, 27>>
        at; ///< brick (i, j, k) of -1..1 at 9 (i + 1) + 3 (j + 1) + k + 1
};

/// Each mask grown by one cell in the Chebyshev metric, within the bricks that there are.
std::vector<CellMask> dilate(const std::vector<CellMask> &masks, const BrickNeighbours &neighbours,
                             Progress &progress);

/// Turns the bricks for which `silent[b]` is set, all of one state, back into free space or solid runs. The
/// others keep their order; `kept` lists them.
std::vector<std::size_t> make_uniform(Cells &cells, const std::vector<std::uint8_t> &silent);

} // namespace voxshell
