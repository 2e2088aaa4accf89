// SPDX-License-Identifier: GPL-3.0-or-later
// Solids of the hard cases: closed, outward, in metres.
#pragma once

#include "solids.hpp"

#include <cmath>
#include <functional>
#include <vector>

namespace hard {

using solids::Mesh;
using solids::Point;

inline Mesh moved(Mesh mesh, const std::function<Point(const Point &)> &place)
{
    for (Point &p : mesh.vertices) p = place(p);
    return mesh;
}

inline Mesh scaled(const Mesh &mesh, double factor)
{
    return moved(mesh, [factor](const Point &p) {
        return Point{factor * p[0], factor * p[1], factor * p[2]};
    });
}

/// Under a chain of (x, y) with x not falling, down to `bottom`, from z = -depth/2 to depth/2.
inline Mesh under(const std::vector<std::array<double, 2>> &chain, double bottom, double depth)
{
    Mesh m;
    for (const auto &[x, y] : chain)
        for (const double z : {-depth / 2, depth / 2}) {
            m.vertices.push_back({x, y, z});
            m.vertices.push_back({x, bottom, z});
        }
    const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        for (const voxshell::Triangle &t : {voxshell::Triangle{a, b, c}, voxshell::Triangle{a, c, d}}) {
            if (m.vertices[t[0]] != m.vertices[t[1]] && m.vertices[t[1]] != m.vertices[t[2]] &&
                m.vertices[t[2]] != m.vertices[t[0]])
                m.triangles.push_back(t);
        }
    };
    const std::uint32_t last = static_cast<std::uint32_t>(chain.size()) -
                               1; // corner i: 4 i + {back top, back bottom, front top, front bottom}
    for (std::uint32_t i = 0; i < last; ++i) {
        const std::uint32_t a = 4 * i, b = a + 4;
        quad(a, a + 2, b + 2, b);                     // top
        quad(a + 1, b + 1, b + 3, a + 3);             // bottom
        if (chain[i][0] == chain[i + 1][0]) continue; // a vertical wall has no cap
        quad(a + 2, a + 3, b + 3, b + 2);             // front
        quad(a, b, b + 1, a + 1);                     // back
    }
    quad(0, 1, 3, 2);
    quad(4 * last, 4 * last + 2, 4 * last + 3, 4 * last + 1);
    return m;
}

/// A square frame about the y axis: outer and inner half width, height about y = 0.
inline Mesh frame(double outer, double inner, double height)
{
    Mesh m;
    const double corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (const double half : {outer, inner})
        for (const double y : {-height / 2, height / 2})
            for (const auto &c : corner) m.vertices.push_back({half * c[0], y, half * c[1]});
    for (std::uint32_t i = 0; i < 4; ++i) { // 0.. outer low, 4.. outer high, 8.. inner low, 12.. inner high
        const std::uint32_t j = (i + 1) % 4;
        for (const auto &q : {std::array{i, 4 + i, 4 + j, j},
                              {8 + j, 12 + j, 12 + i, 8 + i},
                              {4 + i, 12 + i, 12 + j, 4 + j},
                              {j, 8 + j, 8 + i, i}}) {
            m.triangles.push_back({q[0], q[1], q[2]});
            m.triangles.push_back({q[0], q[2], q[3]});
        }
    }
    return m;
}

/// An upright cone on its tip.
inline Mesh cone(double radius, double height, const Point &tip = {0, 0, 0})
{
    constexpr std::uint32_t around = 32;
    Mesh m;
    m.vertices = {tip, {tip[0], tip[1] + height, tip[2]}};
    for (std::uint32_t n = 0; n < around; ++n) {
        const double turn = 2 * std::numbers::pi * n / around;
        m.vertices.push_back(
            {tip[0] + radius * std::cos(turn), tip[1] + height, tip[2] + radius * std::sin(turn)});
    }
    for (std::uint32_t n = 0; n < around; ++n) {
        const std::uint32_t a = 2 + n, b = 2 + (n + 1) % around;
        m.triangles.push_back({0, a, b});
        m.triangles.push_back({1, b, a});
    }
    return m;
}

/// Each triangle cut in four, `times` over.
inline Mesh refined(Mesh mesh, int times)
{
    for (; times > 0; --times) {
        Mesh fine;
        fine.vertices = mesh.vertices;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const Point &p = mesh.vertices[a], &q = mesh.vertices[b];
            fine.vertices.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
            return static_cast<std::uint32_t>(fine.vertices.size()) - 1;
        };
        for (const auto &[a, b, c] : mesh.triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            for (const voxshell::Triangle &t :
                 {voxshell::Triangle{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
                fine.triangles.push_back(t);
        }
        mesh = std::move(fine);
    }
    return mesh;
}

/// The floor of most cases: 40 mm square, its top half a cell above y = 0's grid plane, so that every field
/// begins there.
inline Mesh block(double top = 0.5e-3)
{
    return solids::box({-20e-3, top - 8e-3, -20e-3}, {20e-3, top, 20e-3});
}

inline Mesh ball(double radius = 5e-3)
{
    return solids::sphere({0, 0, 0}, radius, 48);
}

/// A floor turned about both axes, so that its top crosses cells in steps.
inline Point tilted(const Point &p)
{
    const double a = 0.35, b = 0.2;
    const Point q{std::cos(a) * p[0] - std::sin(a) * p[1], std::sin(a) * p[0] + std::cos(a) * p[1], p[2]};
    return {q[0], std::cos(b) * q[1] - std::sin(b) * q[2], std::sin(b) * q[1] + std::cos(b) * q[2]};
}

} // namespace hard
