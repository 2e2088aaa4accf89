// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "mesh/orient.hpp"

#include "mesh/report.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>

using namespace voxshell;

namespace {

void mix(Mesh &mesh, std::uint32_t seed)
{
    std::mt19937 random(seed);
    for (Triangle &t : mesh.triangles)
        if (random() & 1) std::swap(t[1], t[2]);
}

// Outer box with a cavity, a loose ball in the cavity, a second part beside it: right as it stands.
Mesh nested()
{
    Mesh m = solids::box({-3, -3, -3}, {3, 3, 3});
    Mesh cavity = solids::ball(2, 12);
    solids::invert(cavity);
    solids::append(m, cavity);
    solids::append(m, solids::ball(1, 10));
    solids::append(m, solids::box({4, 0, 0}, {5, 1, 1}));
    return m;
}

} // namespace

TEST_CASE("a right mesh stays as it is")
{
    Mesh m = nested();
    const auto before = m.triangles;
    const OrientReport r = orient(m);
    CHECK(r.flipped == 0);
    CHECK(r.shells_flipped == 0);
    CHECK(m.triangles == before);
}

TEST_CASE("an inside-out assembly is turned, its cavity keeps facing the cavity")
{
    const Mesh right = nested();
    Mesh m = right;
    solids::invert(m);
    const OrientReport r = orient(m);
    CHECK(r.flipped == m.triangles.size());
    CHECK(r.shells_flipped == 4);
    CHECK(report(m).volume == doctest::Approx(report(right).volume));
}

TEST_CASE("one inside-out part among right ones")
{
    Mesh m = solids::box({0, 0, 0}, {1, 1, 1}), b = solids::box({2, 0, 0}, {3, 1, 1});
    solids::invert(b);
    solids::append(m, solids::soup(b));
    CHECK(report(m).volume == doctest::Approx(0));
    CHECK(orient(m).shells_flipped == 1);
    CHECK(report(m).volume == doctest::Approx(2));
}

TEST_CASE("mixed winding becomes consistent and outward")
{
    for (std::uint32_t seed = 1; seed < 20; ++seed) {
        Mesh m = solids::soup(solids::ball(1e-3, 12, {1e3, 0, 0}));
        const double volume = report(m).volume;
        mix(m, seed);
        const OrientReport r = orient(m);
        CHECK(r.flipped > 0);
        const MeshReport after = report(m);
        CHECK(after.oriented);
        CHECK(after.volume == doctest::Approx(volume));
    }
}

TEST_CASE("surfaces in pieces: cracks everywhere, one piece in five turned")
{
    const Mesh whole = solids::ball(1, 16);
    Mesh m = solids::soup(whole);
    std::mt19937 random(3);
    for (Point &p : m.vertices)
        for (double &x : p) x += 1e-7 * (static_cast<double>(random()) / 4294967295.0);
    std::size_t turned = 0;
    for (std::size_t t = 0; t < m.triangles.size(); t += 5, ++turned)
        std::swap(m.triangles[t][1], m.triangles[t][2]);
    CHECK(orient(m).flipped == turned);
}

TEST_CASE("faces that lie on each other are turned one by one")
{
    const Mesh once = solids::box({0, 0, 0}, {1, 1, 1});
    Mesh m = once, inverted = once;
    solids::invert(inverted);
    solids::append(m, once);
    solids::append(m, inverted);
    orient(m);
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        const auto expect = once.triangles[t % 12];
        CHECK(m.triangles[t] == Triangle{expect[0] + 8 * static_cast<std::uint32_t>(t / 12),
                                         expect[1] + 8 * static_cast<std::uint32_t>(t / 12),
                                         expect[2] + 8 * static_cast<std::uint32_t>(t / 12)});
    }
}

TEST_CASE("boxes that share an edge, boxes that share a face")
{
    for (const Point &low : {Point{1, 1, 0}, Point{1, 0, 0}}) {
        Mesh m = solids::box({0, 0, 0}, {1, 1, 1});
        Mesh b = solids::box(low, {low[0] + 1, low[1] + 1, low[2] + 1});
        solids::invert(b);
        solids::append(m, b);
        orient(m);
        CHECK(report(m).volume == doctest::Approx(2));
    }
}

TEST_CASE("an open sheet keeps the winding of most of its area")
{
    Mesh m;
    m.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {3, 0, 0}, {3, 1, 0}};
    m.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 4}, {4, 2, 5}}; // the second half is larger and turned
    const auto before = m.triangles;
    const OrientReport r = orient(m);
    CHECK(r.flipped == 2);
    CHECK(r.shells_flipped == 0);
    CHECK(report(m).badly_wound_edges == 0);
    CHECK(m.triangles[2] == before[2]);
}

TEST_CASE("a cup without a lid has a side; a Moebius band ends")
{
    Mesh cup = solids::box({0, 0, 0}, {1, 1, 1});
    cup.triangles.erase(cup.triangles.begin() + 6, cup.triangles.begin() + 8);
    const auto right = cup.triangles;
    solids::invert(cup);
    orient(cup);
    CHECK(cup.triangles == right);

    Mesh band;
    constexpr std::uint32_t n = 12;
    for (std::uint32_t i = 0; i < n; ++i) {
        const double turn = 2 * std::numbers::pi * i / n;
        for (const double side : {-0.3, 0.3}) {
            const double r = 1 + side * std::cos(turn / 2);
            band.vertices.push_back({r * std::cos(turn), r * std::sin(turn), side * std::sin(turn / 2)});
        }
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t a = 2 * i, b = 2 * i + 1;
        const std::uint32_t c = i + 1 < n ? a + 2 : 1, d = i + 1 < n ? a + 3 : 0;
        band.triangles.push_back({a, c, b});
        band.triangles.push_back({b, c, d});
    }
    orient(band);
    CHECK(report(band).badly_wound_edges >= 1);
}

TEST_CASE("degenerate meshes")
{
    Mesh m;
    CHECK(orient(m).flipped == 0);
    m.vertices = {{1, 1, 1}, {2, 2, 2}, {3, 3, 3}};
    m.triangles = {{0, 0, 0}, {0, 1, 2}, {0, 1, 1}};
    CHECK(orient(m).flipped == 0);
}
