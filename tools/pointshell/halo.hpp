// SPDX-License-Identifier: GPL-3.0-or-later
// What needs a cell's neighbours: the gap between points, and normals for cells that have none of their own.
#pragma once

#include "pointshell/shell.hpp"

#include <span>

namespace voxshell {

/// For each point the index of the one that stands for its cell: its own, or after thinning (thin.hpp)
/// another's. Empty: each its own.
using Stands = std::span<const std::uint32_t>;

/// Largest distance between points that stand for face- or edge-adjacent cells [m], over all pairs: where a
/// cell gives two points, each counts. Points inside their cells can be at most sqrt(4 + 4 + 1) = 3 h apart.
/// Points are ordered by brick: those of brick b of `cells` are [first[b], first[b + 1]), and those of a cell
/// stand together.
double gap_max(const Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
               Progress &progress, Stands stands = {});

/// Marks (1) each point for which another stands and that has an adjacent cell beyond `limit` [m] in the
/// sense of gap_max().
std::vector<std::uint8_t> too_far(const Shell &shell, const Cells &cells,
                                  const std::vector<std::uint64_t> &first, Stands stands, double limit,
                                  Progress &progress);

/// Marks (1) each point that has a point of an adjacent cell whose normal is further off than `cosine`
/// allows: edges, thin walls, whatever is not flat.
std::vector<std::uint8_t> beside_others(const Shell &shell, const Cells &cells,
                                        const std::vector<std::uint64_t> &first, double cosine,
                                        Progress &progress);

/// Points whose normal is 0 (their cell holds triangles without area only) get the area-weighted mean normal
/// of the points in the 26 cells around; where there is none or it cancels, the direction from the point to
/// its cell's centre, and where that is nothing too, -Y.
void borrow_normals(Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
                    Progress &progress);

} // namespace voxshell
