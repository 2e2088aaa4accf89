// SPDX-License-Identifier: GPL-3.0-or-later
// Which triangles are near a box or along a ray: what wall thickness and self-intersections share.
#pragma once

#include "import/scene.hpp"

#include <cstdint>
#include <vector>

namespace voxshell {

struct Box {
    Point low, high;
    bool meets(const Box &other) const
    {
        for (int i = 0; i < 3; ++i)
            if (low[i] > other.high[i] || other.low[i] > high[i]) return false;
        return true;
    }
};

/// p + t * d for t >= first. Made once, asked of many boxes.
struct Ray {
    Ray(const Point &from, const Point &direction, double begin) : p(from), d(direction), first(begin)
    {
        for (int i = 0; i < 3; ++i) inverse[i] = 1 / d[i];
    }
    bool meets(const Box &box) const;

    Point p, d, inverse;
    double first;
};

/// A complete binary tree of boxes over the triangles in Morton order. Boxes are a rounding larger than what
/// they hold, so that no ray slips past a wall that lies in a grid plane. Built in parallel, the same for any
/// number of threads; queries are thread-safe.
class BoxTree {
  public:
    /// Keeps a reference to the mesh.
    explicit BoxTree(const Mesh &mesh);

    Box box(std::uint32_t triangle) const; ///< exactly

    /// Calls visit(triangle) for each leaf that the query (a Box or a Ray) meets, until it returns false.
    template<class Query, class Visit>
    void visit(const Query &query, Visit &&visit) const
    {
        if (order_.empty()) return;
        std::uint32_t stack[64]; // halved each time: at most 32 levels, two for each
        int top = 0;
        stack[top++] = 1;
        while (top > 0) {
            const std::uint32_t node = stack[--top];
            if (!query.meets(boxes_[node])) continue;
            if (node < leaves_) {
                stack[top++] = 2 * node + 1;
                stack[top++] = 2 * node;
                continue;
            }
            const std::uint64_t leaf = node - leaves_;
            for (std::uint64_t n = first(leaf); n < first(leaf + 1); ++n)
                if (!visit(order_[n])) return;
        }
    }

  private:
    std::uint64_t first(std::uint64_t leaf) const { return leaf * order_.size() / leaves_; }

    const Mesh &mesh_;
    std::vector<std::uint32_t> order_;
    std::uint32_t leaves_ = 1;
    std::vector<Box> boxes_; ///< as in a heap: children of n at 2n and 2n + 1, leaves from leaves_ on
};

} // namespace voxshell
