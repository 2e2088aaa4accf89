// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "mesh/report.hpp"

#include "mesh/edges.hpp"
#include "mesh/weld.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>

using namespace voxshell;

TEST_CASE("a box, indexed or as soup")
{
    for (const Mesh &m :
         {solids::box({0, 0, 0}, {1, 2, 3}), solids::soup(solids::box({0, 0, 0}, {1, 2, 3}))}) {
        const MeshReport r = report(m);
        CHECK(r.triangles == 12);
        CHECK(r.degenerate + r.duplicate + r.boundary_edges + r.non_manifold_edges + r.badly_wound_edges ==
              0);
        CHECK(r.shells == 1);
        CHECK(r.closed);
        CHECK(r.oriented);
        CHECK(r.area == doctest::Approx(22).epsilon(1e-15));
        CHECK(r.volume == doctest::Approx(6).epsilon(1e-15));
    }
}

TEST_CASE("a sphere's area and volume converge from below, far from the origin too")
{
    const MeshReport r = report(solids::ball(0.5e-3, 200, {1e4, -1e4, 1e4}));
    const double volume = std::numbers::pi / 6 * 1e-9, area = std::numbers::pi * 1e-6;
    CHECK(r.closed);
    CHECK(r.volume == doctest::Approx(volume).epsilon(1e-3));
    CHECK(r.area == doctest::Approx(area).epsilon(1e-3));
}

TEST_CASE("-0 and 0 are one place")
{
    Mesh m;
    m.vertices = {{0.0, 1, 2}, {-0.0, 1, 2}, {0.0, 1, 2.0000000000000004}};
    const Weld w = weld(m);
    CHECK(w.count == 2);
    CHECK(w.of == std::vector<std::uint32_t>{0, 0, 1});
}

TEST_CASE("open, inverted, badly wound")
{
    Mesh m = solids::box({0, 0, 0}, {1, 1, 1});
    solids::invert(m);
    CHECK(report(m).volume == doctest::Approx(-1));
    CHECK(report(m).oriented);
    std::swap(m.triangles[0][0], m.triangles[0][1]);
    CHECK_FALSE(report(m).oriented);
    CHECK(report(m).closed);
    CHECK(report(m).badly_wound_edges == 3);
    m.triangles.pop_back();
    const MeshReport r = report(m);
    CHECK_FALSE(r.closed);
    CHECK(r.boundary_edges == 3);
    CHECK(r.volume == 0);
}

TEST_CASE("two boxes that share an edge; every face tripled")
{
    Mesh m = solids::box({0, 0, 0}, {1, 1, 1});
    solids::append(m, solids::box({1, 1, 0}, {2, 2, 1}));
    MeshReport r = report(m);
    CHECK(r.non_manifold_edges == 1);
    CHECK(r.shells == 1);
    CHECK(r.closed);
    CHECK(r.oriented);
    const Mesh once = solids::box({0, 0, 0}, {1, 1, 1});
    Mesh thrice = once;
    solids::append(thrice, once);
    solids::append(thrice, once);
    r = report(thrice);
    CHECK(r.duplicate == 24);
    CHECK(r.non_manifold_edges == 18);
    CHECK(r.closed);
    solids::append(m, solids::box({5, 5, 5}, {6, 6, 6}));
    CHECK(report(m).shells == 2);
}

TEST_CASE("triangles without area: collapsed and stray ones are left out, plugs are not")
{
    Mesh m = solids::box({0, 0, 0}, {1, 1, 1});
    m.triangles.push_back({0, 0, 1});
    m.triangles.push_back({2, 2, 2});
    m.vertices.push_back({0.5, 0, 0}); // 8, in the middle of edge 0-1
    m.triangles.push_back({0, 1, 8});  // closes nothing: the box is closed without it
    MeshReport r = report(m);
    CHECK(r.degenerate == 3);
    CHECK(r.closed);
    CHECK(r.boundary_edges + r.non_manifold_edges == 0);
    CHECK(edges(m).facets[14] == Facet::stray);

    // A T-junction: the triangle 0 1 4 is cut at 8 and 9, its neighbour keeps the long edge 0 1.
    Mesh t = solids::box({0, 0, 0}, {1, 1, 1});
    t.vertices.push_back({0.25, 0, 0}); // 8
    t.vertices.push_back({0.5, 0, 0});  // 9
    t.triangles[4] = {0, 8, 4};
    t.triangles.push_back({8, 9, 4});
    t.triangles.push_back({9, 1, 4});
    r = report(t);
    CHECK_FALSE(r.closed);
    CHECK(r.boundary_edges == 4);
    t.triangles.push_back({0, 1, 9});
    t.triangles.push_back({0, 9, 8});
    r = report(t);
    CHECK(r.closed);
    CHECK(r.oriented);
    CHECK(r.degenerate == 2);
    CHECK(r.boundary_edges == 0);
    CHECK(r.volume == doctest::Approx(1));
    CHECK(edges(t).facets[14] == Facet::plug);
    // in millimetres read as metres: collinear only up to rounding
    for (Point &p : t.vertices)
        for (double &x : p) x = (x + 0.1) * 1e-3 + 7e-4;
    CHECK(report(t).degenerate == 2);
    CHECK(report(t).closed);
}

TEST_CASE("nothing, and nothing but degenerate triangles")
{
    CHECK(report(Mesh{}).shells == 0);
    CHECK_FALSE(report(Mesh{}).closed);
    Mesh m;
    m.vertices = {{1, 1, 1}};
    m.triangles = {{0, 0, 0}};
    const MeshReport r = report(m);
    CHECK(r.degenerate == 1);
    CHECK_FALSE(r.closed);
    CHECK(r.area == 0);
}
