// SPDX-License-Identifier: GPL-3.0-or-later
// Small solids for tests: closed, outward, in metres.
#pragma once

#include "import/scene.hpp"

#include <cmath>
#include <numbers>

namespace solids {

using voxshell::Mesh;
using voxshell::Point;

inline Mesh box(const Point &low, const Point &high)
{
    Mesh m;
    for (int v = 0; v < 8; ++v)
        m.vertices.push_back({v & 1 ? high[0] : low[0], v & 2 ? high[1] : low[1], v & 4 ? high[2] : low[2]});
    m.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                   {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return m;
}

inline Mesh sphere(const Point &center, double radius, int rings = 24)
{
    Mesh m;
    const std::uint32_t around = 2 * static_cast<std::uint32_t>(rings),
                        inner = static_cast<std::uint32_t>(rings) - 1;
    const auto add = [&](double polar, double turn) {
        m.vertices.push_back({center[0] + radius * std::sin(polar) * std::cos(turn),
                              center[1] + radius * std::cos(polar),
                              center[2] + radius * std::sin(polar) * std::sin(turn)});
    };
    add(0, 0);
    for (std::uint32_t r = 1; r <= inner; ++r)
        for (std::uint32_t s = 0; s < around; ++s)
            add(std::numbers::pi * r / rings, 2 * std::numbers::pi * s / around);
    add(std::numbers::pi, 0);
    const std::uint32_t last = static_cast<std::uint32_t>(m.vertices.size()) - 1;
    const auto at = [&](std::uint32_t r, std::uint32_t s) { return 1 + (r - 1) * around + s % around; };
    for (std::uint32_t s = 0; s < around; ++s) {
        m.triangles.push_back({0, at(1, s + 1), at(1, s)});
        m.triangles.push_back({last, at(inner, s), at(inner, s + 1)});
        for (std::uint32_t r = 1; r < inner; ++r) {
            m.triangles.push_back({at(r, s), at(r, s + 1), at(r + 1, s)});
            m.triangles.push_back({at(r, s + 1), at(r + 1, s + 1), at(r + 1, s)});
        }
    }
    return m;
}

inline Mesh turned_inside_out(Mesh m)
{
    for (auto &t : m.triangles) std::swap(t[1], t[2]);
    return m;
}

inline Mesh join(Mesh a, const Mesh &b)
{
    const std::uint32_t base = static_cast<std::uint32_t>(a.vertices.size());
    a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
    for (const auto &t : b.triangles) a.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
    return a;
}

} // namespace solids
