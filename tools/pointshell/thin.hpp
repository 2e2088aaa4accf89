// SPDX-License-Identifier: GPL-3.0-or-later
// Fewer points where the surface is flat.
#pragma once

#include "pointshell/shell.hpp"

namespace voxshell {

/// Where the surface is flat, one point stands for up to eight cells (a block of 2 x 2 x 2): the others of
/// the block whose normals are within `angle` [rad] of its own, and which lie within sin(angle) voxels of its
/// tangent plane, are left out, and it takes over their area weights. Kept points stay where they are. Cells
/// with two points (thin walls) and those beside a cell whose normal differs by more than `angle` (edges)
/// keep theirs. The bound of 3 h holds as before, with the points that stand for adjacent cells: what would
/// break it is kept. On a plane about a quarter of the points remains.
///
/// What a runtime loses: contact is found up to one block later, because an obstacle smaller than the gap, a
/// pin, an edge or a corner, can enter between two points where it would have met the one left out; and with
/// `weighting: count` the force of a flat contact falls with the number of points (`area` keeps it). Walls of
/// the map are not missed as long as they are as thick as the gap.
///
/// Fills in Shell::thinning, gap_max and surface_cells. `first` as in halo.hpp. A pure function of the shell.
void thin(Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first, double angle,
          Progress &progress);

} // namespace voxshell
