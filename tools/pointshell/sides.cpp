// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/sides.hpp"

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr double cancels = 0.25;     // |mean normal| below which it means nothing
constexpr double agrees = 0.95;      // |mean normal| above which the cell holds one side only
constexpr double opposed = -0.766;   // cosine of 140 degrees
constexpr double considerable = 0.1; // share of the area that makes a side
constexpr double along = 0.174;      // cosine of 80 degrees: less, and the mean lies in the surface

// Eigenvector of the largest eigenvalue of a symmetric matrix (xx yy zz xy xz yz), by Jacobi rotations.
Vec principal_axis(const std::array<double, 6> &m)
{
    double a[3][3] = {{m[0], m[3], m[4]}, {m[3], m[1], m[5]}, {m[4], m[5], m[2]}};
    double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int sweep = 0; sweep < 8; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (std::abs(a[p][q]) <= 1e-15 * (a[p][p] + a[q][q])) continue;
                const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
                const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double x = a[k][p], y = a[k][q];
                    a[k][p] = c * x - s * y, a[k][q] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = a[p][k], y = a[q][k];
                    a[p][k] = c * x - s * y, a[q][k] = s * x + c * y;
                }
                for (auto &row : v) {
                    const double x = row[p], y = row[q];
                    row[p] = c * x - s * y, row[q] = s * x + c * y;
                }
            }
    int best = 0;
    for (int i = 1; i < 3; ++i)
        if (a[i][i] > a[best][best]) best = i;
    return {v[0][best], v[1][best], v[2][best]};
}

bool nearer(const Piece *a, const Piece *b) // than none, too
{
    if (!a || !b) return a;
    return a->distance2 != b->distance2 ? a->distance2 < b->distance2 : a->triangle < b->triangle;
}

struct Group {
    const Piece *nearest = nullptr;
    const Piece *nearest_plane = nullptr; // the nearest one that has a plane
    double area = 0;
    Vec sum{}; // of area n
    double planes = 0;
    Vec normals{}; // of n
    void add(const Piece &piece)
    {
        if (has_plane(piece))
            add({&piece, &piece, piece.area, piece.area * piece.normal, 1, piece.normal});
        else
            add({&piece, nullptr, 0, {}, 0, {}});
    }
    void add(const Group &other)
    {
        if (nearer(other.nearest, nearest)) nearest = other.nearest;
        if (nearer(other.nearest_plane, nearest_plane)) nearest_plane = other.nearest_plane;
        area += other.area;
        sum = sum + other.sum;
        planes += other.planes;
        normals = normals + other.normals;
    }
    Side side() const
    {
        Side out{nearest, {}, area};
        if (!nearest_plane) return out;
        const Vec &mean = area > 0 ? sum : normals;
        const double size = length(mean);
        const bool usable = size >= cancels * (area > 0 ? area : planes) && size > 0 &&
                            (!has_plane(*nearest) || dot(mean, nearest->normal) >= 0);
        const Vec outward = usable                ? (1 / size) * mean
                            : has_plane(*nearest) ? nearest->normal
                                                  : nearest_plane->normal;
        out.inward = -1.0 * outward;
        return out;
    }
};

// Pieces on the axis' side first. A rim, across the axis, goes with the face that its nearest point is nearer
// to: from there the way into the solid is long. Pieces without a plane go with the larger side.
std::array<Group, 2> split(std::span<const Piece> pieces, const Vec &axis)
{
    const auto across = [&](const Piece &piece) { return std::abs(dot(piece.normal, axis)) < along; };
    std::array<Group, 2> group;
    Group rim, bare;
    for (const Piece &piece : pieces)
        (!has_plane(piece) ? bare : across(piece) ? rim : group[dot(piece.normal, axis) < 0]).add(piece);
    if (!group[0].nearest || !group[1].nearest) return {};
    const auto off = [&](const Group &side) {
        return std::abs(dot(side.nearest->normal, rim.nearest->point - side.nearest->point));
    };
    if (rim.nearest) group[off(group[1]) < off(group[0])].add(rim);
    if (bare.nearest) group[group[1].area > group[0].area].add(bare);
    return group;
}

// A wall and its rim in one cell: the two faces cancel, what is left of the mean is the rim's normal and lies
// in the face that the nearest point is on. It says nothing about that point's side.
bool is_rim(std::span<const Piece> pieces, const Group &all)
{
    const Vec &near = all.nearest->normal;
    if (!has_plane(*all.nearest) || dot(all.sum, near) >= along * length(all.sum)) return false;
    double opposite = 0;
    for (const Piece &piece : pieces)
        if (dot(piece.normal, near) < opposed) opposite += piece.area;
    return opposite >= considerable * all.area;
}

// Of the facets the one that a short step from `point` ends nearest to: its side is the solid's there, be the
// edge convex or concave. Of those equally near, as far as the lattice tells, the one that the step is
// steepest to.
const CellTriangle &facing(const Vec &direction, const Vec &point, std::span<const CellTriangle> facets)
{
    constexpr double step = 1.0 / 1024;
    const auto distance = [&, end = point + step * direction](const CellTriangle &facet) {
        return length(end - nearest_on_triangle(facet, end));
    };
    double least = step;
    for (const CellTriangle &facet : facets) least = std::min(least, distance(facet));
    const CellTriangle *best = nullptr;
    for (const CellTriangle &facet : facets)
        if (distance(facet) <= least + 2 * on_facet &&
            (!best || std::abs(dot(direction, facet.normal)) > std::abs(dot(direction, best->normal))))
            best = &facet;
    return best ? *best : facets.front();
}

} // namespace

Vec into_solid(const Vec &inward, const Vec &point, std::span<const CellTriangle> facets)
{
    if (facets.empty()) return inward;
    Vec normal = inward;
    for (double depth = 2 * grazing; depth > 1e-3; depth /= 2) { // less and less deep, for sharp edges
        const Vec &face = facing(normal, point, facets).normal;
        const double reached = -dot(normal, face);
        if (reached >= depth / 2) return normal;
        const Vec across = normal + reached * face;
        const double size = length(across);
        if (!(size > 1e-9)) return inward;
        normal = (std::sqrt(1 - depth * depth) / size) * across - depth * face;
    }
    return inward;
}

Sides sides_of(std::span<const Piece> pieces)
{
    Group all;
    for (const Piece &piece : pieces) all.add(piece);
    const double size = length(all.sum);
    const bool against = has_plane(*all.nearest) && dot(all.sum, all.nearest->normal) < 0;
    Sides one{{all.side(), {}}, 1};
    if (pieces.size() == 1 || !(all.area > 0) || (size >= agrees * all.area && !against)) return one;

    std::array<double, 6> spread{};
    for (const Piece &piece : pieces) {
        const Vec &n = piece.normal;
        const double a = piece.area;
        spread[0] += a * n[0] * n[0], spread[1] += a * n[1] * n[1], spread[2] += a * n[2] * n[2];
        spread[3] += a * n[0] * n[1], spread[4] += a * n[0] * n[2], spread[5] += a * n[1] * n[2];
    }
    std::array<Group, 2> group = split(pieces, principal_axis(spread));
    const double product = length(group[0].sum) * length(group[1].sum);
    const bool two =
        group[0].nearest && group[1].nearest &&
        (size < cancels * all.area || (std::min(group[0].area, group[1].area) >= considerable * all.area &&
                                       dot(group[0].sum, group[1].sum) < opposed * product));
    if (!two) {
        if (is_rim(pieces, all))
            group = split(pieces, all.nearest->normal);
        else if (against)
            group = split(pieces, all.sum);
        else
            return one;
    }
    if (!group[0].nearest || !group[1].nearest) return one;
    if (nearer(group[1].nearest, group[0].nearest)) std::swap(group[0], group[1]);
    return {{group[0].side(), group[1].side()}, 2};
}

} // namespace voxshell
