// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/project.hpp"

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

bool in_cell(const Vec &p)
{
    return std::abs(p[0]) <= 0.5 && std::abs(p[1]) <= 0.5 && std::abs(p[2]) <= 0.5;
}

Vec into_cell(const Vec &p)
{
    return {std::clamp(p[0], -0.5, 0.5), std::clamp(p[1], -0.5, 0.5), std::clamp(p[2], -0.5, 0.5)};
}

Vec nearest_on_segment(const Vec &a, const Vec &b, const Vec &from)
{
    const Vec along = b - a;
    const double length2 = dot(along, along), t = dot(from - a, along);
    if (!(t > 0)) return a; // also where a equals b
    if (t >= length2) return b;
    return a + (t / length2) * along;
}

// A convex polygon in V's frame; a triangle cut by six planes has at most nine corners. `along[i]` tells on
// what the edge from corner i to the next lies: 0..2 the triangle's edge, 3 + 2 axis + (side > 0) a face of
// V.
struct Polygon {
    std::array<Vec, 12> at;
    std::array<int, 12> along;
    int count = 0;
    void add(const Vec &p, int carrier)
    {
        at[count] = p;
        along[count++] = carrier;
    }
};

constexpr std::int64_t half = lattice_per_cell / 2;
constexpr double cells = 1.0 / static_cast<double>(lattice_per_cell);

int axis_of(int face)
{
    return (face - 3) / 2;
}
double side_of(int face)
{
    return (face - 3) % 2 ? 0.5 : -0.5;
}

std::array<Wide, 3> exact_area(const std::array<LatticePoint, 3> &p)
{
    std::array<Wide, 3> n{};
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        n[i] = static_cast<Wide>(p[1][j] - p[0][j]) * (p[2][k] - p[0][k]) -
               static_cast<Wide>(p[1][k] - p[0][k]) * (p[2][j] - p[0][j]);
    }
    return n;
}

// Whether 64 bits hold n.x: corners within 8 cells of the centre make |n_i| <= 2^41, |n.x| < 3 * 2^61 / 2.
constexpr std::int64_t small_reach = std::int64_t{1} << 19;
// Whether they hold a product of two differences of coordinates and one more: within 16384 cells.
constexpr std::int64_t medium_reach = std::int64_t{1} << 30;

bool within(const std::array<LatticePoint, 3> &p, std::int64_t limit)
{
    for (const LatticePoint &v : p)
        for (const std::int64_t x : v)
            if (x > limit || x < -limit) return false;
    return true;
}

// Where the polygon's edge that lies on `carrier` passes `face`: from the integers, not from corners
// that are rounded already.
template<class Int>
Vec meeting_edge(const CellTriangle &triangle, int carrier, int face)
{
    const int i = axis_of(face);
    const std::int64_t c = (face - 3) % 2 ? half : -half;
    Vec p{};
    p[i] = side_of(face);
    // The triangle's edge a b, at (c - a_i) / (b_i - a_i).
    const LatticePoint &a = triangle.lattice[carrier], &b = triangle.lattice[(carrier + 1) % 3];
    const std::int64_t rise = b[i] - a[i];
    for (const int k : {(i + 1) % 3, (i + 2) % 3}) {
        const Int numerator = static_cast<Int>(a[k]) * rise + static_cast<Int>(b[k] - a[k]) * (c - a[i]);
        p[k] = static_cast<double>(numerator) / static_cast<double>(rise) * cells;
    }
    return p;
}

// The same where two faces of V meet, through the triangle's plane n.x = n.a.
template<class Int>
Vec meeting_plane(const CellTriangle &triangle, int carrier, int face)
{
    const int i = axis_of(face), j = axis_of(carrier), k = 3 - i - j;
    const std::int64_t c = (face - 3) % 2 ? half : -half, d = (carrier - 3) % 2 ? half : -half;
    const Int n[3] = {static_cast<Int>(triangle.area[0]), static_cast<Int>(triangle.area[1]),
                      static_cast<Int>(triangle.area[2])};
    const LatticePoint &a = triangle.lattice[0];
    const Int numerator = n[i] * (a[i] - c) + n[j] * (a[j] - d) + n[k] * a[k];
    Vec p{};
    p[i] = side_of(face);
    p[j] = side_of(carrier);
    p[k] = static_cast<double>(numerator) / static_cast<double>(n[k]) * cells;
    return p;
}

enum class Size { small, medium, large };

Size size_of(const CellTriangle &triangle)
{
    return within(triangle.lattice, small_reach)    ? Size::small
           : within(triangle.lattice, medium_reach) ? Size::medium
                                                    : Size::large;
}

Vec meeting(const CellTriangle &triangle, Size size, int carrier, int face)
{
    if (carrier < 3)
        return size == Size::large ? meeting_edge<Wide>(triangle, carrier, face)
                                   : meeting_edge<std::int64_t>(triangle, carrier, face);
    return size == Size::small ? meeting_plane<std::int64_t>(triangle, carrier, face)
                               : meeting_plane<Wide>(triangle, carrier, face);
}

// Puts into `out` what remains of `in` on V's side of `face` (Sutherland, Hodgman). False, and nothing, where
// that is all of it.
bool cut(const Polygon &in, const CellTriangle &triangle, Size size, int face, Polygon &out)
{
    const int axis = axis_of(face);
    const double sign = side_of(face) > 0 ? 1 : -1;
    bool all = true;
    for (int i = 0; i < in.count; ++i) all = all && sign * in.at[i][axis] <= 0.5;
    if (all) return false;
    out.count = 0;
    for (int i = 0; i < in.count; ++i) {
        const double a = sign * in.at[i][axis] - 0.5,
                     b = sign * in.at[i + 1 < in.count ? i + 1 : 0][axis] - 0.5;
        if (a <= 0) out.add(in.at[i], a == 0 && b > 0 ? face : in.along[i]);
        if ((a < 0 && b > 0) || (a > 0 && b < 0)) {
            out.add(meeting(triangle, size, in.along[i], face), a < 0 ? face : in.along[i]);
        }
    }
    return true;
}

Polygon whole(const CellTriangle &triangle)
{
    Polygon polygon;
    for (int i = 0; i < 3; ++i) polygon.add(triangle.corner[i], i);
    return polygon;
}

Polygon cut_to_cell(const CellTriangle &triangle)
{
    std::array<Polygon, 2> polygon;
    polygon[0] = whole(triangle);
    int now = 0;
    const Size size = size_of(triangle);
    for (int axis = 0; axis < 3; ++axis) {
        const auto [low, high] =
            std::minmax({triangle.corner[0][axis], triangle.corner[1][axis], triangle.corner[2][axis]});
        if (low < -0.5 && cut(polygon[now], triangle, size, 3 + 2 * axis, polygon[1 - now])) now = 1 - now;
        if (high > 0.5 && cut(polygon[now], triangle, size, 4 + 2 * axis, polygon[1 - now])) now = 1 - now;
    }
    return polygon[now];
}

Vec nearest_on_rim(const Polygon &polygon, const Vec &from)
{
    Vec best{};
    double least = INFINITY;
    for (int i = 0; i < polygon.count; ++i) {
        const Vec p = nearest_on_segment(polygon.at[i], polygon.at[i + 1 < polygon.count ? i + 1 : 0], from);
        const double d = dot(p - from, p - from);
        if (d < least) least = d, best = p;
    }
    return best;
}

double area_of(const Polygon &polygon, const Vec &normal)
{
    Vec twice{};
    for (int i = 2; i < polygon.count; ++i)
        twice = twice + cross(polygon.at[i - 1] - polygon.at[0], polygon.at[i] - polygon.at[0]);
    return std::max(0.0, dot(twice, normal) / 2);
}

bool has_plane(const CellTriangle &triangle)
{
    return triangle.normal != Vec{};
}

// Of a point of the triangle's plane.
bool inside_edges(const CellTriangle &triangle, const Vec &p)
{
    for (int i = 0; i < 3; ++i) {
        const Vec &a = triangle.corner[i], &b = triangle.corner[(i + 1) % 3];
        if (dot(cross(b - a, p - a), triangle.normal) < 0) return false;
    }
    return true;
}

// The foot from the centre on the line of the longest edge; the point itself where all corners are one.
Vec foot_on_line(const CellTriangle &triangle)
{
    Vec base = triangle.corner[0], along{};
    for (int i = 0; i < 3; ++i) {
        const Vec &a = triangle.corner[i], &b = triangle.corner[(i + 1) % 3];
        if (dot(b - a, b - a) > dot(along, along)) base = a, along = b - a;
    }
    const double length2 = dot(along, along);
    return length2 > 0 ? base - (dot(base, along) / length2) * along : base;
}

} // namespace

LatticeTriangle lattice_triangle(const LatticePoint &a, const LatticePoint &b, const LatticePoint &c)
{
    LatticeTriangle out{{a, b, c}, {}, 0, {}};
    out.area = exact_area(out.corner);
    const Vec wide{static_cast<double>(out.area[0]), static_cast<double>(out.area[1]),
                   static_cast<double>(out.area[2])};
    out.length = std::sqrt(dot(wide, wide)); // at least 1 unless 0
    if (out.length > 0) out.normal = {wide[0] / out.length, wide[1] / out.length, wide[2] / out.length};
    return out;
}

CellTriangle seen_from(const Cell &cell, const LatticeTriangle &triangle)
{
    CellTriangle out;
    for (int v = 0; v < 3; ++v)
        for (int i = 0; i < 3; ++i) {
            out.lattice[v][i] = triangle.corner[v][i] - (cell[i] * lattice_per_cell + half);
            out.corner[v][i] = static_cast<double>(out.lattice[v][i]) * cells;
        }
    out.area = triangle.area;
    out.normal = triangle.normal;
    out.offset = 0;
    if (out.normal == Vec{}) return out;
    if (within(out.lattice,
               small_reach)) { // products of at most 2^19 by the rounded normal: as good as exact
        out.offset = dot(out.corner[0], out.normal);
        return out;
    }
    // n.a would lose in double what the far corner and the near plane differ in.
    const std::array<Wide, 3> &n = out.area;
    const LatticePoint &a = out.lattice[0];
    out.offset = static_cast<double>(n[0] * a[0] + n[1] * a[1] + n[2] * a[2]) / triangle.length * cells;
    return out;
}

Vec nearest_on_triangle(const CellTriangle &triangle, const Vec &from)
{
    if (has_plane(triangle)) {
        const Vec foot = from + (triangle.offset - dot(from, triangle.normal)) * triangle.normal;
        if (inside_edges(triangle, foot)) return foot;
    }
    return nearest_on_rim(whole(triangle), from);
}

Projection project(const CellTriangle &triangle)
{
    const Polygon polygon = cut_to_cell(triangle);
    const Vec center{};
    const bool plane = has_plane(triangle);
    const Vec foot = plane ? triangle.offset * triangle.normal : foot_on_line(triangle);
    const bool foot_in_cell = in_cell(foot);

    Projection out{};
    out.area = area_of(polygon, triangle.normal);
    if (plane && foot_in_cell && inside_edges(triangle, foot)) {
        out.situation = ProjectionCase::foot;
        out.point = foot;
    } else {
        // Of the whole triangle; only the name of the case hangs on it. A line's foot is in T where it is T's
        // nearest.
        const Vec nearest = nearest_on_rim(whole(triangle), center);
        const bool foot_in_triangle =
            plane ? inside_edges(triangle, foot) : dot(nearest - foot, nearest - foot) <= 1e-20;
        out.situation = foot_in_triangle
                            ? (foot_in_cell ? ProjectionCase::foot : ProjectionCase::foot_in_face)
                        : foot_in_cell     ? ProjectionCase::foot_in_cell
                        : in_cell(nearest) ? ProjectionCase::foot_off_near
                                           : ProjectionCase::foot_off_cut;
        // The nearest point of T and V is on its rim, whose corners are near and so exact to the last bits.
        out.point = polygon.count > 0 ? nearest_on_rim(polygon, center) : nearest;
    }
    out.point = into_cell(out.point);
    out.distance2 = dot(out.point, out.point);
    return out;
}

} // namespace voxshell
