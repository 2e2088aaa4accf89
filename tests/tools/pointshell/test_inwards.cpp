// SPDX-License-Identifier: GPL-3.0-or-later
// Normals lead into the solid, at edges and rims too: a short step along a point's normal ends inside.
// Plates, blades and prisms, for which half-spaces tell what is inside.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "rules.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>

#include <random>

using namespace voxshell;

namespace {

using Matrix = std::array<Point, 3>;

Matrix random_turn(std::mt19937 &random)
{
    std::normal_distribution<double> any;
    double w = any(random), x = any(random), y = any(random), z = any(random);
    const double size = std::sqrt(w * w + x * x + y * y + z * z);
    w /= size, x /= size, y /= size, z /= size;
    return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

constexpr Matrix unturned{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Corners counter-clockwise; all of the outline is seen from the first one.
using Outline = std::vector<std::array<double, 2>>;

/// The outline, from z = 0 to `length`, turned and moved.
struct Prism {
    Outline outline;
    double length;
    Matrix turn;
    Point shift;

    Mesh mesh() const
    {
        Mesh m;
        const auto n = static_cast<std::uint32_t>(outline.size());
        for (const double z : {0.0, length})
            for (const auto &[x, y] : outline) {
                Point p{};
                for (int i = 0; i < 3; ++i)
                    p[i] = shift[i] + turn[i][0] * x + turn[i][1] * y + turn[i][2] * z;
                m.vertices.push_back(p);
            }
        for (std::uint32_t i = 0; i < n; ++i) {
            const std::uint32_t j = (i + 1) % n;
            m.triangles.push_back({i, j, n + j});
            m.triangles.push_back({i, n + j, n + i});
            if (i == 0 || j == 0) continue;
            m.triangles.push_back({0, j, i});
            m.triangles.push_back({n, n + i, n + j});
        }
        return m;
    }

    bool holds(Point p) const
    {
        for (int i = 0; i < 3; ++i) p[i] -= shift[i];
        Point q{};
        for (int i = 0; i < 3; ++i) q[i] = turn[0][i] * p[0] + turn[1][i] * p[1] + turn[2][i] * p[2];
        bool odd = false; // edges crossed on the way to x = infinity
        for (std::size_t i = 0; i < outline.size(); ++i) {
            const auto &[ax, ay] = outline[i];
            const auto &[bx, by] = outline[(i + 1) % outline.size()];
            if ((ay > q[1]) != (by > q[1]) && q[0] < ax + (q[1] - ay) / (by - ay) * (bx - ax)) odd = !odd;
        }
        return odd && q[2] > 0 && q[2] < length;
    }
};

/// Share of the points from which a step of 1/20 cell along the normal ends inside.
double inwards(const Prism &prism)
{
    const Made m = make(prism.mesh(), 1);
    check_rules(m);
    std::size_t in = 0;
    for (const ShellPoint &p : m.shell.points) {
        Point end{};
        for (int i = 0; i < 3; ++i)
            end[i] = static_cast<double>(p.position[i]) + 0.05 * static_cast<double>(p.normal[i]);
        in += prism.holds(end);
    }
    return static_cast<double>(in) / static_cast<double>(m.shell.points.size());
}

/// The worst share over many places: turned at random, and along the axes on, just off and between grid
/// planes.
double worst(const Outline &outline, double length)
{
    std::mt19937 random(11);
    const auto any = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    double least = 1;
    for (int k = 0; k < 12; ++k)
        least = std::min(least, inwards({outline, length, random_turn(random), {any(), any(), any()}}));
    const double places[4]{0, 0x1p-16, 1 - 0x1p-16, 0.4};
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 4; ++y)
            least = std::min(
                least, inwards({outline, length, unturned, {places[x], places[y], places[(x + y) % 4]}}));
    return least;
}

} // namespace

TEST_CASE("plates of any thickness, flat, bent and crossed, and small ones with slanted rims")
{
    for (const double t : {0.1, 0.2, 0.3, 0.43, 0.5, 0.7, 0.9, 1.0, 1.1, 1.3, 1.5, 3.0}) {
        CAPTURE(t);
        CHECK(worst({{0, 0}, {t, 0}, {t, 17}, {0, 17}}, 23.1) >= 0.995);
        CHECK(worst({{t, t}, {t, 12}, {0, 12}, {0, 0}, {11, 0}, {11, t}}, 13) >= 0.995);
        CHECK(worst({{3, 0}, {6, 3}, {3, 6}, {0, 3}}, t) >= 0.98); // one point of 60
    }
}

TEST_CASE("blades: only where the step leads through the other face, near the edge, does it end outside")
{
    const auto share = [](double degrees) {
        const double w = 12 * std::tan(degrees * std::numbers::pi / 360);
        return worst({{0, 0}, {12, -w}, {12, w}}, 23);
    };
    CHECK(share(5) >= 0.8);
    CHECK(share(20) >= 0.93);
    CHECK(share(40) >= 0.97);
    CHECK(share(60) >= 0.98);
    CHECK(share(90) >= 0.98);
}

TEST_CASE("grooves: the way into the solid is open at their bottom")
{
    for (const double degrees : {1.0, 5.0, 20.0, 60.0, 90.0, 110.0}) {
        const double w = 12 * std::tan(degrees * std::numbers::pi / 360);
        CHECK(worst({{0, 0}, {-12, -w}, {-12, -12 - w}, {3, -12 - w}, {3, 12 + w}, {-12, 12 + w}, {-12, w}},
                    17) == 1);
    }
}
