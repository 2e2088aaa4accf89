// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles to surface cells, exactly (method section 1): integers only, no epsilon.
#pragma once

#include "cli/progress.hpp"
#include "voxmap/cells.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace voxshell {

/// Which triangles meet which brick: the index that the voxeliser makes and the point projection
/// reuses. Compressed rows: brick b is met by triangles of [start[b], start[b + 1]), in ascending order.
struct BrickTriangles {
    Cell origin{};
    std::vector<BrickAt> bricks; ///< sorted lexicographically, unique
    std::vector<std::uint64_t> start;
    std::vector<std::uint32_t> triangle;
    std::span<const std::uint32_t> of(std::size_t brick) const
    {
        return {triangle.data() + start[brick], triangle.data() + start[brick + 1]};
    }
};

/// Exact binning of triangles to half-open bricks of 8^3 cells. Deterministic for any thread count.
BrickTriangles bin_triangles(const LatticeMesh &mesh, Progress &progress);

/// One triangle against the 512 half-open cells of one brick: sets bit c of `met` (Brick's bit order)
/// for each cell that contains at least one point of the closed triangle. Exact.
void triangle_cells(const LatticeMesh &mesh, std::uint32_t triangle, const Cell &brick_min,
                    std::array<std::uint64_t, 8> &met);

/// Surface cells of the mesh (interior still empty). Deterministic for any thread count.
Cells voxelize(const LatticeMesh &mesh, const BrickTriangles &binned, Progress &progress);

} // namespace voxshell
