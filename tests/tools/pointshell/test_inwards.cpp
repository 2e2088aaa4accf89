// SPDX-License-Identifier: GPL-3.0-or-later
// Normals lead into the solid, at edges and rims too: a short step along a point's normal ends inside, short
// beside what the solid is thick there. Plates, blades and prisms, for which half-spaces tell what is inside.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "rules.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>

#include <functional>
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

    Point turned_back(const Point &v) const
    {
        Point q{};
        for (int i = 0; i < 3; ++i) q[i] = turn[0][i] * v[0] + turn[1][i] * v[1] + turn[2][i] * v[2];
        return q;
    }

    /// In the outline's frame.
    Point own(const Point &p) const
    {
        return turned_back({p[0] - shift[0], p[1] - shift[1], p[2] - shift[2]});
    }

    bool holds(const Point &p) const
    {
        const Point q = own(p);
        bool odd = false; // edges crossed on the way to x = infinity
        for (std::size_t i = 0; i < outline.size(); ++i) {
            const auto &[ax, ay] = outline[i];
            const auto &[bx, by] = outline[(i + 1) % outline.size()];
            if ((ay > q[1]) != (by > q[1]) && q[0] < ax + (q[1] - ay) / (by - ay) * (bx - ax)) odd = !odd;
        }
        return odd && q[2] > 0 && q[2] < length;
    }
};

using Judge = std::function<bool(const Prism &, const Point &position, const Point &normal)>;

/// Share of the points whose normal the judge finds to lead inwards.
double inwards(const Prism &prism, const Judge &judge)
{
    const Made m = make(prism.mesh(), 1);
    check_rules(m);
    std::size_t in = 0;
    for (const ShellPoint &p : m.shell.points)
        in += judge(prism, {p.position[0], p.position[1], p.position[2]},
                    {p.normal[0], p.normal[1], p.normal[2]});
    return static_cast<double>(in) / static_cast<double>(m.shell.points.size());
}

/// A step [cells] along the normal ends inside.
bool leads(const Prism &prism, const Point &from, const Point &normal, double step)
{
    return prism.holds({from[0] + step * normal[0], from[1] + step * normal[1], from[2] + step * normal[2]});
}

/// The worst share over many places: turned at random, and along the axes on, just off and between grid
/// planes.
double worst(const Outline &outline, double length, const Judge &judge)
{
    std::mt19937 random(11);
    const auto any = [&] { return std::uniform_real_distribution<double>(0, 1)(random); };
    double least = 1;
    for (int k = 0; k < 12; ++k)
        least =
            std::min(least, inwards({outline, length, random_turn(random), {any(), any(), any()}}, judge));
    const double places[4]{0, 0x1p-16, 1 - 0x1p-16, 0.4};
    for (int x = 0; x < 4; ++x)
        for (int y = 0; y < 4; ++y)
            least = std::min(
                least,
                inwards({outline, length, unturned, {places[x], places[y], places[(x + y) % 4]}}, judge));
    return least;
}

/// On a sharp edge no way along either side's normal stays inside, however short. One point for each side, as
/// METHOD section 2 wants it, leads in through its own, and not away from the solid.
bool on_edge_inwards(const Prism &prism, const Point &from, const Point &normal)
{
    using Flat = std::array<double, 2>;
    const Point at = prism.own(from), n = prism.turned_back(normal);
    const std::size_t count = prism.outline.size();
    const auto way = [&](std::size_t a, std::size_t b) {
        const Flat &p = prism.outline[a % count], &q = prism.outline[b % count];
        const double size = std::hypot(q[0] - p[0], q[1] - p[1]);
        return Flat{(q[0] - p[0]) / size, (q[1] - p[1]) / size};
    };
    for (std::size_t v = 0; v < count; ++v) {
        if (std::hypot(at[0] - prism.outline[v][0], at[1] - prism.outline[v][1]) > 0.02) continue;
        const Flat on = way(v, v + 1), back = way(v, v + count - 1);
        const double through = std::max(n[1] * on[0] - n[0] * on[1], n[0] * back[1] - n[1] * back[0]);
        return through > 0.1 && n[0] * (on[0] + back[0]) + n[1] * (on[1] + back[1]) > 0;
    }
    return false;
}

/// A step of a twentieth of a cell, or of a quarter of a wall's thickness.
double worst(const Outline &outline, double length, double thickness = 1)
{
    const double step = std::min(0.05, thickness / 4);
    return worst(outline, length, [step](const Prism &prism, const Point &from, const Point &normal) {
        return leads(prism, from, normal, step);
    });
}

} // namespace

TEST_CASE("plates of any thickness, flat, bent and crossed, and small ones with slanted rims")
{
    for (const double t : {0.02, 0.04, 0.06, 0.1, 0.2, 0.3, 0.43, 0.5, 0.7, 0.9, 1.0, 1.1, 1.3, 1.5, 3.0}) {
        CAPTURE(t);
        CHECK(worst({{0, 0}, {t, 0}, {t, 17}, {0, 17}}, 23.1, t) >= 0.995);
        CHECK(worst({{t, t}, {t, 12}, {0, 12}, {0, 0}, {11, 0}, {11, t}}, 13, t) >= 0.995);
        CHECK(worst({{3, 0}, {6, 3}, {3, 6}, {0, 3}}, t, t) >= 0.98); // one point of 60
    }
}

TEST_CASE("blades: every point, and on the edge itself the normal is the inward one of the point's own side")
{
    for (const double degrees : {1.0, 5.0, 20.0, 40.0, 60.0, 90.0}) {
        const double w = 12 * std::tan(degrees * std::numbers::pi / 360);
        CAPTURE(degrees);
        const double share = worst({{0, 0}, {12, -w}, {12, w}}, 23,
                                   [](const Prism &prism, const Point &from, const Point &normal) {
                                       // Convex: what leads out never comes in, so one of these steps is
                                       // enough.
                                       for (double step = 0.05; step > 1e-4; step /= 4)
                                           if (leads(prism, from, normal, step)) return true;
                                       return on_edge_inwards(prism, from, normal);
                                   });
        MESSAGE("blade of ", degrees, " degrees: ", share);
        CHECK(share == 1);
    }
}

TEST_CASE("grooves: the way into the solid is open at their bottom")
{
    for (const double degrees : {1.0, 5.0, 20.0, 60.0, 90.0, 110.0}) {
        const double w = 12 * std::tan(degrees * std::numbers::pi / 360);
        CHECK(worst({{0, 0}, {-12, -w}, {-12, -12 - w}, {3, -12 - w}, {3, 12 + w}, {-12, 12 + w}, {-12, w}},
                    17) == 1);
    }
}
