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

inline bool has_plane(const Piece &piece)
{
    return piece.normal[0] != 0 || piece.normal[1] != 0 || piece.normal[2] != 0;
}

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
/// n^T), in the last case by the mean; a rim goes with the face that it is nearer to. A side's normal is its
/// own mean, or its nearest piece's where even that nearly cancels or opposes that piece. Where nothing has
/// area (the mesh only touches the cell) all pieces' planes count alike. Of equal distances the lower
/// triangle counts. `pieces` in ascending order of triangles.
Sides sides_of(std::span<const Piece> pieces);

/// The mean may look along a face that the point lies on, or out of it: at an edge of whose other face the
/// cell holds a sliver. The normal next to `inward` that leads from `point` into the solid, 10 degrees under
/// the face where the edge leaves room; `inward` itself where that leads in by 5 degrees, and where nothing
/// does better: faces less than 15 degrees apart, back to back. `facets`: the triangles with a plane that the
/// point lies on, as its cell sees them.
Vec into_solid(const Vec &inward, const Vec &point, std::span<const CellTriangle> facets);

/// Nearer counts as on it: one unit of the lattice [cells].
constexpr double on_facet = 1.0 / static_cast<double>(lattice_per_cell);
/// Cosine of 85 degrees: a normal that is nearer than that to no face need not be led.
constexpr double grazing = 0.087;

} // namespace voxshell
