// SPDX-License-Identifier: GPL-3.0-or-later
// Walls of solids that are known, within 2 %.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "mesh/thickness.hpp"

#include "solids.hpp"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

#include <algorithm>

using namespace voxshell;

namespace {

Progress silent;

Mesh turned(std::vector<std::pair<double, double>> profile,
            int segments) // (radius, height), from below round to inside
{
    Mesh m;
    const auto n = static_cast<std::uint32_t>(segments);
    for (const auto &[r, y] : profile)
        for (std::uint32_t j = 0; j < n; ++j) {
            const double a = 2 * std::numbers::pi * j / n;
            m.vertices.push_back({r * std::cos(a), y, r * std::sin(a)});
        }
    for (std::uint32_t i = 0; i + 1 < profile.size(); ++i)
        for (std::uint32_t j = 0; j < n; ++j) {
            const std::uint32_t a = i * n + j, b = i * n + (j + 1) % n, c = a + n, d = b + n;
            if (profile[i].first > 0) m.triangles.push_back({a, d, b});
            if (profile[i + 1].first > 0) m.triangles.push_back({a, c, d});
        }
    return m;
}

Mesh cup(double wall, int segments)
{
    return turned({{0, 0}, {20, 0}, {20, 30}, {20 - wall, 30}, {20 - wall, wall}, {0, wall}}, segments);
}

} // namespace

TEST_CASE("a box: each pair of faces is as thick as they are apart")
{
    const Thickness t = thickness(solids::box({1e3, 0, 0}, {1e3 + 1, 2, 4}), silent);
    CHECK(t.walls.size() + t.sorted_out == t.samples);
    CHECK(t.sorted_out < 40); // rays through the diagonal opposite
    CHECK(t.thinnest == doctest::Approx(1));
    CHECK((t.thinnest_at[0] == doctest::Approx(1e3) || t.thinnest_at[0] == doctest::Approx(1e3 + 1)));
    // Faces of 8, 4 and 2 of 28 in all, twice each.
    CHECK(t.share_below(1.5) == doctest::Approx(16 / 28.0).epsilon(0.02));
    CHECK(t.share_below(3) == doctest::Approx(24 / 28.0).epsilon(0.02));
    CHECK(t.quantile(0.01) == doctest::Approx(1));
    CHECK(t.quantile(0.7) == doctest::Approx(2));
    CHECK(t.quantile(0.99) == doctest::Approx(4));
}

TEST_CASE("a ball is as thick as its diameter, a plate as its height, a cup as its wall")
{
    const Thickness ball = thickness(solids::ball(5e-3, 60), silent);
    CHECK(ball.meaningful());
    CHECK(ball.quantile(0.01) == doctest::Approx(1e-2).epsilon(0.02));
    CHECK(ball.quantile(0.99) == doctest::Approx(1e-2).epsilon(0.02));

    const Thickness plate = thickness(solids::box({0, 0, 0}, {100, 1.5, 80}), silent);
    CHECK(plate.quantile(0.01) == doctest::Approx(1.5));
    CHECK(plate.quantile(0.9) == doctest::Approx(1.5));

    for (const int segments : {24, 48, 200}) {
        const Thickness t = thickness(cup(3, segments), silent);
        CHECK(t.quantile(0.01) == doctest::Approx(3).epsilon(0.02));
        CHECK(t.quantile(0.5) == doctest::Approx(3).epsilon(0.02));
        CHECK(voxel_for_wall(t.quantile(0.01)) == 1);
        CHECK(t.share_below(wall_of(3, 1)) == 0);
        CHECK(t.share_below(wall_of(3, 2)) > 0.8);
    }
}

TEST_CASE("a wedge runs out: shares follow its angle")
{
    Mesh m; // a prism with the triangle (0,0) (10,0) (10,1) and height 10
    for (const double z : {0.0, 10.0})
        for (const auto &[x, y] : {std::pair{0.0, 0.0}, {10.0, 0.0}, {10.0, 1.0}})
            m.vertices.push_back({x, y, z});
    m.triangles = {{0, 2, 1}, {3, 4, 5}, {0, 1, 3}, {1, 4, 3}, {1, 2, 4}, {2, 5, 4}, {2, 0, 5}, {0, 3, 5}};
    const Thickness t = thickness(m, silent);
    const double slope = std::sqrt(101.0), area = 10 * 10 + 10 * slope + 10 + 10;
    // On the base the wall is x / 10; on the slope, s from its edge, the ray leaves through the base at s
    // / 10.
    const double share = (10 * 5 + 10 * 5) / area;
    CHECK(t.share_below(0.5) == doctest::Approx(share).epsilon(0.02));
    CHECK(t.thinnest < 0.05);
}

TEST_CASE("overlapping and touching solids are one, a cavity ends a wall")
{
    Mesh m = solids::box({0, 0, 0}, {2, 2, 2});
    solids::append(m, solids::box({1, 0.5, 0.5}, {3, 1.5, 1.5}));
    Thickness t = thickness(m, silent);
    CHECK(t.buried > 100);
    CHECK(t.thinnest == doctest::Approx(1));
    CHECK(t.walls.back() == doctest::Approx(3));

    m = solids::box({0, 0, 0}, {1, 1, 1}); // side by side, two faces upon each other
    solids::append(m, solids::box({1, 0, 0}, {2, 1, 1}));
    t = thickness(m, silent);
    CHECK(t.thinnest == doctest::Approx(1));
    CHECK(t.walls.back() == doctest::Approx(2));

    m = solids::box({0, 0, 0}, {10, 10, 10});
    Mesh cavity = solids::box({1, 1, 1}, {9, 9, 9});
    solids::invert(cavity);
    solids::append(m, cavity);
    t = thickness(m, silent);
    CHECK(t.quantile(0.5) == doctest::Approx(1));
    CHECK(t.share_below(1.01) == doctest::Approx((6 * 64 + 6 * 64) / (600.0 + 384)).epsilon(0.02));

    const Mesh once = solids::box({0, 0, 0}, {1, 2, 3});
    m = once;
    solids::append(m, once); // each face twice
    CHECK(thickness(m, silent).quantile(0.01) == doctest::Approx(1));
}

TEST_CASE("sheets, holes, nothing")
{
    Mesh sheet;
    sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
    CHECK_FALSE(thickness(sheet, silent).meaningful());
    CHECK(thickness(sheet, silent).walls.empty());
    Mesh both = sheet;
    for (const Triangle &t : sheet.triangles) both.triangles.push_back({t[0], t[2], t[1]});
    CHECK_FALSE(thickness(both, silent).meaningful());
    CHECK_FALSE(thickness(Mesh{}, silent).meaningful());
    Mesh point;
    point.vertices = {{1, 1, 1}};
    point.triangles = {{0, 0, 0}};
    CHECK_FALSE(thickness(point, silent).meaningful());

    Mesh open = solids::box({0, 0, 0}, {1, 1, 1}); // without its lid: what looks at the hole finds no wall
    open.triangles.erase(open.triangles.begin() + 6, open.triangles.begin() + 8);
    const Thickness t = thickness(open, silent);
    CHECK(t.meaningful());
    CHECK(t.thinnest == doctest::Approx(1));
    CHECK(t.sorted_out == doctest::Approx(4096 / 5.0).epsilon(0.05));
}

TEST_CASE("the same for any number of threads, scale and place")
{
    const Mesh m = cup(3, 48);
    const Thickness t = thickness(m, silent);
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const Thickness again = thickness(m, silent);
        CHECK(again.walls == t.walls);
        CHECK(again.thinnest_at == t.thinnest_at);
    }
    for (const double scale : {1e-6, 1e3}) {
        Mesh other = m;
        for (Point &p : other.vertices)
            for (double &x : p) x = x * scale + 100 * scale;
        CHECK(thickness(other, silent).quantile(0.01) == doctest::Approx(t.quantile(0.01) * scale));
    }
}

TEST_CASE("rays through a stack of ten thousand sheets end")
{
    Mesh m;
    for (std::uint32_t n = 0; n < 30000; ++n) {
        const double y = n;
        m.vertices.insert(m.vertices.end(), {{0, y, 0}, {1e4, y, 0}, {0, y, 1e4}});
        m.triangles.push_back({3 * n, 3 * n + 1, 3 * n + 2});
    }
    CHECK(thickness(m, silent).samples == 4096);
}

TEST_CASE("1, 2, 5")
{
    CHECK(round_down_125(0.0019) == 0.001);
    CHECK(round_down_125(0.002) == 0.002);
    CHECK(round_down_125(4.99e-7) == 2e-7);
    CHECK(round_down_125(5e-4) == 5e-4);
    CHECK(round_down_125(9.99) == 5);
    CHECK(round_down_125(1e6) == 1e6);
    CHECK(round_up_125(1e6) == 1e6);
    CHECK(round_up_125(0.0011) == 0.002);
    CHECK(round_up_125(0.0051) == 0.01);
    CHECK(voxel_for_wall(1.6e-3) == 0.5e-3);
    CHECK(voxel_for_wall(2.95e-3) == 1e-3); // within 2 %
    CHECK(voxel_for_wall(2.93e-3) == 0.5e-3);
}
