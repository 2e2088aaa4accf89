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

double length(const Vec &v)
{
    return std::sqrt(dot(v, v));
}
bool has_plane(const Piece &piece)
{
    return piece.normal[0] != 0 || piece.normal[1] != 0 || piece.normal[2] != 0;
}

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

struct Group {
    const Piece *nearest = nullptr;
    const Piece *nearest_plane = nullptr; // the nearest one that has a plane
    double area = 0;
    Vec sum{}; // of area n
    double planes = 0;
    Vec normals{}; // of n
    void add(const Piece &piece)
    {
        if (!nearest || piece.distance2 < nearest->distance2) nearest = &piece;
        if (!has_plane(piece)) return;
        if (!nearest_plane || piece.distance2 < nearest_plane->distance2) nearest_plane = &piece;
        area += piece.area;
        sum = sum + piece.area * piece.normal;
        planes += 1;
        normals = normals + piece.normal;
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

// Pieces on the axis' side first; those without a plane go with the larger side.
std::array<Group, 2> split(std::span<const Piece> pieces, const Vec &axis)
{
    std::array<Group, 2> group;
    for (const Piece &piece : pieces)
        if (has_plane(piece)) group[dot(piece.normal, axis) < 0].add(piece);
    Group &larger = group[group[1].area > group[0].area];
    for (const Piece &piece : pieces)
        if (!has_plane(piece)) larger.add(piece);
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

} // namespace

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
    const auto nearer = [](const Piece *a, const Piece *b) {
        return a->distance2 != b->distance2 ? a->distance2 < b->distance2 : a->triangle < b->triangle;
    };
    if (nearer(group[1].nearest, group[0].nearest)) std::swap(group[0], group[1]);
    return {{group[0].side(), group[1].side()}, 2};
}

} // namespace voxshell
