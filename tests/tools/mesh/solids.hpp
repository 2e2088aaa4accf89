// SPDX-License-Identifier: GPL-3.0-or-later
// Small solids with known volume and area, counter-clockwise seen from outside.
#pragma once

#include "import/scene.hpp"

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

namespace voxshell::solids {

inline void append(Mesh &mesh, const Mesh &other)
{
    const auto base = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Triangle &t : other.triangles)
        mesh.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

inline void invert(Mesh &mesh)
{
    for (Triangle &t : mesh.triangles) std::swap(t[1], t[2]);
}

inline Mesh box(const Point &low, const Point &high)
{
    Mesh m;
    for (int i = 0; i < 8; ++i)
        m.vertices.push_back({i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]});
    m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return m;
}

/// A ball of rings x 2 rings quads (triangles at the poles).
inline Mesh ball(double radius, int rings, const Point &center = {})
{
    Mesh m;
    const int seg = 2 * rings;
    const auto put = [&](double polar, double turn) {
        m.vertices.push_back({center[0] + radius * std::sin(polar) * std::cos(turn),
                              center[1] - radius * std::cos(polar),
                              center[2] + radius * std::sin(polar) * std::sin(turn)});
    };
    put(0, 0);
    for (int i = 1; i < rings; ++i)
        for (int j = 0; j < seg; ++j) put(std::numbers::pi * i / rings, 2 * std::numbers::pi * j / seg);
    put(std::numbers::pi, 0);
    const auto last = static_cast<std::uint32_t>(m.vertices.size() - 1);
    const auto at = [&](int i, int j) {
        return i == 0 ? 0u : i == rings ? last : static_cast<std::uint32_t>(1 + (i - 1) * seg + j % seg);
    };
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < seg; ++j) {
            if (i + 1 < rings) m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            if (i > 0) m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return m;
}

/// Every triangle with vertices of its own, as an STL file brings it.
inline Mesh soup(const Mesh &mesh)
{
    Mesh m;
    for (const Triangle &t : mesh.triangles) {
        const auto base = static_cast<std::uint32_t>(m.vertices.size());
        for (const std::uint32_t v : t) m.vertices.push_back(mesh.vertices[v]);
        m.triangles.push_back({base, base + 1, base + 2});
    }
    return m;
}

inline Mesh random_soup(std::size_t count, std::uint32_t seed, double size)
{
    std::mt19937 random(seed);
    const auto unit = [&] { return static_cast<double>(random()) / 4294967295.0 - 0.5; };
    Mesh m;
    for (std::size_t t = 0; t < count; ++t) {
        const Point c{unit(), unit(), unit()};
        for (int v = 0; v < 3; ++v)
            m.vertices.push_back({c[0] + size * unit(), c[1] + size * unit(), c[2] + size * unit()});
        const auto base = static_cast<std::uint32_t>(3 * t);
        m.triangles.push_back({base, base + 1, base + 2});
    }
    return m;
}

} // namespace voxshell::solids
