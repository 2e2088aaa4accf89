// SPDX-License-Identifier: GPL-3.0-or-later
// The voxmap offline: sparse bricks of cell states. What voxelisation makes, what the writers take.
#pragma once

#include "voxmap/lattice.hpp"
#include "voxshell/format/voxmap.h"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

using BrickAt = std::array<std::int32_t, 3>; ///< brick coordinates relative to Cells::origin, >= 0

/// 8 x 8 x 8 cells of which at least one is a surface cell. Cell c = vxs_voxmap_brick_cell(i, j, k) is
/// bit c & 63 of word c >> 6: word i, bit 8 j + k.
struct Brick {
    BrickAt at{};
    std::array<std::uint64_t, 8> surface{};
    std::array<std::uint64_t, 8> interior{}; ///< never overlaps surface
};

/// Bricks (at[0], at[1], first..last) that are interior throughout; last inclusive.
struct SolidRun {
    std::int32_t i, j, first, last;
    bool operator==(const SolidRun &) const = default;
};

/// Invariants: bricks sorted by `at` lexicographically, unique; solid runs sorted, disjoint from each
/// other and from the bricks; everything else is free. A pure function of the lattice mesh.
struct Cells {
    double voxel = 0; ///< [m]
    Cell origin{};    ///< cell of brick (0,0,0)'s min corner, multiple of VXS_VOXMAP_CHUNK_CELLS
    std::vector<Brick> bricks;
    std::vector<SolidRun> solid;
    std::uint64_t surface_cells = 0;
    std::uint64_t interior_cells = 0;
    Cell min{}, max{};   ///< tight box of surface and interior cells, max inclusive
    bool closed = false; ///< the mesh had no boundary edge (VXS_VOXMAP_FLAG_CLOSED)
};

/// State of one cell (VXS_CELL_*), by binary search: for tools and tests, not for ticks.
int cell_state(const Cells &cells, const Cell &at);

/// Recomputes surface_cells, interior_cells, min and max from bricks and solid.
void recount(Cells &cells);

} // namespace voxshell
