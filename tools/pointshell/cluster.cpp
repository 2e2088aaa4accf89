// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/cluster.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

namespace voxshell {
namespace {

using Center = std::array<double, 3>;

struct Farthest {
    double distance2 = 0;
    const ShellPoint *point = nullptr;
};

// In the order of S404's brackets.
Farthest farthest(std::span<const ShellPoint> points, const Center &c)
{
    Farthest out;
    for (const ShellPoint &p : points) {
        const double x = static_cast<double>(p.position[0]) - c[0],
                     y = static_cast<double>(p.position[1]) - c[1],
                     z = static_cast<double>(p.position[2]) - c[2];
        const double d = (x * x + y * y) + z * z;
        if (!out.point || d > out.distance2) out = {d, &p};
    }
    return out;
}

// A small enclosing sphere's centre: the box's, then steps towards the farthest point (Badoiu, Clarkson
// 2003).
Center middle(std::span<const ShellPoint> points, int steps)
{
    Center low, high, c;
    for (int i = 0; i < 3; ++i) low[i] = high[i] = static_cast<double>(points[0].position[i]);
    for (const ShellPoint &p : points)
        for (int i = 0; i < 3; ++i) {
            low[i] = std::min(low[i], static_cast<double>(p.position[i]));
            high[i] = std::max(high[i], static_cast<double>(p.position[i]));
        }
    for (int i = 0; i < 3; ++i) c[i] = (low[i] + high[i]) / 2;
    Center best = c;
    double least = std::numeric_limits<double>::infinity();
    for (int step = 0; step <= steps; ++step) {
        const Farthest far = farthest(points, c);
        if (far.distance2 < least) least = far.distance2, best = c;
        for (int i = 0; i < 3; ++i) c[i] += (static_cast<double>(far.point->position[i]) - c[i]) / (step + 4);
    }
    return best;
}

// Smallest value of the type whose square, in double, is at least distance2.
template<class Real>
Real radius_up(double distance2)
{
    Real r = static_cast<Real>(std::sqrt(distance2));
    while (static_cast<double>(r) * static_cast<double>(r) < distance2)
        r = std::nextafter(r, std::numeric_limits<Real>::infinity());
    return r;
}

} // namespace

std::uint64_t morton(std::uint32_t i, std::uint32_t j, std::uint32_t k)
{
    const auto spread = [](std::uint64_t x) {
        x = (x | x << 32) & 0x1f00000000ffffu;
        x = (x | x << 16) & 0x1f0000ff0000ffu;
        x = (x | x << 8) & 0x100f00f00f00f00fu;
        x = (x | x << 4) & 0x10c30c30c30c30c3u;
        return (x | x << 2) & 0x1249249249249249u;
    };
    return spread(i) << 2 | spread(j) << 1 | spread(k);
}

void cluster(Shell &shell)
{
    constexpr std::size_t size = VXS_POINTSHELL_CLUSTER_POINTS;
    const std::span<const ShellPoint> points = shell.points;
    shell.clusters.resize((points.size() + size - 1) / size);
    if (points.empty()) return;
    tbb::parallel_for(std::size_t{0}, shell.clusters.size(), [&](std::size_t c) {
        const std::span<const ShellPoint> own =
            points.subspan(c * size, std::min(size, points.size() - c * size));
        Cluster &out = shell.clusters[c];
        out.first = static_cast<std::uint32_t>(c * size);
        out.count = static_cast<std::uint32_t>(own.size());
        const Center center = middle(own, 12);
        Center stored;
        for (int i = 0; i < 3; ++i) {
            out.center[i] = static_cast<float>(center[i]);
            stored[i] = static_cast<double>(out.center[i]);
        }
        out.radius = radius_up<float>(farthest(own, stored).distance2);
    });
    shell.center = middle(points, 12);
    shell.radius = radius_up<double>(farthest(points, shell.center).distance2);
}

} // namespace voxshell
