// SPDX-License-Identifier: GPL-3.0-or-later
// The force that ought to be, without cells and points: an elastic foundation on what moves.
//
// Each bit of the moving surface that is inside what stands is pushed out the shortest way, by k d dA, d its
// depth. It is where the law gradient on the field distance goes as cells and points get finer, and what
// every law is after: laws differ in what they call stiffness, so that a comparison leaves one factor free.
#pragma once

#include "mesh/mesh_distance.hpp"

#include "voxshell/pose.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace voxshell {

struct Wrench {
    Point force{};  ///< for k = 1 N/m^3 [m^3]
    Point torque{}; ///< about the moving frame's origin [m^4]
};

/// Distance of what stands: MeshDistance's functions, or a formula's.
struct Distance {
    std::function<Nearest(const Point &, std::uint32_t near)> nearest;
    std::function<int(const Point &)> side;
};
Distance distance_of(const MeshDistance &mesh);
/// Of a signed distance with its gradient.
Distance distance_of(std::function<Nearest(const Point &)> formula);

struct Foundation {
    Wrench wrench;
    double gross = 0;   ///< sum of d dA [m^3]
    double wrong = 0;   ///< of it, what pulls at the moving surface in place of pressing on it: too deep
    double deepest = 0; ///< [m]
    Point deepest_at{}, deepest_out{}; ///< where, in the scene, and the way out from there
    std::uint64_t pieces = 0;
};

/// The surface that moves, in a tree of balls.
class FoundationSurface {
  public:
    explicit FoundationSurface(const Mesh &mesh);
    ~FoundationSurface();
    FoundationSurface(const FoundationSurface &) = delete;
    FoundationSurface &operator=(const FoundationSurface &) = delete;

    /// Triangles are halved along all edges until their longest edge is at most `spacing` [m], and count by
    /// their middles; what the distance proves to be outside is left out whole. Thread-safe.
    Foundation at(const vxs_pose &pose, const Distance &distance, double spacing) const;

    double radius() const { return radius_; } ///< half the diagonal of the box around it [m]

  private:
    struct Node;
    std::vector<Node> nodes_;
    std::vector<std::array<Point, 3>> triangles_;
    double radius_ = 0;
};

/// A ball's foundation on a distance that is known as a formula, by high-order quadrature about the way to
/// the nearest point: needs no mesh. The contact must be one patch within a quarter of a turn of that way.
Wrench ball_foundation(double radius, const Point &middle, const Distance &distance);

/// Formulas [m^3], k = 1: a ball `depth` into a plane; into the inside of a round bowl.
double ball_on_plane(double radius, double depth);
double ball_in_bowl(double radius, double bowl, double depth);

} // namespace voxshell
