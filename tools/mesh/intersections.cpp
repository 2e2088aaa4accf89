// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/intersections.hpp"

#include "mesh/box_tree.hpp"
#include "mesh/edges.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

namespace voxshell {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

class Pair {
  public:
    Pair(const Mesh &mesh, const std::vector<Triangle> &welded, std::uint32_t t, std::uint32_t s)
        : mesh_(mesh), t_(t), s_(s)
    {
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                if (welded[t][i] == welded[s][j]) at_t_[shared_] = i, at_s_[shared_++] = j;
    }

    bool meet() const
    {
        switch (shared_) {
        case 0:
            return CGAL::do_intersect(triangle(t_), triangle(s_));
        case 1: {
            const auto one = triangle(t_);
            const auto across = opposite(s_, at_s_[0]);
            const auto side = [&](const auto &p) { return CGAL::orientation(one[0], one[1], one[2], p); };
            const auto source = side(across.source());
            if (source != CGAL::COPLANAR && source == side(across.target()))
                return false; // as most neighbours do
            return CGAL::do_intersect(one, across) ||
                   CGAL::do_intersect(triangle(s_), opposite(t_, at_t_[0]));
        }
        case 2: { // folded onto each other
            const auto a = point(t_, at_t_[0]), b = point(t_, at_t_[1]);
            const auto p = point(t_, 3 - at_t_[0] - at_t_[1]), q = point(s_, 3 - at_s_[0] - at_s_[1]);
            if (apart(b - a, p - a, q - a)) return false;
            return CGAL::coplanar(a, b, p, q) && CGAL::coplanar_orientation(a, b, p, q) == CGAL::POSITIVE;
        }
        default:
            return false;
        }
    }

  private:
    // Whether p and q are on different sides of the edge, clear of rounding: neighbours in a plane are, and
    // to prove them coplanar exactly takes long.
    static bool apart(const Kernel::Vector_3 &edge, const Kernel::Vector_3 &p, const Kernel::Vector_3 &q)
    {
        const double cosine = CGAL::cross_product(edge, p) * CGAL::cross_product(edge, q);
        return cosine < -1e-10 * edge.squared_length() * std::sqrt(p.squared_length() * q.squared_length());
    }

    Kernel::Point_3 point(std::uint32_t triangle, int corner) const
    {
        const Point &p = mesh_.vertices[mesh_.triangles[triangle][corner]];
        return {p[0], p[1], p[2]};
    }
    Kernel::Triangle_3 triangle(std::uint32_t t) const { return {point(t, 0), point(t, 1), point(t, 2)}; }
    Kernel::Segment_3 opposite(std::uint32_t t, int corner) const
    {
        return {point(t, (corner + 1) % 3), point(t, (corner + 2) % 3)};
    }

    const Mesh &mesh_;
    std::uint32_t t_, s_;
    int shared_ = 0, at_t_[9] = {}, at_s_[9] = {};
};

} // namespace

std::optional<std::uint64_t> self_intersections(const Mesh &mesh, std::uint64_t pairs, Progress &progress)
{
    const Edges e = edges(mesh);
    const BoxTree tree(mesh);
    const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
    const auto meets = std::make_unique<std::atomic<std::uint8_t>[]>(count);
    std::atomic<std::uint64_t> overlapping = 0;
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, count, 256), [&](const auto &range) {
        progress.check();
        for (std::uint32_t t = range.begin(); t != range.end(); ++t) {
            if (e.facets[t] != Facet::face) continue;
            const Box box = tree.box(t);
            std::uint64_t here = 0;
            tree.visit(box, [&](std::uint32_t s) {
                if (s <= t || e.facets[s] != Facet::face || !box.meets(tree.box(s))) return true;
                if (++here % 65536 == 0) {
                    progress.check();
                    if (overlapping.load(std::memory_order_relaxed) + here > pairs) return false;
                }
                if (meets[t].load(std::memory_order_relaxed) && meets[s].load(std::memory_order_relaxed))
                    return true;
                if (Pair(mesh, e.triangles, t, s).meet()) meets[t] = meets[s] = 1;
                return true;
            });
            if (overlapping.fetch_add(here, std::memory_order_relaxed) + here > pairs) return;
        }
    });
    if (overlapping > pairs) return std::nullopt;
    std::uint64_t out = 0;
    for (std::uint32_t t = 0; t < count; ++t) out += meets[t];
    return out;
}

} // namespace voxshell
