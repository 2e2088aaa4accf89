// SPDX-License-Identifier: GPL-3.0-or-later
// What the contact benchmarks have in common: one static part, a moving sphere of radius 12 mm as points or
// as a mesh, and 1000 rigid poses. Lengths in metres.
#pragma once

#include "import/scene.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell::bench {

inline constexpr double sphere_radius = 0.012;
inline constexpr int pose_count = 1000;
inline constexpr double step = 1e-4; ///< how far the sphere's centre goes in a tick: 0.1 m/s at 1 kHz

using Vec3 = std::array<double, 3>;

/// Moving frame -> static frame.
struct Pose {
    Vec3 position{};
    std::array<double, 4> orientation{1, 0, 0, 0}; ///< unit quaternion, w x y z
    std::array<double, 9> rotation{};              ///< the same, row by row: nobody is timed making it
};

/// The sphere's path. All but `all` are against the cup (cup.hpp), on a helix around its axis, the sphere
/// turning as if it rolled.
///   slide    on the inner wall, 0.25 mm deep        outside  on the outer wall, 0.25 mm deep
///   deep     on the inner wall, 1.5 mm deep: the middle of the wall
///   grazing  on the inner wall, 0.02 mm deep        free     in the cup, at least 15 mm from any wall
///   all      turning in place in a ball 0.01 mm larger: every point in contact (of the cells' layer: 97 in
///   100)
enum class Motion { slide, outside, deep, grazing, free, all };

inline constexpr std::array<std::string_view, 6> motion_names{"slide",   "outside", "deep",
                                                              "grazing", "free",    "all"};

/// Throws Failure(usage) for an unknown name.
Motion motion_named(std::string_view name);

std::vector<Pose> poses_of(Motion motion);

/// The same helix at any depth [m] into the inner wall of a cup that stands at `place`.
std::vector<Pose> slide_at(double depth, const Vec3 &place = {0, 0, 0});

/// The static part: the cup, or (all) a sphere of 100 k triangles.
Mesh static_mesh(Motion motion);

/// Signed distance from the static part's triangles, positive outside, by formula: the cup's profile with the
/// distance from its axis measured along the facets' normals, so that the mesh's facets and not the round cup
/// are meant; for `all` the round sphere. [m]
double static_distance(Motion motion, const Vec3 &point);

/// The moving sphere as points, evenly spread (a spherical Fibonacci lattice), in the order of our shells:
/// halved along the longest side of their box at a multiple of 64, down to runs of 64, those at a multiple of
/// 16 down to runs of 16. Structure of arrays, padded to a multiple of 16 with the last point. The inward
/// normal of point p is -p / radius.
struct Points {
    std::uint32_t count = 0;
    std::vector<float> x, y, z, nx, ny, nz;
};
Points sphere_points(std::uint32_t count);

/// The moving sphere as a mesh of about so many triangles, geodesic, outward.
Mesh sphere_mesh(std::uint32_t triangles, double radius = sphere_radius);

/// The force that exact distances give for one newton per metre and point: the sum over points in the static
/// part of depth times the gradient of the distance.
Vec3 exact_force(Motion motion, const Points &points, const Pose &pose);

} // namespace voxshell::bench
