// SPDX-License-Identifier: GPL-3.0-or-later
// The projection against an oracle of another kind: enumeration of everything where the nearest point of a
// triangle inside a box can lie, in long double.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "pointshell/project.hpp"

#include "voxmap/voxelize.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

using namespace voxshell;

namespace {

using Real = long double;
using Vec3 = std::array<Real, 3>;

Vec3 sub(const Vec3 &a, const Vec3 &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Real inner(const Vec3 &a, const Vec3 &b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec3 outer(const Vec3 &a, const Vec3 &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Candidates of argmin |p| over T and the box |x| <= 1/2: the foot on T's plane; on each of T's edges the
// point nearest to 0 and the points where it passes a face plane, and its ends; on each line where T's plane
// passes a face plane the point nearest to 0; and T's plane on each of the box's twelve edges. The nearest
// feasible one is the minimum.
struct Oracle {
    std::array<Vec3, 3> t;
    Vec3 n{};
    Real slack = 1e-13L;
    std::optional<Vec3> best;

    explicit Oracle(const CellTriangle &triangle)
    {
        for (int v = 0; v < 3; ++v)
            for (int i = 0; i < 3; ++i) t[v][i] = static_cast<Real>(triangle.lattice[v][i]) / 65536;
        n = outer(sub(t[1], t[0]), sub(t[2], t[0]));
        const Real n2 = inner(n, n);
        if (n2 > 0) offer(scaled(n, inner(n, t[0]) / n2));
        for (int v = 0; v < 3; ++v) edge(t[v], t[(v + 1) % 3]);
        if (!(n2 > 0)) return;
        for (int i = 0; i < 3; ++i)
            for (const Real c : {-0.5L, 0.5L}) {
                // line {x_i = c, n.x = n.t0}: its point nearest to 0 lies in the span of e_i and n
                Vec3 m = n;
                m[i] = 0;
                const Real m2 = inner(m, m);
                if (m2 > 0) {
                    Vec3 p = scaled(m, (inner(n, t[0]) - n[i] * c) / m2);
                    p[i] = c;
                    offer(p);
                }
                const int j = (i + 1) % 3, k = (i + 2) % 3; // box edges along k
                if (n[k] == 0) continue;
                for (const Real d : {-0.5L, 0.5L}) {
                    Vec3 p{};
                    p[i] = c, p[j] = d, p[k] = (inner(n, t[0]) - n[i] * c - n[j] * d) / n[k];
                    offer(p);
                }
            }
    }
    static Vec3 scaled(const Vec3 &v, Real s) { return {v[0] * s, v[1] * s, v[2] * s}; }
    void edge(const Vec3 &a, const Vec3 &b)
    {
        const Vec3 e = sub(b, a);
        const auto at = [&](Real s) {
            if (s >= 0 && s <= 1) offer({a[0] + s * e[0], a[1] + s * e[1], a[2] + s * e[2]}, true);
        };
        at(0);
        at(1);
        if (inner(e, e) > 0) at(-inner(a, e) / inner(e, e));
        for (int i = 0; i < 3; ++i)
            if (e[i] != 0)
                for (const Real c : {-0.5L, 0.5L}) at((c - a[i]) / e[i]);
    }
    void offer(const Vec3 &p, bool on_triangle = false)
    {
        for (const Real x : p)
            if (std::abs(x) > 0.5L + slack) return;
        if (!on_triangle)
            for (int v = 0; v < 3; ++v) { // outside by more than the slack?
                const Vec3 e = sub(t[(v + 1) % 3], t[v]);
                if (inner(outer(e, sub(p, t[v])), n) < -slack * std::sqrt(inner(e, e) * inner(n, n))) return;
            }
        if (!best || inner(p, p) < inner(*best, *best)) best = p;
    }
};

struct Tally {
    int count[6] = {};
    int pairs = 0;
    double worst = 0; // distance from the oracle's point [cells]
};

void check_cell(const LatticeMesh &mesh, const Cell &cell, Tally &tally)
{
    const auto &[a, b, c] = mesh.triangles[0];
    const CellTriangle seen =
        seen_from(cell, lattice_triangle(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]));
    const Projection p = project(seen);
    const Oracle oracle(seen);
    REQUIRE(oracle.best);
    ++tally.pairs;
    ++tally.count[static_cast<int>(p.situation)];
    Real off2 = 0;
    for (int i = 0; i < 3; ++i) {
        REQUIRE(std::abs(p.point[i]) <= 0.5);
        off2 += (static_cast<Real>(p.point[i]) - (*oracle.best)[i]) *
                (static_cast<Real>(p.point[i]) - (*oracle.best)[i]);
    }
    const double off = static_cast<double>(std::sqrt(off2));
    tally.worst = std::max(tally.worst, off);
    CHECK(p.distance2 ==
          doctest::Approx(static_cast<double>(inner(*oracle.best, *oracle.best))).epsilon(1e-11));
    const Vec on = nearest_on_triangle(seen, p.point) - p.point;
    CHECK(dot(on, on) < 1e-20);
    CHECK(p.area >= 0);
    CHECK(p.area <= 1.4142135623730952); // the largest plane section of a cube
}

LatticeMesh one(const std::array<LatticePoint, 3> &v)
{
    LatticeMesh mesh;
    mesh.voxel = 1;
    mesh.vertices.assign(v.begin(), v.end());
    mesh.triangles = {{0, 1, 2}};
    return mesh;
}

// All cells of the brick at `corner` that the triangle meets.
void check_brick(const LatticeMesh &mesh, const Cell &corner, Tally &tally, int most = 512)
{
    std::array<std::uint64_t, 8> met{};
    triangle_cells(mesh, 0, corner, met);
    for (int c = 0; c < 512; ++c)
        if ((met[c >> 6] >> (c & 63) & 1) && most-- > 0)
            check_cell(mesh, {corner[0] + (c >> 6), corner[1] + (c >> 3 & 7), corner[2] + (c & 7)}, tally);
}

constexpr std::int64_t unit = lattice_per_cell;

Projection project_in_origin_cell(const Vec &a, const Vec &b, const Vec &c) // of [0, 1)^3, corners in cells
{
    const auto snap = [](const Vec &v) {
        return LatticePoint{std::llround(v[0] * 65536), std::llround(v[1] * 65536),
                            std::llround(v[2] * 65536)};
    };
    return project(seen_from({0, 0, 0}, lattice_triangle(snap(a), snap(b), snap(c))));
}

void check_point(const Projection &p, ProjectionCase situation, const Vec &expect)
{
    CHECK(p.situation == situation);
    for (int i = 0; i < 3; ++i) CHECK(p.point[i] + 0.5 == doctest::Approx(expect[i]).epsilon(1e-12));
}

} // namespace

TEST_CASE("case 1: the foot is in the cell and in the triangle")
{
    check_point(project_in_origin_cell({-3, 0.25, -3}, {0.5, 0.25, 5}, {5, 0.25, -3}), ProjectionCase::foot,
                {0.5, 0.25, 0.5});
}

TEST_CASE("case 2: the foot is in the cell, the triangle ends before it")
{
    // the nearest point of the triangle is inside the cell
    check_point(project_in_origin_cell({0.75, 0.5, -3}, {3, 0.5, 0.5}, {0.75, 0.5, 3}),
                ProjectionCase::foot_in_cell, {0.75, 0.5, 0.5});
    // a corner
    check_point(project_in_origin_cell({0.75, 0.25, 0.5}, {3, 0.25, 0.25}, {3, 0.25, 0.75}),
                ProjectionCase::foot_in_cell, {0.75, 0.25, 0.5});
}

// Cases 3 and 4 on the plane x + 8 y = 8.75: its foot from the centre is (0.565, 1.023, 0.5), above the cell,
// and the plane leaves the cell through its top at x = 0.75.
TEST_CASE("case 3: the foot is in the triangle, but outside the cell")
{
    check_point(project_in_origin_cell({-7.25, 2, -9}, {-7.25, 2, 9}, {24.75, -2, 0.5}),
                ProjectionCase::foot_in_face, {0.75, 1, 0.5});
    // cut by a corner only: x + y + 4 z = 5.875 has its foot at (0.660, 0.660, 1.139), the cut's nearest on z
    // = 1 and x = y
    const Projection p = project_in_origin_cell({-8.125, -10, 6}, {13.875, -10, 0.5}, {-8.125, 12, 0.5});
    check_point(p, ProjectionCase::foot_in_face, {0.9375, 0.9375, 1});
}

TEST_CASE("case 4, the paper's figure 4: the foot is in neither")
{
    // The triangle begins right of the foot, inside the cell: its nearest point counts.
    check_point(project_in_origin_cell({0.875, 0.984375, -3}, {0.875, 0.984375, 4}, {8.75, 0, 0.5}),
                ProjectionCase::foot_off_near, {0.875, 0.984375, 0.5});
    // It begins between the foot and the cell: its nearest point is outside, the cut with the cell's surface
    // counts.
    check_point(project_in_origin_cell({0.65625, 1.01171875, -3}, {0.65625, 1.01171875, 4}, {8.75, 0, 0.5}),
                ProjectionCase::foot_off_cut, {0.75, 1, 0.5});
}

TEST_CASE("all cases, with the cut and without, in random triangles of every size")
{
    std::mt19937_64 random(11);
    Tally tally;
    for (const std::int64_t size : {unit / 4, unit, 3 * unit, 20 * unit, 4096 * unit}) {
        std::uniform_int_distribution<std::int64_t> near(-4 * unit, 12 * unit), far(-size, size);
        for (int k = 0; k < 1000; ++k) {
            const LatticePoint a{near(random), near(random), near(random)};
            LatticePoint b = a, c = a;
            for (int i = 0; i < 3; ++i) b[i] += far(random), c[i] += far(random);
            check_brick(one({a, b, c}), {0, 0, 0}, tally, 40);
        }
    }
    MESSAGE(tally.pairs << " pairs; cases " << tally.count[1] << " " << tally.count[2] << " "
                        << tally.count[3] << " " << tally.count[4] << " " << tally.count[5] << "; worst "
                        << tally.worst << " cells");
    CHECK(tally.pairs > 20000);
    for (int s = 1; s <= 5; ++s) CHECK(tally.count[s] > 20);
    CHECK(tally.worst < 1e-9);
}

TEST_CASE("built to hurt: corners on planes, edges and corners of cells, slivers of one lattice unit, "
          "segments, points")
{
    std::mt19937_64 random(12);
    Tally tally;
    std::uniform_int_distribution<std::int64_t> cell(-3, 11), kind(0, 9), tiny(-2, 2);
    const auto coordinate = [&] {
        const std::int64_t k = kind(random);
        return cell(random) * unit + (k < 6 ? 0 : k < 8 ? unit / 2 : tiny(random));
    };
    for (int k = 0; k < 6000; ++k) {
        LatticePoint a{coordinate(), coordinate(), coordinate()}, b{coordinate(), coordinate(), coordinate()},
            c;
        switch (kind(random)) {
        case 0:
            c = b;
            for (auto &x : c) x += tiny(random);
            break; // sliver
        case 1:
            for (int i = 0; i < 3; ++i) c[i] = (a[i] + b[i]) / 2;
            break; // sliver or segment
        case 2:
            c = b;
            break; // segment
        case 3:
            c = b = a;
            break; // point
        case 4:
            for (int i = 0; i < 3; ++i) b[i] = a[i] + 4096 * (b[i] - a[i]), c[i] = b[i] + tiny(random);
            break;
        default:
            c = {coordinate(), coordinate(), coordinate()};
        }
        check_brick(one({a, b, c}), {0, 0, 0}, tally, 60);
    }
    MESSAGE(tally.pairs << " pairs; cases " << tally.count[1] << " " << tally.count[2] << " "
                        << tally.count[3] << " " << tally.count[4] << " " << tally.count[5] << "; worst "
                        << tally.worst << " cells");
    CHECK(tally.pairs > 30000);
    CHECK(tally.worst < 1e-7);
}

TEST_CASE("the areas of all cells sum to the triangle's, also on planes that cells share")
{
    std::mt19937_64 random(13);
    std::uniform_int_distribution<std::int64_t> anywhere(0, 8 * unit - 1), plane(0, 7);
    for (int k = 0; k < 3000; ++k) {
        std::array<LatticePoint, 3> v;
        for (auto &p : v) p = {anywhere(random), anywhere(random), anywhere(random)};
        if (k % 3 == 0) // on a grid plane
            for (auto &p : v) p[k / 3 % 3] = v[0][k / 3 % 3] / unit * unit;
        if (k % 3 == 1) // a sliver
            v[2] = {v[1][0] + 1, v[1][1], v[1][2]};
        const LatticeMesh mesh = one(v);
        std::array<std::uint64_t, 8> met{};
        triangle_cells(mesh, 0, {0, 0, 0}, met);
        const LatticeTriangle t = lattice_triangle(v[0], v[1], v[2]);
        double sum = 0;
        for (int c = 0; c < 512; ++c)
            if (met[c >> 6] >> (c & 63) & 1) sum += project(seen_from({c >> 6, c >> 3 & 7, c & 7}, t)).area;
        const CellTriangle whole = seen_from({0, 0, 0}, t);
        const Vec n = cross(whole.corner[1] - whole.corner[0], whole.corner[2] - whole.corner[0]);
        CHECK(sum == doctest::Approx(std::sqrt(dot(n, n)) / 2).epsilon(1e-9));
    }
}

TEST_CASE("the normal of a sliver one unit wide and 4096 cells long is right to the last bits")
{
    const LatticeTriangle t =
        lattice_triangle({0, 0, 0}, {4096 * unit, 4096 * unit, 0}, {4096 * unit + 1, 4096 * unit, 0});
    CHECK(t.normal == Vec{0, 0, -1});
    const std::int64_t far = std::int64_t{1} << 35;
    const LatticeTriangle u = lattice_triangle({0, 0, 0}, {far, far, 1}, {far, far - 1, 0});
    // n = (far * 0 - 1 * (far - 1), 1 * far - far * 0, far (far - 1) - far far) = (1 - far, far, -far)
    const double s = std::sqrt(3.0);
    CHECK(u.normal[0] == doctest::Approx(-1 / s).epsilon(1e-9));
    CHECK(u.normal[1] == doctest::Approx(1 / s).epsilon(1e-9));
    CHECK(u.normal[2] == doctest::Approx(-1 / s).epsilon(1e-9));
    CHECK(lattice_triangle({1, 1, 1}, {2, 2, 2}, {far, far, far}).normal == Vec{});
}
