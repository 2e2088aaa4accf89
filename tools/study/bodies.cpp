// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/bodies.hpp"

#include <cmath>
#include <numbers>

namespace voxshell {
namespace {

constexpr double pi = std::numbers::pi;

} // namespace

Mesh revolved(const std::vector<ProfilePoint> &profile, std::uint32_t count, bool ring)
{
    Mesh mesh;
    std::vector<std::uint32_t> first; // vertex of each profile point; on the axis it is its only one
    for (const auto &[radius, height] : profile) {
        first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
        for (std::uint32_t n = 0; n < (radius > 0 ? count : 1); ++n) {
            const double turn = 2 * pi * n / count;
            mesh.vertices.push_back({radius * std::cos(turn), radius * std::sin(turn), height});
        }
    }
    const auto vertex = [&](std::size_t point, std::uint32_t n) {
        return first[point] + (profile[point][0] > 0 ? n % count : 0);
    };
    const std::size_t segments = ring ? profile.size() : profile.size() - 1;
    for (std::size_t point = 0; point < segments; ++point) {
        const std::size_t next = (point + 1) % profile.size();
        for (std::uint32_t n = 0; n < count; ++n) {
            const std::uint32_t a = vertex(point, n), b = vertex(point, n + 1), c = vertex(next, n + 1),
                                d = vertex(next, n);
            if (a != b) mesh.triangles.push_back({a, b, c});
            if (c != d) mesh.triangles.push_back({a, c, d});
        }
    }
    return mesh;
}

Mesh ball(double radius, std::uint32_t rings)
{
    std::vector<ProfilePoint> profile;
    for (std::uint32_t n = 0; n <= rings; ++n) {
        const double polar = pi * n / rings;
        profile.push_back({n == 0 || n == rings ? 0 : radius * std::sin(polar), -radius * std::cos(polar)});
    }
    return revolved(profile, 2 * rings);
}

Mesh cylinder(double radius, double half_length, std::uint32_t count)
{
    return revolved({{0, -half_length}, {radius, -half_length}, {radius, half_length}, {0, half_length}},
                    count);
}

Mesh cup(double outer, double inner, double height, double floor, std::uint32_t count)
{
    return revolved({{0, 0}, {outer, 0}, {outer, height}, {inner, height}, {inner, floor}, {0, floor}},
                    count);
}

Mesh holed_block(double hole, double outer, double height, std::uint32_t count)
{
    return revolved({{hole, 0}, {outer, 0}, {outer, height}, {hole, height}}, count, true);
}

Mesh slab(double half_width, double top, double thickness)
{
    Mesh mesh;
    for (int v = 0; v < 8; ++v) {
        mesh.vertices.push_back({v & 1 ? half_width : -half_width, v & 2 ? half_width : -half_width,
                                 v & 4 ? top : top - thickness});
    }
    mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                      {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
    return mesh;
}

Mesh groove(double angle, double height, double half_length, double rest)
{
    const double mouth = height * std::tan(angle / 2), wide = mouth + rest;
    const ProfilePoint outline[] = {{0, -rest}, {wide, -rest},    {wide, height},  {mouth, height},
                                    {0, 0},     {-mouth, height}, {-wide, height}, {-wide, -rest}};
    constexpr std::uint32_t count = 8;
    Mesh mesh;
    for (const double y : {-half_length, half_length}) {
        for (const auto &[x, z] : outline) mesh.vertices.push_back({x, y, z});
    }
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::uint32_t next = (n + 1) % count;
        mesh.triangles.push_back({n, next + count, next});
        mesh.triangles.push_back({n, n + count, next + count});
    }
    // The fan from below sees both halves of the outline, each of which is convex.
    for (std::uint32_t n = 1; n + 1 < count; ++n) {
        mesh.triangles.push_back({0, n, n + 1});
        mesh.triangles.push_back({count, count + n + 1, count + n});
    }
    return mesh;
}

Point tilted(const Point &p)
{
    static const double c = std::cos(pi / 9), s = std::sin(pi / 9), d = std::cos(pi / 6),
                        t = std::sin(pi / 6);
    const Point x{p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]};
    return {d * x[0] + t * x[2], x[1], -t * x[0] + d * x[2]};
}

Mesh tilted(Mesh mesh)
{
    for (Point &p : mesh.vertices) p = tilted(p);
    return mesh;
}

} // namespace voxshell
