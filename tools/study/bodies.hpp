// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of the studies: closed, outward, in metres, about the z axis.
#pragma once

#include "import/scene.hpp"

#include <vector>

namespace voxshell {

using ProfilePoint = std::array<double, 2>; ///< distance from the axis, height [m]

/// A profile turned about the z axis, `count` times a turn. It runs upwards outside: from the axis to the
/// axis, or (`ring`) round a closed loop that does not touch it. A point on the axis becomes one vertex.
Mesh revolved(const std::vector<ProfilePoint> &profile, std::uint32_t count, bool ring = false);

Mesh ball(double radius, std::uint32_t rings = 128);
Mesh cylinder(double radius, double half_length, std::uint32_t count = 720);
/// Outer and inner radius, height, floor; open at the top, standing on z = 0.
Mesh cup(double outer, double inner, double height, double floor, std::uint32_t count = 360);
/// A block with a round hole through it, 0 <= z <= height.
Mesh holed_block(double hole, double outer, double height, std::uint32_t count = 360);
/// Its top is at z = top.
Mesh slab(double half_width, double top, double thickness);
/// A block with a V groove along y whose edge is the y axis: it opens upwards by `angle` [rad], `height`
/// high; `rest` of the block is around and below it.
Mesh groove(double angle, double height, double half_length, double rest);

/// Ry(30 degrees) Rx(20 degrees): askew to the grid, of figure 8 c and d.
Point tilted(const Point &p);
Mesh tilted(Mesh mesh);

} // namespace voxshell
