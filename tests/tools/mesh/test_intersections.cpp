// SPDX-License-Identifier: GPL-3.0-or-later
// Against an oracle that forms every pair's intersection in exact numbers and asks whether it is more than
// the vertex or the edge that both have.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "mesh/intersections.hpp"

#include "mesh/edges.hpp"
#include "solids.hpp"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <filesystem>
#include <vector>

using namespace voxshell;

namespace {

using Exact = CGAL::Exact_predicates_exact_constructions_kernel;
constexpr std::uint64_t all = ~std::uint64_t{0};
Progress silent;

std::uint64_t brute_force(const Mesh &mesh)
{
    std::vector<Exact::Triangle_3> triangles;
    for (const Triangle &t : mesh.triangles) {
        std::array<Exact::Point_3, 3> p;
        for (int v = 0; v < 3; ++v) {
            const Point &at = mesh.vertices[t[v]];
            p[v] = {at[0], at[1], at[2]};
        }
        triangles.emplace_back(p[0], p[1], p[2]);
    }
    std::vector<bool> meets(triangles.size(), false);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (std::size_t s = t + 1; s < triangles.size(); ++s) {
            if (!CGAL::do_overlap(triangles[t].bbox(), triangles[s].bbox())) continue;
            std::vector<Exact::Point_3> shared;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    if (triangles[t][i] == triangles[s][j]) shared.push_back(triangles[t][i]);
            if (shared.size() == 3) continue;
            const auto common = CGAL::intersection(triangles[t], triangles[s]);
            if (!common) continue;
            if (const auto *point = boost::get<Exact::Point_3>(&*common)) {
                if (std::count(shared.begin(), shared.end(), *point)) continue;
            } else if (const auto *segment = boost::get<Exact::Segment_3>(&*common)) {
                if (shared.size() == 2 && (*segment == Exact::Segment_3(shared[0], shared[1]) ||
                                           *segment == Exact::Segment_3(shared[1], shared[0])))
                    continue;
            }
            meets[t] = meets[s] = true;
        }
    return static_cast<std::uint64_t>(std::count(meets.begin(), meets.end(), true));
}

std::uint64_t found(const Mesh &mesh)
{
    return self_intersections(mesh, all, silent).value();
}

} // namespace

TEST_CASE("solids have none; a pair that pierces, touches, lies upon")
{
    CHECK(found(solids::box({0, 0, 0}, {1, 2, 3})) == 0);
    CHECK(found(solids::soup(solids::ball(1, 16))) == 0);
    CHECK(found(Mesh{}) == 0);
    Mesh m;
    m.vertices = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, -1}, {1, 1, 1}, {2, 9, 0}};
    m.triangles = {{0, 1, 2}, {3, 4, 5}};
    CHECK(found(m) == 2);
    m.vertices[3] = {1, 1, 0}; // a corner upon the face
    CHECK(found(m) == 2);
    m.vertices[3] = {1, 1, 0x1p-40};
    CHECK(found(m) == 0);
    m.vertices = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {1, 1, 0}, {9, 1, 0}, {1, 9, 0}}; // in one plane
    CHECK(found(m) == 2);
    m.triangles = {{0, 1, 2}, {0, 1, 3}}; // folded upon each other along an edge
    CHECK(found(m) == 2);
    m.vertices[3] = {1, -1, 0};
    CHECK(found(m) == 0);
    m.triangles = {{0, 1, 2}, {1, 2, 0}, {2, 1, 0}}; // duplicates, either way round
    CHECK(found(m) == 0);
}

TEST_CASE("a T-junction with its sliver touches, two boxes that overlap cut")
{
    Mesh m = solids::box({0, 0, 0}, {2, 2, 2});
    solids::append(m, solids::box({1, 1, 1}, {3, 3, 3}));
    CHECK(found(m) == brute_force(m));
    CHECK(found(m) >= 12);
}

TEST_CASE("random soups, on a coarse grid too, for any number of threads")
{
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        Mesh m = solids::random_soup(120, seed, seed % 2 ? 0.3 : 1.0);
        if (seed > 6) // ties of all kinds
            for (Point &p : m.vertices)
                for (double &x : p) x = std::round(x * 5);
        m.triangles.erase(std::remove_if(m.triangles.begin(), m.triangles.end(),
                                         [&](const Triangle &t) {
                                             return zero_area(m.vertices[t[0]], m.vertices[t[1]],
                                                              m.vertices[t[2]]);
                                         }),
                          m.triangles.end());
        const std::uint64_t count = found(m);
        CAPTURE(seed);
        CHECK(count == brute_force(m));
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1 + seed % 3);
        CHECK(found(m) == count);
    }
}

TEST_CASE("too many pairs are not checked")
{
    Mesh m = solids::random_soup(2000, 1, 1.0);
    CHECK_FALSE(self_intersections(m, 1000, silent).has_value());
    CHECK(self_intersections(m, all, silent).has_value());
}

TEST_CASE("hard meshes")
{
    const std::filesystem::path folder = std::filesystem::path(VXS_TEST_DATA) / "hard";
    if (!std::filesystem::exists(folder)) return;
    for (const char *name :
         {"three_cubes_overlapping.stl", "trimesh_soup.stl", "thingi10k_100827.stl", "thingi10k_69166.stl",
          "thingi10k_49886.stl", "trimesh_shared_edge.STL", "thingi10k_68435.stl"}) {
        ImportOptions options;
        options.unit = 1.0;
        Mesh m = flatten(import_scene(folder / name, options));
        m.triangles.erase(std::remove_if(m.triangles.begin(), m.triangles.end(),
                                         [&](const Triangle &t) {
                                             return zero_area(m.vertices[t[0]], m.vertices[t[1]],
                                                              m.vertices[t[2]]);
                                         }),
                          m.triangles.end());
        CAPTURE(name);
        CHECK(found(m) == brute_force(m));
    }
}
