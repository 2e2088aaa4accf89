// SPDX-License-Identifier: GPL-3.0-or-later
// Shell points against exact projection: argmin |p - c| over the triangle inside the closed cell, in rational
// numbers.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "exact.hpp"
#include "pointshell/shell.hpp"

#include <cmath>

using namespace exact;

namespace {

struct Tally {
    std::uint64_t pairs = 0, off = 0, outside = 0, normals = 0;
    double worst_ulp = 0;
};

float ulp(double at)
{
    const float x = std::abs(static_cast<float>(at));
    return std::nextafter(x, INFINITY) - x;
}

/// The shell of one triangle, voxel 1 m, so that metres are cells: every point where exact arithmetic puts
/// it, to one ulp of its float32 coordinate.
void compare(const std::array<LatticePoint, 3> &t, Tally &tally)
{
    const LatticeMesh mesh = one(t);
    Progress silent;
    const BrickTriangles binned = bin_triangles(mesh, silent);
    const Cells cells = voxelize(mesh, binned, silent);
    const Shell shell = make_shell(mesh, binned, cells, ShellKind::exact, silent);
    CHECK(shell.points.size() == cells.surface_cells);
    for (const ShellPoint &p : shell.points) {
        Cell cell;
        Vertex center;
        const int local[3] = {p.cell >> 6, p.cell >> 3 & 7, p.cell & 7};
        for (int a = 0; a < 3; ++a) {
            cell[a] = cells.origin[a] + 8 * std::int64_t{cells.bricks[p.brick].at[a]} + local[a];
            center[a] = Number(static_cast<double>(cell[a]) * 65536 + 32768);
        }
        const std::vector<Vertex> polygon =
            clip(t, corner_of(cell), corner_of({cell[0] + 1, cell[1] + 1, cell[2] + 1}));
        REQUIRE_FALSE(polygon.empty());
        const Vertex expected = nearest(polygon, center);
        bool off = false;
        for (int a = 0; a < 3; ++a) {
            // to_double of a lazy number is right to 1e-5 only; of its exact value to the last bit.
            const double exact_value = CGAL::to_double(CGAL::exact(expected[a])) / 65536,
                         got = static_cast<double>(p.position[a]);
            const double error = std::abs(got - exact_value) / static_cast<double>(ulp(exact_value));
            tally.worst_ulp = std::max(tally.worst_ulp, std::abs(exact_value) > 1e-3 ? error : 0);
            // Near zero an ulp is finer than what decides: two edges of a sliver may offer points whose
            // squared distances agree to the last bit of a double. They lie within 1e-9 cells, 1/15000 of a
            // lattice unit.
            off = off || (error > 1.0 && std::abs(got - exact_value) > 1e-9);
            tally.outside += got < static_cast<double>(cell[a]) || got > static_cast<double>(cell[a] + 1);
        }
        tally.off += off;
        const double length = std::hypot(static_cast<double>(p.normal[0]), static_cast<double>(p.normal[1]),
                                         static_cast<double>(p.normal[2]));
        tally.normals += !(std::abs(length - 1) <= 1e-6);
        ++tally.pairs;
    }
}

void check(const Tally &tally)
{
    CHECK(tally.off == 0);
    CHECK(tally.outside == 0);
    CHECK(tally.normals == 0);
    MESSAGE(tally.pairs << " points, at most " << tally.worst_ulp << " ulp off");
}

} // namespace

TEST_CASE("small triangles full of ties")
{
    Pick pick;
    Tally tally;
    for (int n = 0; n < 8000; ++n) compare(pick.triangle(n % 2 ? 3 << 16 : 40000), tally);
    check(tally);
    CHECK(tally.pairs > 50000);
}

TEST_CASE("larger triangles, many cells each")
{
    Pick pick;
    Tally tally;
    for (int n = 0; n < 150; ++n) compare(pick.triangle(20 << 16), tally);
    check(tally);
    CHECK(tally.pairs > 20000);
}
