// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "cli/failure.hpp"
#include "pointshell/pointshell_file.hpp"
#include "written_file.hpp"

#include <algorithm>
#include <cmath>
#include <random>

using namespace voxshell;

namespace {

/// n random points with unit normals; spheres wide enough.
PointshellFile random_shell(std::uint32_t n, std::uint32_t seed)
{
    std::mt19937 random(seed);
    const auto uniform = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
    PointshellFile file;
    file.meta = R"({"of":"random"})";
    file.source_hash.fill(static_cast<std::uint8_t>(seed));
    Shell &shell = file.shell;
    shell.kind = seed % 2 ? ShellKind::exact : ShellKind::naive;
    shell.voxel = 0.01;
    for (std::uint32_t p = 0; p < n; ++p) {
        const double z = uniform(), angle = 4 * uniform(), r = std::sqrt(1 - z * z);
        shell.points.push_back({.position = {static_cast<float>(uniform()), static_cast<float>(uniform()),
                                             static_cast<float>(uniform())},
                                .normal = {static_cast<float>(r * std::cos(angle)),
                                           static_cast<float>(r * std::sin(angle)), static_cast<float>(z)},
                                .area = static_cast<float>(1e-4 * (1 + uniform())),
                                .brick = 0,
                                .cell = 0});
        shell.area += shell.points.back().area;
    }
    for (std::uint32_t first = 0; first < n; first += 64)
        shell.clusters.push_back({{0.125f, -0.25f, 0}, 2, first, std::min(64u, n - first)});
    shell.gap_max = 0.02;
    shell.surface_error = 1e-9;
    shell.center = {0.1, 0, 0};
    shell.radius = 1.9;
    shell.surface_cells = n / 2 + 1;
    return file;
}

} // namespace

TEST_CASE("a shell comes back as it was, for every remainder of lanes and clusters")
{
    for (const std::uint32_t n : {1u, 2u, 15u, 16u, 17u, 63u, 64u, 65u, 79u, 80u, 81u, 128u, 129u, 5000u}) {
        CAPTURE(n);
        const PointshellFile written = random_shell(n, n);
        const auto bytes = pointshell_bytes(written);
        const WrittenFile file(bytes);
        const PointshellFile read = read_pointshell(file.path());
        const Shell &a = written.shell, &b = read.shell;
        CHECK(a.kind == b.kind);
        CHECK(a.voxel == b.voxel);
        CHECK(a.area == b.area);
        CHECK(a.gap_max == b.gap_max);
        CHECK(a.surface_error == b.surface_error);
        CHECK(a.center == b.center);
        CHECK(a.radius == b.radius);
        CHECK(a.surface_cells == b.surface_cells);
        CHECK(written.source_hash == read.source_hash);
        CHECK(written.meta == read.meta);
        CHECK(std::ranges::equal(a.points, b.points, [](const ShellPoint &p, const ShellPoint &q) {
            return p.position == q.position && p.normal == q.normal && p.area == q.area;
        }));
        CHECK(std::ranges::equal(a.clusters, b.clusters, [](const Cluster &c, const Cluster &d) {
            return c.center == d.center && c.radius == d.radius && c.first == d.first && c.count == d.count;
        }));
        CHECK(pointshell_bytes(read) == bytes);
    }
}

TEST_CASE("shells that are none are refused")
{
    PointshellFile file = random_shell(100, 1);
    file.shell.clusters[1].count = 35;
    CHECK_THROWS_AS(pointshell_bytes(file), Failure);
    file = random_shell(100, 1);
    file.shell.clusters.pop_back();
    CHECK_THROWS_AS(pointshell_bytes(file), Failure);
    file = random_shell(100, 1);
    file.shell.clusters[1].first = 63;
    CHECK_THROWS_AS(pointshell_bytes(file), Failure);
    CHECK_THROWS_AS(pointshell_bytes(PointshellFile{}), Failure);
}
