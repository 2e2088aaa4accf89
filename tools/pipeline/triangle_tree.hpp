// SPDX-License-Identifier: GPL-3.0-or-later
// Distance and box queries on a mesh, in doubles and without the lattice: what measures must not share the
// code of what it measures.
#pragma once

#include "import/scene.hpp"

#include <functional>
#include <vector>

namespace voxshell {

class TriangleTree {
  public:
    /// Keeps a reference to the mesh.
    explicit TriangleTree(const Mesh &mesh);

    /// Distance [m] from `p` to the nearest triangle, degenerate ones included.
    double distance(const Point &p) const;

    /// Whether a triangle has a point in the closed box: by clipping its polygon plane by plane.
    bool meets(const Point &low, const Point &high) const;

  private:
    struct Node {
        Point low, high;
        std::uint32_t first, count; ///< leaf: of order_; inner: count 0, children at first and first + 1
    };
    void build(std::uint32_t node, std::uint32_t first, std::uint32_t count,
               const std::vector<Point> &centroids);
    const Point &corner(std::uint32_t triangle, int c) const
    {
        return mesh_.vertices[mesh_.triangles[triangle][static_cast<std::size_t>(c)]];
    }

    const Mesh &mesh_;
    std::vector<std::uint32_t> order_;
    std::vector<Node> nodes_;
};

} // namespace voxshell
