// SPDX-License-Identifier: GPL-3.0-or-later
// Exact clipping with CGAL's rational numbers, and input built to hurt. Shares no code with the tools.
#pragma once

#include "voxmap/voxelize.hpp"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <random>
#include <vector>

namespace exact {

using namespace voxshell;

using Number = CGAL::Exact_predicates_exact_constructions_kernel::FT;
using Vertex = std::array<Number, 3>;

/// The polygon of the triangle inside the closed box, by Sutherland-Hodgman with exact numbers. May be a
/// segment or a point; empty if they do not meet.
inline std::vector<Vertex> clip(const std::array<LatticePoint, 3> &triangle, const LatticePoint &low,
                                const LatticePoint &high)
{
    std::vector<Vertex> polygon;
    for (const LatticePoint &p : triangle)
        polygon.push_back({Number(static_cast<double>(p[0])), Number(static_cast<double>(p[1])),
                           Number(static_cast<double>(p[2]))});
    for (int axis = 0; axis < 3; ++axis)
        for (const int sign : {1, -1}) {
            const Number limit(static_cast<double>(sign > 0 ? high[axis] : -low[axis]));
            const auto outside = [&](const Vertex &v) -> Number { return sign * v[axis] - limit; };
            std::vector<Vertex> kept;
            for (std::size_t v = 0; v < polygon.size(); ++v) {
                const Vertex &a = polygon[v], &b = polygon[(v + 1) % polygon.size()];
                const Number da = outside(a), db = outside(b);
                if (da <= 0) kept.push_back(a);
                if ((da < 0 && db > 0) || (da > 0 && db < 0)) {
                    const Number t = da / (da - db);
                    Vertex cut;
                    for (int c = 0; c < 3; ++c) cut[c] = a[c] + t * (b[c] - a[c]);
                    kept.push_back(cut);
                }
            }
            polygon.swap(kept);
            if (polygon.empty()) return polygon;
        }
    return polygon;
}

/// Does a convex polygon inside the closed box hold a point of [low, high)? One that does not lies in one of
/// the three upper faces.
inline bool reaches_in(const std::vector<Vertex> &polygon, const LatticePoint &high)
{
    if (polygon.empty()) return false;
    for (int axis = 0; axis < 3; ++axis) {
        bool below = false;
        for (const Vertex &v : polygon) below = below || v[axis] < Number(static_cast<double>(high[axis]));
        if (!below) return false;
    }
    return true;
}

/// Does the closed triangle hold a point of [low, high)?
inline bool meets(const std::array<LatticePoint, 3> &triangle, const LatticePoint &low,
                  const LatticePoint &high)
{
    return reaches_in(clip(triangle, low, high), high);
}

inline LatticeMesh one(const std::array<LatticePoint, 3> &triangle)
{
    LatticeMesh mesh;
    mesh.voxel = 1;
    mesh.vertices.assign(triangle.begin(), triangle.end());
    mesh.triangles = {{0, 1, 2}};
    mesh.min = mesh.max = {triangle[0][0] >> 16, triangle[0][1] >> 16, triangle[0][2] >> 16};
    for (const LatticePoint &p : triangle)
        for (int a = 0; a < 3; ++a) {
            mesh.min[a] = std::min(mesh.min[a], p[a] >> 16);
            mesh.max[a] = std::max(mesh.max[a], p[a] >> 16);
        }
    return mesh;
}

inline LatticePoint corner_of(const Cell &cell)
{
    return {cell[0] * lattice_per_cell, cell[1] * lattice_per_cell, cell[2] * lattice_per_cell};
}

struct Pick {
    std::mt19937_64 random{20011};
    std::int64_t between(std::int64_t low, std::int64_t high)
    {
        return low + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(high - low + 1));
    }
    /// A coordinate that likes planes, half planes and their lattice neighbours.
    std::int64_t coordinate(std::int64_t reach)
    {
        switch (between(0, 3)) {
        case 0:
            return between(-reach, reach);
        case 1:
            return between(-reach, reach) >> 16 << 16;
        case 2:
            return (between(-reach, reach) >> 16 << 16) + between(-1, 1);
        default:
            return between(-reach, reach) >> 15 << 15;
        }
    }
    std::array<LatticePoint, 3> triangle(std::int64_t reach)
    {
        std::array<LatticePoint, 3> t;
        for (LatticePoint &p : t)
            for (std::int64_t &c : p) c = coordinate(reach);
        switch (between(0, 9)) {
        case 0:
            t[1][2] = t[0][2], t[2][2] = t[0][2];
            break; // flat on a plane
        case 1:
            t[2] = t[1];
            break; // a segment
        case 2:
            t[1] = t[0], t[2] = t[0];
            break; // a point
        case 3:
            t[2] = {t[1][0] + between(-1, 1), t[1][1] + between(-1, 1), t[1][2] + between(-1, 1)};
            break; // a sliver
        case 4:    // collinear
            for (int a = 0; a < 3; ++a)
                t[1][a] = t[0][a] + 2 * ((t[2][a] - t[0][a]) / 2),
                t[2][a] = t[0][a] + (t[1][a] - t[0][a]) / 2;
            break;
        case 5: // along the cell diagonal
            for (int a = 0; a < 3; ++a) t[1][a] = t[0][a] + (t[1][0] - t[0][0]);
            break;
        default:
            break;
        }
        return t;
    }
};

inline Number dot(const Vertex &a, const Vertex &b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vertex minus(const Vertex &a, const Vertex &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vertex cross(const Vertex &a, const Vertex &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The point of a convex, plane polygon nearest to `from`: the foot of the perpendicular where it is inside,
/// else the nearest of the edges' nearest points.
inline Vertex nearest(const std::vector<Vertex> &polygon, const Vertex &from)
{
    Vertex normal{0, 0, 0};
    for (std::size_t v = 2; v < polygon.size() && dot(normal, normal) == 0; ++v)
        normal = cross(minus(polygon[v - 1], polygon[0]), minus(polygon[v], polygon[0]));
    const Number square = dot(normal, normal);
    if (square != 0) {
        const Number height = dot(minus(polygon[0], from), normal) / square;
        const Vertex foot{from[0] + height * normal[0], from[1] + height * normal[1],
                          from[2] + height * normal[2]};
        bool inside = true;
        for (std::size_t v = 0; v < polygon.size() && inside; ++v) {
            const Vertex &a = polygon[v], &b = polygon[(v + 1) % polygon.size()];
            inside = dot(cross(minus(b, a), minus(foot, a)), normal) >= 0;
        }
        if (inside) return foot;
    }
    Vertex best = polygon[0];
    Number least = dot(minus(best, from), minus(best, from));
    for (std::size_t v = 0; v < polygon.size(); ++v) {
        const Vertex &a = polygon[v], edge = minus(polygon[(v + 1) % polygon.size()], a);
        const Number length2 = dot(edge, edge);
        Number t = length2 == 0 ? Number(0) : dot(minus(from, a), edge) / length2;
        if (t < 0) t = 0;
        if (t > 1) t = 1;
        const Vertex at{a[0] + t * edge[0], a[1] + t * edge[1], a[2] + t * edge[2]};
        const Number d2 = dot(minus(at, from), minus(at, from));
        if (d2 < least) least = d2, best = at;
    }
    return best;
}

} // namespace exact
