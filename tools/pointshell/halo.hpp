// SPDX-License-Identifier: GPL-3.0-or-later
// What needs a cell's neighbours: the gap between points, and normals for cells that have none of their own.
#pragma once

#include "pointshell/shell.hpp"

namespace voxshell {

/// Largest distance between a point of one cell and a point of a face- or edge-adjacent cell [m], over all
/// pairs: where a cell gives two points, each counts. Points inside their cells can be at most sqrt(4 + 4 +
/// 1) = 3 h apart. `first[b]`: first point of brick b of `cells`; its points end where those of the next
/// brick in point order begin, `last[b]`. Points of a cell stand together.
double gap_max(const Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
               const std::vector<std::uint64_t> &last);

/// Points whose normal is 0 (their cell holds triangles without area only) get the area-weighted mean normal
/// of the points in the 26 cells around; where there is none or it cancels, the direction from the point to
/// its cell's centre, and where that is nothing too, -Y.
void borrow_normals(Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
                    const std::vector<std::uint64_t> &last);

} // namespace voxshell
