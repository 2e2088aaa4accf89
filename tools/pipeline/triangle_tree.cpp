// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/triangle_tree.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace voxshell {
namespace {

constexpr std::uint32_t leaf_triangles = 4;

double squared_distance_to_segment(const Point &p, const Point &a, const Point &b)
{
    const Point ab = minus(b, a), ap = minus(p, a);
    const double length = dot(ab, ab);
    const double t = length > 0 ? std::clamp(dot(ap, ab) / length, 0.0, 1.0) : 0;
    const Point to{ap[0] - t * ab[0], ap[1] - t * ab[1], ap[2] - t * ab[2]};
    return dot(to, to);
}

/// The foot on the plane where it is inside the triangle, else the nearest of the three sides.
double squared_distance_to_triangle(const Point &p, const Point &a, const Point &b, const Point &c)
{
    const Point n = cross(minus(b, a), minus(c, a));
    const double nn = dot(n, n);
    if (nn > 0) {
        const bool inside = dot(cross(minus(b, a), minus(p, a)), n) >= 0 &&
                            dot(cross(minus(c, b), minus(p, b)), n) >= 0 &&
                            dot(cross(minus(a, c), minus(p, c)), n) >= 0;
        if (inside) {
            const double along = dot(minus(p, a), n);
            return along * along / nn;
        }
    }
    return std::min({squared_distance_to_segment(p, a, b), squared_distance_to_segment(p, b, c),
                     squared_distance_to_segment(p, c, a)});
}

double squared_distance_to_box(const Point &p, const Point &low, const Point &high)
{
    double sum = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const double d = std::max({low[a] - p[a], p[a] - high[a], 0.0});
        sum += d * d;
    }
    return sum;
}

/// Sutherland-Hodgman against the six planes; what is left of the triangle is in the box.
bool triangle_meets_box(const Point &a, const Point &b, const Point &c, const Point &low, const Point &high)
{
    std::array<Point, 9> polygon{a, b, c}, clipped;
    std::size_t count = 3;
    for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
            const double limit = sign > 0 ? low[axis] : -high[axis];
            std::size_t kept = 0;
            for (std::size_t n = 0; n < count; ++n) {
                const Point &from = polygon[n], &to = polygon[(n + 1) % count];
                const double d0 = sign * from[axis] - limit, d1 = sign * to[axis] - limit;
                if (d0 >= 0) clipped[kept++] = from;
                if ((d0 >= 0) != (d1 >= 0)) {
                    const double t = d0 / (d0 - d1);
                    Point &cut = clipped[kept++];
                    for (std::size_t k = 0; k < 3; ++k) cut[k] = from[k] + t * (to[k] - from[k]);
                    cut[axis] = sign * limit;
                }
            }
            count = kept;
            std::copy_n(clipped.begin(), count, polygon.begin());
            if (count == 0) return false;
        }
    return true;
}

} // namespace

TriangleTree::TriangleTree(const Mesh &mesh) : mesh_(mesh), order_(mesh.triangles.size())
{
    std::iota(order_.begin(), order_.end(), 0u);
    std::vector<Point> centroids(order_.size());
    for (std::uint32_t t = 0; t < centroids.size(); ++t)
        for (std::size_t a = 0; a < 3; ++a)
            centroids[t][a] = corner(t, 0)[a] / 3 + corner(t, 1)[a] / 3 + corner(t, 2)[a] / 3;
    nodes_.reserve(2 * order_.size() + 1);
    nodes_.emplace_back();
    build(0, 0, static_cast<std::uint32_t>(order_.size()), centroids);
}

void TriangleTree::build(std::uint32_t node, std::uint32_t first, std::uint32_t count,
                         const std::vector<Point> &centroids)
{
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Point low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity}, least = low, most = high;
    for (std::uint32_t n = first; n < first + count; ++n)
        for (std::size_t a = 0; a < 3; ++a) {
            for (int c = 0; c < 3; ++c) {
                low[a] = std::min(low[a], corner(order_[n], c)[a]);
                high[a] = std::max(high[a], corner(order_[n], c)[a]);
            }
            least[a] = std::min(least[a], centroids[order_[n]][a]);
            most[a] = std::max(most[a], centroids[order_[n]][a]);
        }
    nodes_[node] = {low, high, first, count};
    if (count <= leaf_triangles) return;
    const Point spread = minus(most, least);
    const auto axis =
        static_cast<std::size_t>(std::max_element(spread.begin(), spread.end()) - spread.begin());
    const auto begin = order_.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
        return centroids[a][axis] != centroids[b][axis] ? centroids[a][axis] < centroids[b][axis] : a < b;
    });
    const auto children = static_cast<std::uint32_t>(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[node].first = children;
    nodes_[node].count = 0;
    build(children, first, count / 2, centroids);
    build(children + 1, first + count / 2, count - count / 2, centroids);
}

double TriangleTree::distance(const Point &p) const
{
    double best = std::numeric_limits<double>::infinity();
    std::array<std::uint32_t, 128> stack; // halved each time: at most 32 levels
    std::size_t size = 0;
    stack[size++] = 0;
    while (size) {
        const Node &node = nodes_[stack[--size]];
        if (squared_distance_to_box(p, node.low, node.high) >= best) continue;
        for (std::uint32_t n = node.first; n < node.first + node.count; ++n)
            best = std::min(best, squared_distance_to_triangle(p, corner(order_[n], 0), corner(order_[n], 1),
                                                               corner(order_[n], 2)));
        if (node.count) continue;
        const Node &left = nodes_[node.first], &right = nodes_[node.first + 1];
        const bool left_nearer = squared_distance_to_box(p, left.low, left.high) <
                                 squared_distance_to_box(p, right.low, right.high);
        stack[size++] = node.first + left_nearer; // the nearer one is looked at first
        stack[size++] = node.first + !left_nearer;
    }
    return std::sqrt(best);
}

bool TriangleTree::meets(const Point &low, const Point &high) const
{
    std::array<std::uint32_t, 128> stack;
    std::size_t size = 0;
    stack[size++] = 0;
    while (size) {
        const Node &node = nodes_[stack[--size]];
        bool apart = false;
        for (std::size_t a = 0; a < 3; ++a) apart |= node.low[a] > high[a] || node.high[a] < low[a];
        if (apart) continue;
        for (std::uint32_t n = node.first; n < node.first + node.count; ++n)
            if (triangle_meets_box(corner(order_[n], 0), corner(order_[n], 1), corner(order_[n], 2), low,
                                   high))
                return true;
        if (node.count) continue;
        stack[size++] = node.first;
        stack[size++] = node.first + 1;
    }
    return false;
}

} // namespace voxshell
