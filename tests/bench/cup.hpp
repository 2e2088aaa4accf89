// SPDX-License-Identifier: GPL-3.0-or-later
// The benchmark's cup: outer radius 40 mm, height 90 mm, wall and floor 3 mm, about 100 k triangles, +Y up,
// metres.
#pragma once

#include "import/scene.hpp"

#include <cmath>
#include <numbers>

inline voxshell::Mesh bench_cup(std::uint32_t around = 300, std::uint32_t up = 65)
{
    std::vector<std::array<double, 2>> profile; // radius, height [m]
    for (std::uint32_t i = 0; i <= 20; ++i) profile.push_back({0.040 * i / 20, 0});
    for (std::uint32_t i = 1; i <= up; ++i) profile.push_back({0.040, 0.090 * i / up});
    for (std::uint32_t i = 0; i <= up; ++i) profile.push_back({0.037, 0.090 - 0.087 * i / up});
    for (std::uint32_t i = 1; i <= 20; ++i) profile.push_back({0.037 - 0.037 * i / 20, 0.003});
    voxshell::Mesh mesh;
    mesh.name = "cup";
    for (const auto &[radius, height] : profile)
        for (std::uint32_t s = 0; s < around; ++s) {
            const double turn = 2 * std::numbers::pi * s / around;
            mesh.vertices.push_back({radius * std::cos(turn), height, radius * std::sin(turn)});
        }
    for (std::uint32_t r = 0; r + 1 < profile.size(); ++r)
        for (std::uint32_t s = 0; s < around; ++s) {
            const std::uint32_t next = (s + 1) % around, a = r * around + s, b = r * around + next,
                                c = (r + 1) * around + next, d = (r + 1) * around + s;
            mesh.triangles.push_back({a, c, b});
            mesh.triangles.push_back({a, d, c});
        }
    return mesh;
}
