// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "pointshell/sides.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

using namespace voxshell;

namespace {

Piece piece(const Vec &normal, double area, const Vec &point, std::uint32_t triangle)
{
    const double length = std::sqrt(dot(normal, normal));
    return {point, dot(point, point), area, length > 0 ? (1 / length) * normal : Vec{}, triangle, 0};
}

void check_unit(const Side &side)
{
    CHECK(dot(side.inward, side.inward) == doctest::Approx(1).epsilon(1e-14));
}

} // namespace

TEST_CASE("one face; a cube's edge and corner: one point, the area-weighted mean, inwards")
{
    std::vector<Piece> pieces{piece({0, 1, 0}, 0.5, {0, 0.1, 0}, 7)};
    Sides s = sides_of(pieces);
    CHECK(s.count == 1);
    CHECK(s.side[0].inward == Vec{0, -1, 0});
    CHECK(s.side[0].area == 0.5);
    pieces.push_back(piece({1, 0, 0}, 0.25, {0.2, 0, 0}, 8));
    s = sides_of(pieces);
    CHECK(s.count == 1);
    CHECK(s.side[0].nearest->triangle == 7);
    CHECK(s.side[0].area == 0.75);
    CHECK(s.side[0].inward[1] == doctest::Approx(-2 / std::sqrt(5.0)));
    CHECK(s.side[0].inward[0] == doctest::Approx(-1 / std::sqrt(5.0)));
    pieces.push_back(piece({0, 0, 1}, 0.25, {0, 0, 0.3}, 9));
    CHECK(sides_of(pieces).count == 1);
}

TEST_CASE("a thin wall gives a point per side, the nearer first, areas kept apart")
{
    const std::vector<Piece> pieces{piece({0, 1, 0}, 1, {0, 0.3, 0}, 1),
                                    piece({0, -1, 0}, 0.9, {0, -0.1, 0}, 2)};
    const Sides s = sides_of(pieces);
    CHECK(s.count == 2);
    CHECK(s.side[0].nearest->triangle == 2);
    CHECK(s.side[0].inward == Vec{0, 1, 0});
    CHECK(s.side[1].inward == Vec{0, -1, 0});
    CHECK(s.side[0].area == 0.9);
    CHECK(s.side[1].area == 1);
}

TEST_CASE("a wall of which one side only grazes the cell: one point, unless the nearest is on that side")
{
    CHECK(sides_of(
              std::vector{piece({0, 1, 0}, 1, {0, 0.1, 0}, 1), piece({0, -1, 0}, 0.01, {0.4, -0.4, 0.4}, 2)})
              .count == 1);
    const std::vector<Piece> pieces{piece({0, 1, 0}, 1, {0, 0.4, 0}, 1),
                                    piece({0, -1, 0}, 0.01, {0, 0.1, 0}, 2)};
    const Sides s = sides_of(pieces);
    CHECK(s.count == 2);
    CHECK(s.side[0].nearest->triangle == 2);
    CHECK(s.side[0].inward == Vec{0, 1, 0});
}

TEST_CASE("a knife edge of 10 degrees gives two points, a prism's edge of 60 degrees one")
{
    const auto wedge = [](double degrees) {
        const double half = degrees * std::numbers::pi / 360;
        return std::vector{piece({std::cos(half), std::sin(half), 0}, 0.4, {0.1, 0, 0}, 1),
                           piece({-std::cos(half), std::sin(half), 0}, 0.4, {-0.1, 0, 0}, 2)};
    };
    const auto knife = wedge(10), prism = wedge(60);
    const Sides s = sides_of(knife);
    CHECK(s.count == 2);
    CHECK(s.side[0].nearest->triangle == 1); // equal distance: the lower triangle
    CHECK(dot(s.side[0].inward, s.side[1].inward) < -0.9);
    CHECK(sides_of(prism).count == 1);
}

TEST_CASE(
    "a cone's tip, blunt and like a needle: normals stay unit and each goes into the solid at its point")
{
    for (const double half : {0.02, 0.1, 0.4, 0.8, 1.3}) {
        std::vector<Piece> pieces;
        for (std::uint32_t t = 0; t < 24; ++t) {
            const double turn = 2 * std::numbers::pi * t / 24;
            const Vec n{std::cos(half) * std::cos(turn), std::sin(half), std::cos(half) * std::sin(turn)};
            pieces.push_back(piece(n, 0.02, {0.1 * n[0], -0.2 + 1e-3 * t, 0.1 * n[2]}, t));
        }
        const Sides s = sides_of(pieces);
        CHECK(s.count == (std::sin(half) < 0.25 ? 2 : 1));
        double area = 0;
        for (int i = 0; i < s.count; ++i) {
            check_unit(s.side[i]);
            CHECK(dot(s.side[i].inward, s.side[i].nearest->normal) < 0);
            area += s.side[i].area;
        }
        CHECK(area == doctest::Approx(0.48));
    }
}

TEST_CASE("no area: a touch takes the planes' mean, a triangle without plane gives no normal, both together "
          "the plane's")
{
    const std::vector<Piece> touch{piece({1, 0, 0}, 0, {0.5, 0.5, 0.5}, 1),
                                   piece({0, 1, 0}, 0, {0.5, 0.5, 0.5}, 2)};
    Sides s = sides_of(touch);
    CHECK(s.count == 1);
    CHECK(s.side[0].inward[0] == doctest::Approx(-std::sqrt(0.5)));
    const std::vector<Piece> edge_on{piece({1, 0, 0}, 0, {0.5, 0, 0}, 1),
                                     piece({-1, 0, 0}, 0, {0.5, 0, 0}, 2)};
    CHECK(sides_of(edge_on).side[0].inward == Vec{-1, 0, 0});
    const std::vector<Piece> segment{piece({}, 0, {0.1, 0, 0}, 1)};
    s = sides_of(segment);
    CHECK(s.side[0].inward == Vec{});
    CHECK(s.side[0].nearest->triangle == 1);
    const std::vector<Piece> both{piece({}, 0, {0.1, 0, 0}, 1), piece({0, 0, 2}, 0.5, {0.2, 0, 0}, 2)};
    s = sides_of(both);
    CHECK(s.count == 1);
    CHECK(s.side[0].nearest->triangle == 1); // the nearest point counts, whosever it is
    CHECK(s.side[0].inward == Vec{0, 0, -1});
}

TEST_CASE("whatever comes: unit normals, no area lost, nearest first, no normal against its own face")
{
    std::mt19937 random(5);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967295.0 - 0.5; };
    for (int k = 0; k < 20000; ++k) {
        std::vector<Piece> pieces;
        const auto count = 1 + random() % 9;
        double area = 0;
        bool plane = false;
        for (std::uint32_t t = 0; t < count; ++t) {
            Vec n{unit(), unit(), unit()};
            if (random() % 4 == 0)
                n = {static_cast<double>(random() % 3) - 1, 0, static_cast<double>(random() % 3) - 1};
            const bool flat = n != Vec{};
            pieces.push_back(piece(n, flat && random() % 3 ? unit() + 0.5 : 0, {unit(), unit(), unit()}, t));
            area += pieces.back().area;
            plane |= flat;
        }
        const Sides s = sides_of(pieces);
        double sum = 0, least = 1e9;
        for (const Piece &p : pieces) least = std::min(least, p.distance2);
        CHECK(s.side[0].nearest->distance2 == least);
        for (int i = 0; i < s.count; ++i) {
            sum += s.side[i].area;
            if (plane) check_unit(s.side[i]);
            const Vec &own = s.side[i].nearest->normal;
            if (area > 0) CHECK(dot(s.side[i].inward, own) <= 1e-12);
        }
        CHECK(sum == doctest::Approx(area).epsilon(1e-12));
    }
}

TEST_CASE("a wall and its rim in one cell: two points, whatever the rim's share")
{
    for (const double rim : {0.1, 0.5, 1.0, 2.0}) {
        const std::vector<Piece> pieces{piece({0, 1, 0}, 0.4, {0, 0.1, 0}, 1),
                                        piece({0, -1, 0}, 0.4, {0, -0.2, 0}, 2),
                                        piece({1, 0, 0}, rim, {0.3, 0, 0}, 3)};
        const Sides s = sides_of(pieces);
        REQUIRE(s.count == 2);
        CHECK(s.side[0].nearest->triangle == 1);
        CHECK(s.side[0].inward[1] < -0.17); // into the wall, not along its face
        CHECK(s.side[1].inward[1] > 0.17);
        CHECK(s.side[0].area + s.side[1].area == doctest::Approx(0.8 + rim));
        check_unit(s.side[0]);
        check_unit(s.side[1]);
    }
}

TEST_CASE("a rim goes with the face that its point is nearer to, whole, whatever its triangles")
{
    for (const double y : {0.08, -0.08}) {
        const std::vector<Piece> pieces{
            piece({0, 1, 0}, 0.4, {0.1, 0.1, 0}, 1), piece({0, -1, 0}, 0.4, {0.1, -0.1, 0}, 2),
            piece({1, 1e-17, 0}, 0.1, {0, y, 0}, 3), piece({1, -1e-17, 0}, 0.1, {0, -y, 0.1}, 4)};
        const Sides s = sides_of(pieces);
        REQUIRE(s.count == 2);
        CHECK(s.side[0].nearest->triangle == 3);
        CHECK(s.side[0].area == doctest::Approx(0.6));
        CHECK(s.side[0].inward[1] * y < 0); // to the far face
    }
}

namespace {

/// Two faces of 8 by 1 cells along the z axis, `degrees` of solid between them; the first one looks up.
std::vector<CellTriangle> edge(double degrees)
{
    const double turn = degrees * std::numbers::pi / 180, one = static_cast<double>(lattice_per_cell);
    const LatticePoint a{0, 0, -4 * lattice_per_cell}, b{0, 0, 4 * lattice_per_cell},
        up{-lattice_per_cell, 0, 0},
        other{std::llround(-one * std::cos(turn)), std::llround(-one * std::sin(turn)), 0};
    std::vector<CellTriangle> facets;
    for (const LatticeTriangle &t : {lattice_triangle(b, a, up), lattice_triangle(a, b, other)}) {
        facets.push_back(seen_from({0, 0, 0}, t));
        CHECK(t.normal != Vec{});
    }
    return facets;
}

} // namespace

TEST_CASE("into the solid: no facet looks along or against the normal, where that can be, and it turns no "
          "more than that")
{
    const Vec at{-0.5, -0.5, -0.5}, down{0, -1, 0}; // the lattice's origin as cell 0 sees it
    CHECK(into_solid(down, at, {}) == down);
    for (const double degrees : {3.0, 10.0, 100.0, 135.0, 180.0, 225.0, 270.0, 315.0, 355.0}) {
        const std::vector<CellTriangle> facets = edge(degrees);
        CAPTURE(degrees);
        CHECK(facets[0].normal[1] == 1);
        CHECK(into_solid(down, at, facets) == down); // already leads in, or is a knife's
    }
    for (const double degrees : {16.0, 30.0, 60.0, 90.0}) {
        const std::vector<CellTriangle> facets = edge(degrees);
        CAPTURE(degrees);
        const Vec n = into_solid(down, at, facets);
        CHECK(dot(n, n) == doctest::Approx(1).epsilon(1e-14));
        CHECK(n[2] == doctest::Approx(0).epsilon(1e-14));
        const double below = std::atan2(-n[1], -n[0]) * 180 / std::numbers::pi; // of the first face
        CHECK(below == doctest::Approx(degrees - 10.02).epsilon(1e-3));         // 10 above the other
    }
    const std::vector<CellTriangle> sheet = edge(0);
    CHECK(sheet[1].normal == down);
    CHECK(into_solid(down, at, sheet) == down); // both sides of a face: nothing to lead into
}
