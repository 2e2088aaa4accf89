// SPDX-License-Identifier: GPL-3.0-or-later
// From what the triangles leave in one cell to the one or two points that the cell gives.
#pragma once

#include "pointshell/project.hpp"

#include <span>

namespace voxshell {

/// One triangle in one cell.
struct Piece {
    Vec point; ///< its nearest point [cells, from the centre]
    double distance2;
    double area; ///< [cells^2], may be 0: a touch, or a triangle without area
    Vec normal;  ///< of the triangle, outwards; 0 if it has no plane
    std::uint32_t triangle;
    std::uint16_t cell;
};

struct Side {
    const Piece *nearest; ///< whose point the side gives
    Vec inward;           ///< unit; 0 if no triangle of the cell has a plane
    double area;          ///< of the side's pieces [cells^2]
};

struct Sides {
    std::array<Side, 2> side; ///< the nearer one first
    int count;                ///< 1 or 2
};

/// One point for a cell, as the paper has it, with the area-weighted mean normal; two where one normal would
/// not do:
///   - the mean nearly cancels: |sum of area n| < 1/4 sum of area (a thin wall, a knife edge, a needle);
///   - two opposed sides, more than 140 degrees apart, of which the smaller holds a tenth of the area or
///   more;
///   - the surface at the nearest point is opposed to the mean: the point would push out of the solid.
/// The sides are told apart by the principal axis of the pieces' normals (largest eigenvector of sum area n
/// n^T), in the last case by the mean. A side's normal is its own mean, or its nearest piece's where even
/// that nearly cancels or opposes that piece. Where nothing has area (the mesh only touches the cell) all
/// pieces' planes count alike. Of equal distances the lower triangle counts. `pieces` in ascending order of
/// triangles.
Sides sides_of(std::span<const Piece> pieces);

} // namespace voxshell
