// SPDX-License-Identifier: GPL-3.0-or-later
// Signed distance of a mesh as it is, without cells, by CGAL's tree of boxes: what studies compare with.
#pragma once

#include "import/scene.hpp"

#include <memory>

namespace voxshell {

/// How far a point is from a surface, and the way from the surface to it.
struct Nearest {
    double distance = 0; ///< [m]
    Point away{};        ///< unit; 0 where there is none
};

class MeshDistance {
  public:
    /// Triangles without area are left out. Throws Failure(invalid) if none is left.
    explicit MeshDistance(const Mesh &mesh);
    ~MeshDistance();
    MeshDistance(const MeshDistance &) = delete;
    MeshDistance &operator=(const MeshDistance &) = delete;

    /// distance >= 0. On the surface `away` is a triangle's normal. Thread-safe.
    Nearest nearest(const Point &point) const;

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
