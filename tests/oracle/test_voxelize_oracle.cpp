// SPDX-License-Identifier: GPL-3.0-or-later
// The voxeliser against exact clipping: no cell may differ, on input built to hurt.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "voxmap/voxelize.hpp"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <random>
#include <set>

using namespace voxshell;

namespace {

using Number = CGAL::Exact_predicates_exact_constructions_kernel::FT;
using Vertex = std::array<Number, 3>;

/// Does the closed triangle hold a point of [low, high)? Sutherland-Hodgman with exact numbers gives the
/// polygon of the triangle inside the closed box; a convex polygon that avoids the half-open box lies in one
/// of its three upper faces.
bool meets(const std::array<LatticePoint, 3> &triangle, const LatticePoint &low, const LatticePoint &high)
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
            if (polygon.empty()) return false;
        }
    for (int axis = 0; axis < 3; ++axis) {
        bool below = false;
        for (const Vertex &v : polygon) below = below || v[axis] < Number(static_cast<double>(high[axis]));
        if (!below) return false;
    }
    return true;
}

LatticeMesh one(const std::array<LatticePoint, 3> &triangle)
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

LatticePoint corner_of(const Cell &cell)
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

/// All cells of the triangle's box, grown by one, against the oracle. Returns the number of pairs.
std::uint64_t compare(const std::array<LatticePoint, 3> &t)
{
    const LatticeMesh mesh = one(t);
    Progress silent;
    const Cells cells = voxelize(mesh, bin_triangles(mesh, silent), silent);
    std::uint64_t pairs = 0;
    Cell c;
    for (c[0] = mesh.min[0] - 1; c[0] <= mesh.max[0] + 1; ++c[0])
        for (c[1] = mesh.min[1] - 1; c[1] <= mesh.max[1] + 1; ++c[1])
            for (c[2] = mesh.min[2] - 1; c[2] <= mesh.max[2] + 1; ++c[2]) {
                const bool expected = meets(t, corner_of(c), corner_of({c[0] + 1, c[1] + 1, c[2] + 1}));
                const bool got = cell_state(cells, c) == VXS_CELL_SURFACE;
                ++pairs;
                if (expected != got) {
                    CAPTURE(t[0][0]);
                    CAPTURE(t[0][1]);
                    CAPTURE(t[0][2]);
                    CAPTURE(t[1][0]);
                    CAPTURE(t[1][1]);
                    CAPTURE(t[1][2]);
                    CAPTURE(t[2][0]);
                    CAPTURE(t[2][1]);
                    CAPTURE(t[2][2]);
                    CAPTURE(c[0]);
                    CAPTURE(c[1]);
                    CAPTURE(c[2]);
                    CHECK(expected == got);
                }
            }
    return pairs;
}

} // namespace

TEST_CASE("small triangles full of ties: every cell as the exact oracle says")
{
    Pick pick;
    std::uint64_t pairs = 0;
    for (int n = 0; n < 4000; ++n) pairs += compare(pick.triangle(n % 2 ? 3 << 16 : 40000));
    MESSAGE(pairs << " triangle-cell pairs");
    CHECK(pairs >= 100000);
}

TEST_CASE("triangles across brick and chunk borders, far from the origin")
{
    Pick pick;
    for (int n = 0; n < 30; ++n) {
        std::array<LatticePoint, 3> t = pick.triangle(5 << 16);
        const std::int64_t far = std::int64_t{10'000'000'000} << 16; // 10 km in cells of 1 um
        for (LatticePoint &p : t) p[0] += far, p[1] -= far, p[2] += std::int64_t{64} << 16;
        compare(t);
    }
}

TEST_CASE("one triangle over 4000 cells and more: random cells near its plane")
{
    Pick pick;
    for (const std::int64_t size : {4000, 6000, 20000}) { // 6000 and 20000 take the wide path
        const std::int64_t reach = size << 15;
        for (int n = 0; n < 4; ++n) {
            std::array<LatticePoint, 3> t;
            for (LatticePoint &p : t)
                for (std::int64_t &c : p) c = pick.coordinate(reach);
            if (n == 0) t[2] = {t[1][0] + 1, t[1][1], t[1][2] - 1}; // a sliver one lattice unit wide
            const LatticeMesh mesh = one(t);
            for (int s = 0; s < 300; ++s) {
                // A point of the triangle by integer barycentric weights; the cells around it decide.
                const std::int64_t u = pick.between(0, 1000), v = pick.between(0, 1000 - u), w = 1000 - u - v;
                Cell near, brick;
                for (int a = 0; a < 3; ++a) {
                    near[a] = ((t[0][a] * u + t[1][a] * v + t[2][a] * w) / 1000 >> 16) + pick.between(-1, 1);
                    brick[a] = near[a] >> 3 << 3;
                }
                std::array<std::uint64_t, 8> met{};
                triangle_cells(mesh, 0, brick, met);
                const bool got = met[near[0] & 7] >> (8 * (near[1] & 7) + (near[2] & 7)) & 1;
                CHECK(got == meets(t, corner_of(near), corner_of({near[0] + 1, near[1] + 1, near[2] + 1})));
            }
        }
    }
}

TEST_CASE("binning finds exactly the bricks that hold a cell of the triangle")
{
    Pick pick;
    Progress silent;
    for (int n = 0; n < 200; ++n) {
        const LatticeMesh mesh = one(pick.triangle(n % 3 ? 20 << 16 : 200 << 16));
        const BrickTriangles binned = bin_triangles(mesh, silent);
        const std::set<BrickAt> bricks(binned.bricks.begin(), binned.bricks.end());
        CHECK(bricks.size() == binned.bricks.size());
        BrickAt last;
        for (int a = 0; a < 3; ++a)
            last[a] = static_cast<std::int32_t>((mesh.max[a] - binned.origin[a]) >> 3);
        BrickAt b;
        for (b[0] = 0; b[0] <= last[0]; ++b[0])
            for (b[1] = 0; b[1] <= last[1]; ++b[1])
                for (b[2] = 0; b[2] <= last[2]; ++b[2]) {
                    std::array<std::uint64_t, 8> met{};
                    triangle_cells(mesh, 0,
                                   {binned.origin[0] + 8 * b[0], binned.origin[1] + 8 * b[1],
                                    binned.origin[2] + 8 * b[2]},
                                   met);
                    std::uint64_t any = 0;
                    for (const std::uint64_t word : met) any |= word;
                    CHECK((any != 0) == bricks.contains(b));
                }
    }
}
