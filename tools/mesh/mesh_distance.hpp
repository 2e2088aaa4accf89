// SPDX-License-Identifier: GPL-3.0-or-later
// Signed distance of a mesh as it is, without cells, by CGAL's tree of boxes: what studies compare with.
#pragma once

#include "import/scene.hpp"

#include <cstdint>
#include <memory>

namespace voxshell {

inline constexpr std::uint32_t no_triangle = 0xffffffff;

/// How far a point is from a surface, and the way from the surface to it.
struct Nearest {
    double distance = 0;                  ///< [m]
    Point away{};                         ///< unit; 0 where there is none
    int side = 0;                         ///< -1 inside, +1 outside, 0: it does not tell
    std::uint32_t triangle = no_triangle; ///< the nearest one, as the distance numbers them
};

class MeshDistance {
  public:
    /// Triangles without area are left out. Throws Failure(invalid) if none is left.
    explicit MeshDistance(const Mesh &mesh);
    ~MeshDistance();
    MeshDistance(const MeshDistance &) = delete;
    MeshDistance &operator=(const MeshDistance &) = delete;

    /// distance >= 0. On the surface `away` is a triangle's normal. Thread-safe. side: right over or under a
    /// triangle of a closed, oriented mesh without self-intersections, where all of a triangle's front is on
    /// one side: asked of side() once, and known from then on.
    /// near: Nearest::triangle of a point nearby, where the search begins; what it finds does not hang on it.
    Nearest nearest(const Point &point, std::uint32_t near = no_triangle) const;

    /// -1 inside, +1 outside: inside where a ray to far away leaves through more faces than it enters by
    /// (counter-clockwise seen from outside). Thread-safe.
    int side(const Point &point) const;

    /// The nearest point of the surface itself. Thread-safe.
    Point foot(const Point &point) const;

  private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

} // namespace voxshell
