// SPDX-License-Identifier: GPL-3.0-or-later
// The voxeliser against exact clipping: no cell may differ, on input built to hurt.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "exact.hpp"

#include <set>

using namespace exact;

namespace {

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
