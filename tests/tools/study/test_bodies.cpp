// SPDX-License-Identifier: GPL-3.0-or-later
// The studies' bodies are closed and outward; their paths touch them where they say.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "study/bodies.hpp"
#include "study/paper_path.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

using namespace voxshell;
using doctest::Approx;

namespace {

constexpr double pi = std::numbers::pi;

double volume(const Mesh &mesh)
{
    double sum = 0;
    for (const Triangle &t : mesh.triangles) {
        const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6;
}

bool is_closed(const Mesh &mesh)
{
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
    for (const Triangle &t : mesh.triangles) {
        for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
    }
    for (const auto &[edge, count] : edges) {
        const auto twin = edges.find({edge.second, edge.first});
        if (count != 1 || twin == edges.end() || twin->second != 1) return false;
    }
    return !edges.empty();
}

} // namespace

TEST_CASE("closed, outward, as large as they should be")
{
    const struct {
        Mesh mesh;
        double volume;
    } all[] = {
        {ball(2), 32 * pi / 3},
        {cylinder(3, 2), 36 * pi},
        {cup(40, 34, 80, 6), pi * (40 * 40 * 80 - 34 * 34 * 74)},
        {holed_block(10, 20, 20), pi * 300 * 20},
        {slab(10, 3, 4), 1600},
        {groove(pi / 3, 50, 15, 12), 30 * (2 * (50 / std::sqrt(3) + 12) * 62 - 50 * 50 / std::sqrt(3))},
        {tilted(slab(10, 3, 4)), 1600}};
    for (const auto &each : all) {
        CHECK(is_closed(each.mesh));
        CHECK(volume(each.mesh) == Approx(each.volume).epsilon(1e-3));
    }
}

TEST_CASE("the table: every scenario has its own id, what it compares, and one body a name")
{
    std::set<std::string> ids;
    std::map<std::string, std::size_t> bodies;
    for (const Scenario &scenario : paper_scenarios()) {
        CHECK(ids.insert(scenario.id).second);
        CHECK(!scenario.variants.empty());
        CHECK(!scenario.levels.empty());
        CHECK(is_loop(scenario) == !scenario.speeds.empty());
        for (const double level : scenario.levels) {
            for (unsigned seed = 1; seed <= 3; ++seed) {
                const Body body = standing_body(scenario, level, seed);
                const auto [found, is_new] = bodies.emplace(body.name, body.mesh.vertices.size());
                CHECK(found->second == body.mesh.vertices.size());
            }
        }
    }
    for (const char *id : {"fig8a", "fig8b", "fig8c", "fig8d", "fig9a", "fig9b", "fig11", "fig12a", "fig12b",
                           "fig12c", "fig12d", "wedge", "peg", "wall"}) {
        CHECK(ids.count(id) == 1);
    }
}

TEST_CASE("a path keeps its depth")
{
    for (const char *id : {"fig8c", "fig9a"}) {
        const Scenario &scenario = paper_scenario(id);
        const Path path(scenario, 0.5, 7);
        CHECK(path.ticks() == 3000);
        for (std::size_t tick = 0; tick < path.ticks(); tick += 97) {
            const Path::Step step = path.at(tick);
            const double *p = step.pose.position;
            const double high = std::string(id) == "fig9a" ? std::hypot(p[0], p[1]) - 30e-3
                                                           : p[0] * step.axes[0][0] + p[1] * step.axes[0][1] +
                                                                 p[2] * step.axes[0][2];
            CHECK(20e-3 - high == Approx(0.5e-3).epsilon(1e-9));
            const Point frame = along(step, step.axes[1].data());
            CHECK(frame[1] == Approx(1));
            CHECK(std::abs(frame[0]) + std::abs(frame[2]) < 1e-12);
        }
    }
    // 15 e and 50 e less the depth, once in 3 s.
    CHECK(Path(paper_scenario("fig8c"), 0.5, 7).crossing_hz() == Approx(2 * pi * 15 / 3));
    CHECK(Path(paper_scenario("fig9a"), 0.5, 7).crossing_hz() == Approx(2 * pi * 49.5 / 3));
}

TEST_CASE("degenerate is what lies along the grid, and nothing else")
{
    const auto first = [](const char *id) { return Path(paper_scenario(id), 0.5, 3).at(0); };
    CHECK(is_degenerate(first("degenerate-a")));
    Path::Step step = first("degenerate-a");
    const double quarter[4] = {std::sqrt(0.5), 0, std::sqrt(0.5), 0}, bit[4] = {1, 1e-3, 0, 0};
    std::copy_n(quarter, 4, step.pose.orientation);
    CHECK(is_degenerate(step));
    std::copy_n(bit, 4, step.pose.orientation);
    CHECK_FALSE(is_degenerate(step));
    for (const char *id : {"fig8a", "fig8c", "fig9a", "control9-turned"})
        CHECK_FALSE(is_degenerate(first(id)));
}

TEST_CASE("pressed into the groove, the ideal force leads up, and aslant where one wall is nearer")
{
    const Path even(paper_scenario("wedge"), 1, 1), aslant(paper_scenario("wedge"), 0.5, 1);
    const auto local = [](const Path::Step &step) { return along(step, step.ideal_force.data()); };
    const Point up = local(even.at(1500)), side = local(aslant.at(1500));
    CHECK(up[0] > 0);
    CHECK(std::abs(up[1]) < 1e-9 * up[0]);
    // 1 e and 0.5 e deep: caps of d d (R - d / 3), each wall's normal 60 degrees from upwards.
    const double one = 1e-6 * (20e-3 - 1e-3 / 3), other = 0.25e-6 * (20e-3 - 0.5e-3 / 3);
    CHECK(side[0] == Approx((one + other) / 2));
    CHECK(std::abs(side[1]) == Approx((one - other) * std::sqrt(3) / 2));
}

TEST_CASE("the peg: in a hole of its own size both ends are pressed, and nothing is with play")
{
    CHECK(Path(paper_scenario("peg"), 19.0, 1).at(200).ideal_force == Point{});
    const Path::Step tight = Path(paper_scenario("peg"), 20.2, 1).at(299);
    const Point &t = tight.ideal_torque, &f = tight.ideal_force;
    CHECK(std::abs(t[0]) > 1e3 * std::abs(t[1]));
    CHECK(std::hypot(f[0], f[1]) < 0.3 * std::abs(t[0]) / 0.01);
    CHECK(t[0] < 0); // leaning over to -y at the top by a turn about +x: pushed back
}
