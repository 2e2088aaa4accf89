// SPDX-License-Identifier: GPL-3.0-or-later
// One cell, one triangle: the paper's projectPoint (section 2.1).
#pragma once

#include "import/point.hpp"
#include "voxmap/lattice.hpp"

#include <array>
#include <cstdint>

namespace voxshell {

using Vec = Point;

__extension__ typedef __int128 Wide;

/// A triangle of the lattice with its plane, which all cells share.
struct LatticeTriangle {
    std::array<LatticePoint, 3> corner;
    std::array<Wide, 3> area; ///< twice the area vector, exact [lattice units squared]
    double length;            ///< of `area`
    Vec normal; ///< unit, by the winding, right to the last bit even for slivers; exactly 0 without area
};
LatticeTriangle lattice_triangle(const LatticePoint &a, const LatticePoint &b, const LatticePoint &c);

/// A triangle as one cell sees it: relative to the cell's centre, so that the closed cell V is |x|, |y|, |z|
/// <= 1/2 cell. Extents up to 2^20 cells.
struct CellTriangle {
    std::array<LatticePoint, 3> lattice; ///< in units of voxel / 65536
    std::array<Vec, 3> corner;           ///< in cells, exact
    std::array<Wide, 3> area;            ///< as above
    Vec normal;                          ///< as above; 0 for a segment or a point
    double offset;                       ///< of the plane: normal . x on it [cells]
};
CellTriangle seen_from(const Cell &cell, const LatticeTriangle &triangle);

/// The paper's cases: p0 is the foot of the perpendicular from the centre to the triangle's plane (of a
/// triangle without area: to its line), V the cell, T the triangle.
enum class ProjectionCase : std::uint8_t {
    foot = 1,      ///< case 1: p0 in V and in T: p0
    foot_in_cell,  ///< case 2: p0 in V, not in T: the point of T and V nearest to p0
    foot_in_face,  ///< case 3: p0 not in V, in T: the point of T and the surface of V nearest to p0
    foot_off_near, ///< case 4, p0 in neither: the point of T nearest to p0 happens to be in V
    foot_off_cut,  ///< case 4, it is not: as case 3
};

struct Projection {
    ProjectionCase situation;
    Vec point;        ///< the point of T and V nearest to the centre; always inside the closed cell
    double distance2; ///< of the point from the centre, squared
    double area;      ///< of T inside V, in units of the edge squared
};

/// The four cases are one statement: argmin |p| over p in T and V. `triangle` must meet the cell
/// (voxelize.hpp triangle_cells()). The corners of T and V come from integers by one rounding, so that no
/// touch is lost, be it in a corner of the cell, along its edge or by a sliver.
Projection project(const CellTriangle &triangle);

/// The point of the triangle nearest to `from`.
Vec nearest_on_triangle(const CellTriangle &triangle, const Vec &from);

inline Vec operator-(const Vec &a, const Vec &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec operator+(const Vec &a, const Vec &b)
{
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec operator*(double s, const Vec &a)
{
    return {s * a[0], s * a[1], s * a[2]};
}

} // namespace voxshell
