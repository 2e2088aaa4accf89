// SPDX-License-Identifier: GPL-3.0-or-later
// Thinned shells: what stays, what is left out, and the bounds that hold; and the clusters of all shells.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "rules.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <cstring>
#include <numbers>
#include <set>

using namespace voxshell;

namespace {

constexpr double degree = std::numbers::pi / 180;

Made make_thin(const Mesh &mesh, double voxel, double degrees)
{
    Progress silent;
    Made m;
    m.mesh = snap(mesh, voxel);
    const BrickTriangles binned = bin_triangles(m.mesh, silent);
    m.cells = voxelize(m.mesh, binned, silent);
    m.shell = make_shell(m.mesh, binned, m.cells, ShellKind::exact, silent, degrees * degree);
    return m;
}

using Key = std::array<float, 6>;
Key key(const ShellPoint &p)
{
    return {p.position[0], p.position[1], p.position[2], p.normal[0], p.normal[1], p.normal[2]};
}

double distance(const ShellPoint &p, const ShellPoint &q)
{
    double d2 = 0;
    for (int a = 0; a < 3; ++a)
        d2 += std::pow(static_cast<double>(p.position[a]) - static_cast<double>(q.position[a]), 2);
    return std::sqrt(d2);
}

/// Whatever the part: a subset of the whole shell's points, unmoved; the same area; and its own account is
/// right. Returns the largest distance of a point left out from the nearest kept one, found the slow way.
double check_thinned(const Made &whole, const Made &thin, double degrees)
{
    const Shell &all = whole.shell, &few = thin.shell;
    std::set<Key> before, after;
    for (const ShellPoint &p : all.points) before.insert(key(p));
    double area = 0;
    for (const ShellPoint &p : few.points) {
        REQUIRE(before.count(key(p)) == 1);
        after.insert(key(p));
        area += static_cast<double>(p.area);
    }
    CHECK(few.area == all.area);
    CHECK(area == doctest::Approx(all.area).epsilon(1e-6));
    CHECK(few.gap_max <= 3 * few.voxel * (1 + 1e-6));
    CHECK(few.thinning.points_before == all.points.size());
    CHECK(few.thinning.gap_before == all.gap_max);
    CHECK(1 - std::cos(few.thinning.normal_max) <= 1 - std::cos(degrees * degree) + 2e-6);
    CHECK(few.surface_cells <= few.points.size());

    double farthest = 0;
    for (const ShellPoint &p : all.points) {
        if (after.count(key(p))) continue;
        double nearest = INFINITY;
        for (const ShellPoint &q : few.points) nearest = std::min(nearest, distance(p, q));
        farthest = std::max(farthest, nearest);
    }
    CHECK(farthest <= few.thinning.distance_max * (1 + 1e-12));
    return farthest;
}

} // namespace

TEST_CASE("a large plane keeps about a quarter of its points, in rows")
{
    const Mesh slab = solids::box({0.1, 0.2, 0.3}, {40.3, 12.4, 40.1});
    const Made whole = make(slab, 1), thin = make_thin(slab, 1, 1);
    check_thinned(whole, thin, 1);
    std::size_t before = 0, after = 0; // of the upper face, away from its rim
    const auto count = [](const Made &m, std::size_t &n) {
        for (const ShellPoint &p : m.shell.points) {
            const bool inner =
                p.position[0] > 3 && p.position[0] < 37 && p.position[2] > 3 && p.position[2] < 37;
            if (p.normal[1] > -0.999f || !inner) continue;
            ++n;
        }
    };
    count(whole, before), count(thin, after);
    CHECK(static_cast<double>(after) == doctest::Approx(static_cast<double>(before) / 4).epsilon(0.1));
    CHECK(thin.shell.gap_max == doctest::Approx(std::sqrt(8.0)).epsilon(0.07));
    CHECK(thin.shell.thinning.distance_max == doctest::Approx(std::sqrt(2.0)).epsilon(1e-5));
    CHECK(thin.shell.thinning.normal_max < 1e-3);
    for (const ShellPoint &p : thin.shell.points) // edges and corners stay as they are
        CHECK((p.area <= 2.3f ||
               std::abs(p.normal[0]) + std::abs(p.normal[1]) + std::abs(p.normal[2]) < 1.001f));
}

TEST_CASE("a ball, a tilted box, a soup: the bounds hold, and a larger angle leaves fewer points")
{
    const Mesh parts[] = {solids::ball(1, 60, {0.3, 0.1, -0.2}), solids::random_soup(30, 5, 0.5),
                          solids::box({-1.03, -0.71, 0.33}, {0.97, 0.44, 1.28})};
    for (const Mesh &mesh : parts) {
        const Made whole = make(mesh, 0.06);
        std::size_t last = whole.shell.points.size() + 1;
        for (const double degrees : {0.1, 3.0, 10.0, 30.0}) {
            const Made thin = make_thin(mesh, 0.06, degrees);
            check_thinned(whole, thin, degrees);
            CHECK(thin.shell.points.size() <= last);
            last = thin.shell.points.size();
        }
        CHECK(last < whole.shell.points.size());
    }
}

TEST_CASE("thin walls keep both of their points")
{
    const Mesh plate = solids::box({-5.5, 0.3, -5.5}, {5.5, 0.4, 5.5});
    CHECK(make_thin(plate, 1, 30).shell.points.size() == make(plate, 1).shell.points.size());
}

TEST_CASE("the same bytes for any thread count, and clusters that are small")
{
    Mesh mesh = solids::ball(1, 60);
    solids::append(mesh, solids::random_soup(100, 9, 0.5));
    std::vector<Shell> made;
    for (const std::size_t threads : {1, 2}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        made.push_back(make_thin(mesh, 0.02, 5).shell);
    }
    REQUIRE(made[0].points.size() == made[1].points.size());
    CHECK(std::memcmp(made[0].points.data(), made[1].points.data(),
                      made[0].points.size() * sizeof(ShellPoint)) == 0);
    CHECK(made[0].gap_max == made[1].gap_max);
    CHECK(made[0].thinning.distance_max == made[1].thinning.distance_max);

    const Made ball = make(solids::ball(1, 100), 0.01);
    double sum = 0, largest = 0;
    for (const Cluster &c : ball.shell.clusters) {
        sum += static_cast<double>(c.radius) / 0.01;
        largest = std::max(largest, static_cast<double>(c.radius) / 0.01);
    }
    CHECK(sum / static_cast<double>(ball.shell.clusters.size()) <
          6); // 64 cells of a plane: 5.7 at the least, less where it lies askew
    CHECK(largest < 30);
}
