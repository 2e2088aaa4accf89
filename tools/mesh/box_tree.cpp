// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/box_tree.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace voxshell {
namespace {

constexpr std::uint64_t leaf_triangles = 4;

std::uint64_t spread(std::uint64_t x) // 21 bits to every third
{
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

void add(Box &box, const Box &other)
{
    for (int i = 0; i < 3; ++i) {
        box.low[i] = std::min(box.low[i], other.low[i]);
        box.high[i] = std::max(box.high[i], other.high[i]);
    }
}

} // namespace

bool Ray::meets(const Box &box) const
{
    double from = first, to = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
        if (d[i] == 0) { // the product below would be no number on a face's plane
            if (p[i] < box.low[i] || p[i] > box.high[i]) return false;
            continue;
        }
        const double a = (box.low[i] - p[i]) * inverse[i], b = (box.high[i] - p[i]) * inverse[i];
        from = std::max(from, std::min(a, b));
        to = std::min(to, std::max(a, b));
    }
    return from <= to;
}

Box BoxTree::box(std::uint32_t triangle) const
{
    const auto &[a, b, c] = mesh_.triangles[triangle];
    Box out;
    for (int i = 0; i < 3; ++i) {
        const auto [low, high] =
            std::minmax({mesh_.vertices[a][i], mesh_.vertices[b][i], mesh_.vertices[c][i]});
        out.low[i] = low, out.high[i] = high;
    }
    return out;
}

BoxTree::BoxTree(const Mesh &mesh) : mesh_(mesh)
{
    const std::size_t n = mesh.triangles.size();
    if (n == 0) return;
    Box all = box(0);
    for (std::uint32_t t = 1; t < n; ++t) add(all, box(t));
    double size = 0, largest = 0;
    for (int i = 0; i < 3; ++i) {
        size = std::max(size, all.high[i] - all.low[i]);
        largest = std::max({largest, std::abs(all.low[i]), std::abs(all.high[i])});
    }
    std::vector<std::pair<std::uint64_t, std::uint32_t>> codes(n);
    tbb::parallel_for(
        tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(n), 4096), [&](const auto &range) {
            for (std::uint32_t t = range.begin(); t != range.end(); ++t) {
                const Box b = box(t);
                std::uint64_t code = 0;
                for (int i = 0; i < 3 && size > 0; ++i) {
                    const double at = ((b.low[i] - all.low[i]) / 2 + (b.high[i] - all.low[i]) / 2) / size;
                    code |= spread(static_cast<std::uint64_t>(std::clamp(at * 0x1p21, 0.0, 0x1.fffffp20)))
                            << i;
                }
                codes[t] = {code, t};
            }
        });
    tbb::parallel_sort(codes.begin(), codes.end());
    order_.resize(n);
    for (std::size_t t = 0; t < n; ++t) order_[t] = codes[t].second;

    leaves_ = static_cast<std::uint32_t>(std::bit_ceil((n + leaf_triangles - 1) / leaf_triangles));
    boxes_.resize(2 * std::size_t{leaves_});
    const double rounding = 4 * std::numeric_limits<double>::epsilon() * largest;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, leaves_, 1024), [&](const auto &range) {
        for (std::uint32_t leaf = range.begin(); leaf != range.end(); ++leaf) {
            Box b{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}}; // met by nothing
            for (std::uint64_t k = first(leaf); k < first(leaf + std::uint64_t{1}); ++k)
                add(b, box(order_[k]));
            for (int i = 0; i < 3; ++i) b.low[i] -= rounding, b.high[i] += rounding;
            boxes_[leaves_ + leaf] = b;
        }
    });
    for (std::uint32_t node = leaves_ - 1; node > 0; --node) {
        boxes_[node] = boxes_[2 * node];
        add(boxes_[node], boxes_[2 * node + 1]);
    }
}

} // namespace voxshell
