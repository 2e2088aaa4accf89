// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "mesh/mend.hpp"

#include "mesh/report.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>

#include <algorithm>

using namespace voxshell;

namespace {

// A ball in two halves, drawn apart by `gap` along y: one ring of cracks.
Mesh cracked(double gap)
{
    const Mesh whole = solids::ball(1, 16);
    Mesh m = solids::soup(whole);
    for (std::size_t t = 0; t < m.triangles.size(); ++t) {
        double top = 0;
        for (const std::uint32_t v : m.triangles[t]) top += m.vertices[v][1];
        if (top > 0)
            for (const std::uint32_t v : m.triangles[t]) m.vertices[v][1] += gap;
    }
    return m;
}

std::vector<std::array<std::int64_t, 3>> snapped(const Mesh &mesh, double unit)
{
    std::vector<std::array<std::int64_t, 3>> out;
    for (const Point &p : mesh.vertices)
        out.push_back({std::llround(p[0] / unit), std::llround(p[1] / unit), std::llround(p[2] / unit)});
    return out;
}

} // namespace

TEST_CASE("a crack of 1e-6 is closed within 2e-6 and left within 1e-7")
{
    const Mesh before = cracked(1e-6);
    CHECK(report(before).boundary_edges == 64);
    Mesh m = before;
    StitchReport r = stitch(m, 1e-7);
    CHECK(r.vertices == 0);
    CHECK(r.closed_edges == 0);
    CHECK(m.vertices == before.vertices);

    r = stitch(m, 2e-6);
    CHECK(r.vertices == 32);
    CHECK(r.closed_edges == 64);
    CHECK(r.farthest == doctest::Approx(1e-6));
    CHECK(report(m).closed);
    CHECK(report(m).shells == 1);
    CHECK(report(m).degenerate == 0);
    CHECK(m.triangles == before.triangles);
    for (std::size_t v = 0; v < m.vertices.size(); ++v)
        for (int i = 0; i < 3; ++i) CHECK(std::abs(m.vertices[v][i] - before.vertices[v][i]) <= 1.0001e-6);
    CHECK(stitch(m, 2e-6).vertices == 0);
}

TEST_CASE("every triangle torn loose, each corner somewhere else")
{
    Mesh m = solids::soup(solids::ball(1, 16));
    std::mt19937 random(3);
    for (Point &p : m.vertices)
        for (double &x : p) x += 1e-7 * (static_cast<double>(random()) / 4294967295.0);
    CHECK(report(m).shells == m.triangles.size());
    CHECK(stitch(m, 1e-6).closed_edges == 3 * m.triangles.size());
    CHECK(report(m).closed);
    CHECK(report(m).shells == 1);
}

TEST_CASE("no triangle collapses, however large the tolerance; closed meshes do not move")
{
    Mesh m = cracked(1e-3);
    stitch(m, 0.3); // edges are 0.2 long
    CHECK(report(m).degenerate == 0);
    CHECK(report(m).closed);
    const Mesh box = solids::box({0, 0, 0}, {1, 1, 1});
    m = box;
    CHECK(stitch(m, 10).vertices == 0);
    CHECK(m.vertices == box.vertices);
}

TEST_CASE("a T-junction with a gap is left and counted")
{
    Mesh m = solids::box({0, 0, 0}, {1, 1, 1});
    m.vertices.push_back({0.5, -1e-6, 0}); // 8
    m.triangles[4] = {0, 8, 4};
    m.triangles.push_back({8, 1, 4});
    CHECK(stitch(m, 1e-5).closed_edges == 0);
    CHECK(report(m).boundary_edges == 3);
    m.triangles.push_back({0, 1, 8}); // what is left of the box's edge: a sliver, and closed
    CHECK(report(m).closed);
}

TEST_CASE("cracks below the lattice are gone on it")
{
    const Mesh m = cracked(1e-6);
    CHECK(open_edges(snapped(m, 1e-4), m.triangles) == 0);
    CHECK(open_edges(snapped(m, 1e-7), m.triangles) == 64);
    const Mesh tripled = [] {
        Mesh t = solids::box({0, 0, 0}, {1, 1, 1});
        t.triangles.push_back(t.triangles[0]);
        return t;
    }();
    CHECK(open_edges(snapped(tripled, 1e-3), tripled.triangles) == 3); // used three times
    CHECK(open_edges({}, {}) == 0);
}
