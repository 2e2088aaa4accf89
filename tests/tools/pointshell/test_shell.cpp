// SPDX-License-Identifier: GPL-3.0-or-later
// Whole shells: against analytic solids and against the rules of formats/pointshell.md.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "rules.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <cstring>

using namespace voxshell;

namespace {

bool same(const Shell &a, const Shell &b)
{
    return a.points.size() == b.points.size() && a.clusters.size() == b.clusters.size() &&
           std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(ShellPoint)) == 0 &&
           std::memcmp(a.clusters.data(), b.clusters.data(), a.clusters.size() * sizeof(Cluster)) == 0 &&
           a.area == b.area && a.gap_max == b.gap_max && a.surface_error == b.surface_error &&
           a.center == b.center && a.radius == b.radius;
}

double dot_with_radius(const ShellPoint &p, const Point &center)
{
    double sum = 0, r2 = 0;
    for (int a = 0; a < 3; ++a) {
        const double r = static_cast<double>(p.position[a]) - center[a];
        sum += r * static_cast<double>(p.normal[a]);
        r2 += r * r;
    }
    return sum / std::sqrt(r2);
}

} // namespace

TEST_CASE("a sphere: points on it, normals to its middle, weights its area, gap within 3h")
{
    for (const double h : {0.2, 0.05}) {
        const Made m = make(solids::ball(1, 100, {0.3, 5.1, -2.2}), h);
        check_rules(m);
        CHECK(m.shell.area == doctest::Approx(4 * std::numbers::pi).epsilon(1e-3));
        CHECK(m.shell.surface_error < 5e-7); // an ulp of 5.1
        CHECK(m.shell.points.size() == m.shell.surface_cells);
        for (const ShellPoint &p : m.shell.points) {
            REQUIRE(dot_with_radius(p, {0.3, 5.1, -2.2}) < -0.97);
            double r2 = 0;
            for (int a = 0; a < 3; ++a)
                r2 += std::pow(static_cast<double>(p.position[a]) - Point{0.3, 5.1, -2.2}[a], 2);
            REQUIRE(std::sqrt(r2) <= 1 + 1e-5);
            REQUIRE(std::sqrt(r2) >= 0.9993);
        }
        CHECK(m.shell.radius == doctest::Approx(1).epsilon(0.05));
    }
}

TEST_CASE("a cube on grid planes: one layer, exact areas, mean normals at edges")
{
    const Made m = make(solids::box({0, 0, 0}, {4, 4, 4}), 1);
    check_rules(m);
    // Half-open cells: the upper faces lie in the layer of cells 4, the lower ones in that of cells 0.
    CHECK(m.shell.surface_cells == 5 * 5 * 5 - 3 * 3 * 3);
    CHECK(m.shell.area == 96);
    CHECK(m.shell.surface_error == 0);
    for (const ShellPoint &p : m.shell.points) {
        const Cell c = cell_of(m, p);
        for (int a = 0; a < 3; ++a) // the face's plane: 0 or 4
            if (c[(a + 1) % 3] > 0 && c[(a + 1) % 3] < 4 && c[(a + 2) % 3] > 0 && c[(a + 2) % 3] < 4) {
                CHECK(static_cast<double>(p.position[a]) == (c[a] == 0 ? 0 : 4));
                CHECK(static_cast<double>(p.normal[a]) == (c[a] == 0 ? 1 : -1));
                CHECK(p.area == 1);
            }
    }
}

TEST_CASE("a thin plate inside one layer of cells: two points a cell, opposed normals, half the area each")
{
    const Made m = make(solids::box({-5.5, 0.3, -5.5}, {5.5, 0.4, 5.5}), 1);
    check_rules(m);
    std::size_t pairs = 0;
    for (std::size_t i = 0; i + 1 < m.shell.points.size(); ++i) {
        const ShellPoint &p = m.shell.points[i], &q = m.shell.points[i + 1];
        if (cell_of(m, p) != cell_of(m, q)) continue;
        ++pairs;
        CHECK(static_cast<double>(p.position[1]) == doctest::Approx(0.4).epsilon(1e-4)); // nearer to 0.5
        CHECK(static_cast<double>(q.position[1]) == doctest::Approx(0.3).epsilon(1e-4));
        CHECK(p.normal[1] < -0.7f);
        CHECK(q.normal[1] > 0.7f);
    }
    CHECK(pairs == 144);
    CHECK(m.shell.points.size() == 288);
}

TEST_CASE("a knife edge and a needle: two points a cell along the edge, normals into the metal")
{
    // a prism with an edge of 5 degrees along z
    Mesh knife;
    const double w = 20 * std::tan(2.5 * std::numbers::pi / 180);
    knife.vertices = {{0.5, 10.2, 0.1}, {0.5 - w, -9.8, 0.1}, {0.5 + w, -9.8, 0.1},
                      {0.5, 10.2, 9.9}, {0.5 - w, -9.8, 9.9}, {0.5 + w, -9.8, 9.9}};
    knife.triangles = {{0, 1, 2}, {3, 5, 4}, {0, 3, 1}, {3, 4, 1},
                       {0, 2, 3}, {3, 2, 5}, {1, 4, 2}, {4, 5, 2}};
    for (Triangle &t : knife.triangles) { // outward
        Point c{}, u{}, v{};
        for (int i = 0; i < 3; ++i) {
            c[i] = (knife.vertices[t[0]][i] + knife.vertices[t[1]][i] + knife.vertices[t[2]][i]) / 3;
            u[i] = knife.vertices[t[1]][i] - knife.vertices[t[0]][i],
            v[i] = knife.vertices[t[2]][i] - knife.vertices[t[0]][i];
        }
        const Point n{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        if (n[0] * (c[0] - 0.5) + n[1] * (c[1] + 4) + n[2] * (c[2] - 5) < 0) std::swap(t[1], t[2]);
    }
    const Made m = make(knife, 1);
    check_rules(m);
    std::size_t doubled = 0;
    for (const ShellPoint &p : m.shell.points) {
        const Cell c = cell_of(m, p);
        if (c[1] < 8 || c[1] > 9 || c[2] < 1 || c[2] > 8) continue; // near the edge, off the ends
        ++doubled;
        CHECK(std::abs(p.normal[0]) > 0.9f);
        CHECK((static_cast<double>(p.position[0]) < 0.5) ==
              (p.normal[0] > 0)); // each side pushes to the middle plane
    }
    CHECK(doubled == 2 * 2 * 8);
    check_rules(make(solids::ball(0.2, 20, {0.5, 0.5, 0.5}), 1)); // a whole ball in one cell
    CHECK(make(solids::ball(0.2, 20, {0.5, 0.5, 0.5}), 1).shell.points.size() == 2);
}

TEST_CASE("scale and place: the same shell at 1 um and 1 km, and shifted by whole cells")
{
    const Mesh ball = solids::ball(1, 40, {0.01, 0.02, 0.03});
    const Made m = make(ball, 0.125);
    for (const double scale : {0x1p-20, 0x1p10}) {
        Mesh scaled = ball;
        for (Point &p : scaled.vertices)
            for (double &x : p) x *= scale;
        const Made s = make(scaled, 0.125 * scale);
        check_rules(s);
        REQUIRE(s.shell.points.size() == m.shell.points.size());
        for (std::size_t i = 0; i < m.shell.points.size(); ++i) {
            for (int a = 0; a < 3; ++a)
                REQUIRE(static_cast<double>(s.shell.points[i].position[a]) ==
                        static_cast<double>(m.shell.points[i].position[a]) * scale);
            REQUIRE(s.shell.points[i].normal == m.shell.points[i].normal);
        }
    }
    Mesh far = ball; // 8 km off: floats are 2^-11 m apart there, still many to a cell
    for (Point &p : far.vertices) p[0] += 8192;
    const Made f = make(far, 0.125);
    check_rules(f);
    CHECK(f.shell.points.size() == m.shell.points.size());
    CHECK(f.shell.surface_error < 0x1p-11);
    for (Point &p : far.vertices) p[0] += 1e9; // floats are 64 m apart: nothing fits, nothing breaks
    check_rules(make(far, 0.125), false);
}

TEST_CASE("the naive shell: centres, the same normals and weights")
{
    const Mesh mesh = solids::ball(1, 30, {0.1, 0.2, 0.3});
    const Made e = make(mesh, 0.25), n = make(mesh, 0.25, ShellKind::naive);
    check_rules(n);
    REQUIRE(n.shell.points.size() == e.shell.points.size());
    for (std::size_t i = 0; i < n.shell.points.size(); ++i) {
        const Cell c = cell_of(n, n.shell.points[i]);
        for (int a = 0; a < 3; ++a)
            CHECK(static_cast<double>(n.shell.points[i].position[a]) ==
                  0.25 * (static_cast<double>(c[a]) + 0.5));
        CHECK(n.shell.points[i].normal == e.shell.points[i].normal);
        CHECK(n.shell.points[i].area == e.shell.points[i].area);
    }
    CHECK(n.shell.surface_error > 0.05);
    CHECK(n.shell.surface_error <= 0.25 * std::sqrt(0.75));
    CHECK(n.shell.gap_max == doctest::Approx(0.25 * std::sqrt(2.0)));
}

TEST_CASE("degenerate, duplicate, soup, huge triangles: unit normals and all rules all the same")
{
    check_rules(make(solids::random_soup(200, 1, 0.3), 0.03));
    check_rules(make(solids::random_soup(20, 2, 40), 0.5));
    Mesh m = solids::random_soup(50, 3, 0.3);
    solids::append(m, Mesh(m));
    check_rules(make(m, 0.05));
    Mesh bad = solids::box({0, 0, 0}, {1, 1, 1});
    bad.vertices.push_back({3, 3, 3});
    bad.vertices.push_back({5, 4, 3.5});
    bad.triangles.push_back({8, 8, 8});
    bad.triangles.push_back({8, 9, 9}); // a segment of its own
    bad.triangles.push_back({0, 7, 0}); // a segment through the box
    check_rules(make(bad, 0.1));
    Mesh only; // nothing that has a plane
    only.vertices = {{0.5, 0.5, 0.5}, {2.5, 2.5, 2.5}};
    only.triangles = {{0, 1, 1}, {0, 0, 0}};
    const Made o = make(only, 1);
    check_rules(o);
    CHECK(o.shell.area == 0);
    CHECK(o.shell.points.size() == 3);
    Mesh wide; // 4000 cells, a sliver
    wide.vertices = {{0, 0, 0}, {4000, 30, 0.5}, {4000, 30.001, 0.5}};
    wide.triangles = {{0, 1, 2}};
    check_rules(make(wide, 1));
}

TEST_CASE("the same bytes for any thread count")
{
    Mesh mesh = solids::ball(1, 60);
    solids::append(mesh, solids::random_soup(300, 9, 0.5));
    std::vector<Shell> made;
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        made.push_back(make(mesh, 0.02).shell);
    }
    CHECK(same(made[0], made[1]));
    CHECK(same(made[0], made[2]));
}
