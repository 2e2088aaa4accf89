// SPDX-License-Identifier: GPL-3.0-or-later
// The reference of the accuracy study: formulas, quadrature of formulas, and the mesh's own distance agree.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "study/bodies.hpp"
#include "study/foundation.hpp"

#include <cmath>
#include <numbers>

using namespace voxshell;
using doctest::Approx;

namespace {

constexpr double radius = 0.02, mm = 1e-3;

Distance from_plane()
{
    return distance_of([](const Point &p) { return Nearest{p[2], {0, 0, 1}}; });
}

Distance from_bowl(double bowl)
{
    return distance_of([bowl](const Point &p) {
        const double r = std::hypot(p[0], p[1], p[2]);
        return Nearest{bowl - r, {-p[0] / r, -p[1] / r, -p[2] / r}};
    });
}

vxs_pose at(const Point &p)
{
    return {{p[0], p[1], p[2]}, {0.8, 0.2, -0.4, 0.4}};
}

} // namespace

TEST_CASE("quadrature of a formula is the formula")
{
    for (const double depth : {0.01 * mm, 0.1 * mm, 1 * mm, 3 * mm}) {
        const Wrench plane = ball_foundation(radius, {0.003, -0.001, radius - depth}, from_plane());
        CHECK(plane.force[2] == Approx(ball_on_plane(radius, depth)).epsilon(1e-9));
        CHECK(std::abs(plane.force[0]) < 1e-9 * plane.force[2]);
        CHECK(std::abs(plane.torque[1]) < 1e-9 * plane.force[2] * radius);
        for (const double bowl : {1.2 * radius, 2 * radius}) {
            const Wrench inside = ball_foundation(radius, {0, 0, -(bowl - radius + depth)}, from_bowl(bowl));
            CHECK(inside.force[2] == Approx(ball_in_bowl(radius, bowl, depth)).epsilon(1e-9));
        }
    }
    CHECK(ball_on_plane(radius, -mm) == 0);
    CHECK(ball_foundation(radius, {0, 0, radius + mm}, from_plane()).force[2] == 0);
}

TEST_CASE("the mesh's own distance, by CGAL, agrees within 0.5 %, and half the spacing changes it by less "
          "than 0.2 %")
{
    const FoundationSurface surface(ball(radius, 192));
    const MeshDistance floor(slab(3 * radius, 0, radius));
    const Distance distance = distance_of(floor);
    for (const double depth : {0.5 * mm, 1 * mm, 3 * mm}) {
        const vxs_pose pose = at({0.003, -0.001, radius - depth});
        const Foundation coarse = surface.at(pose, distance, 0.31 * mm),
                         fine = surface.at(pose, distance, 0.155 * mm);
        CHECK(coarse.wrench.force[2] == Approx(fine.wrench.force[2]).epsilon(0.002));
        CHECK(fine.wrench.force[2] == Approx(ball_on_plane(radius, depth)).epsilon(0.005));
        CHECK(fine.deepest == Approx(depth).epsilon(0.01));
        CHECK(fine.wrong == 0);
        CHECK(fine.pieces > 3 * coarse.pieces);
    }
    // Pressed past the middle of the slab's thickness the shortest way leads out on the other side.
    const Foundation through = surface.at(at({0, 0, 0.2 * radius}), distance, mm);
    CHECK(through.wrong > 0.01 * through.gross);
    CHECK(surface.at(at({0, 0, 1.1 * radius}), distance, mm).gross == 0);
}

TEST_CASE("a mesh's distance: sign and way out at faces, edges and corners")
{
    const MeshDistance box(slab(1, 1, 2)); // -1 .. 1
    const struct {
        Point at;
        double distance;
    } cases[] = {{{0, 0, 1.5}, 0.5},
                 {{0, 0, 0.5}, -0.5},
                 {{0.9, 0.2, -0.3}, -0.1},
                 {{2, 2, 0}, std::numbers::sqrt2},
                 {{2, 2, 2}, std::numbers::sqrt3},
                 {{0.25, 0.25, 1}, 0}};
    for (const auto &c : cases) {
        const Nearest nearest = box.nearest(c.at);
        CHECK(nearest.distance == Approx(std::abs(c.distance)).epsilon(1e-12));
        CHECK(std::hypot(nearest.away[0], nearest.away[1], nearest.away[2]) == Approx(1));
        if (c.distance == 0) continue;
        CHECK(box.side(c.at) == (c.distance < 0 ? -1 : 1));
        const double step = 1e-3;
        const Point away{c.at[0] + step * nearest.away[0], c.at[1] + step * nearest.away[1],
                         c.at[2] + step * nearest.away[2]};
        CHECK(box.nearest(away).distance == Approx(std::abs(c.distance) + step));
    }
    CHECK(box.foot({0.5, 0.25, 3}) == Point{0.5, 0.25, 1});
    CHECK_THROWS_AS(MeshDistance(Mesh{"empty", {}, {}}), Failure);
}

TEST_CASE("what the nearest triangle tells of the side is what a ray says, wherever the search begins")
{
    const auto shifted = [](Mesh mesh, double by) {
        for (Point &p : mesh.vertices) p[0] += by;
        return mesh;
    };
    const auto both = [](Mesh a, const Mesh &b) {
        const auto first = static_cast<std::uint32_t>(a.vertices.size());
        a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
        for (const Triangle &t : b.triangles)
            a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
        return a;
    };
    // A ball; a ball in another one, wound as if it were solid too; two that cut each other: there nothing is
    // told.
    const Mesh one = ball(1, 24), nested = both(one, ball(0.5, 24)), cut = both(one, shifted(one, 0.7));
    for (const Mesh *mesh : {&one, &nested, &cut}) {
        const MeshDistance distance(*mesh);
        unsigned told = 0, inside = 0;
        std::uint32_t near = no_triangle;
        for (unsigned n = 0; n < 2000; ++n) {
            const auto in = [n](double factor) { return 3 * std::fmod(n * factor, 1) - 1.5; };
            const Point p{in(0.7548776662466927), in(0.5698402909980532), in(0.8191725133961645)};
            const Nearest nearest = distance.nearest(p), again = distance.nearest(p, near);
            CHECK(nearest.distance == again.distance);
            CHECK(nearest.side == again.side);
            near = again.triangle;
            if (nearest.side == 0) continue;
            ++told;
            inside += nearest.side < 0;
            CHECK(nearest.side == distance.side(p));
        }
        CHECK((mesh == &cut ? told == 0 : told > 100 && inside > 50));
    }
}
