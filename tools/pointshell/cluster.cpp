// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/cluster.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

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
Center middle(std::span<const ShellPoint> points, int steps, Progress &progress)
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
        progress.check();
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

constexpr std::size_t size = VXS_POINTSHELL_CLUSTER_POINTS, quarter = size / 4;

// A point on its way to its place.
struct Placed {
    std::array<std::uint32_t, 3> cell; // from Cells::origin
    std::uint32_t index;               // as it came
};

constexpr std::size_t long_work = 1 << 16; // points between two looks at whether to stop

// f(point), asking now and then whether to stop.
template<typename F>
void each(std::span<Placed> points, Progress &progress, F f)
{
    while (!points.empty()) {
        progress.check();
        const std::span<Placed> now = points.first(std::min(long_work, points.size()));
        for (Placed &p : now) f(p);
        points = points.subspan(now.size());
    }
}

// What the n-th smallest of some values is (n from 0), where value v occurs count[v] times; n is then how
// many of its kind come before it.
std::uint32_t nth(const std::vector<std::size_t> &count, std::size_t &n)
{
    std::uint32_t value = 0;
    while (n >= count[value]) n -= count[value++];
    return value;
}

// Brings the first `half` points, by cell along the axis and then by index, to the front. In passes over the
// points instead of std::nth_element, which cannot be stopped: the first point of the upper half by its cell,
// then by the upper and the lower half of its index.
void split(std::span<Placed> points, std::size_t half, int axis, std::uint32_t low, std::uint32_t high,
           Progress &progress)
{
    std::vector<std::size_t> count(high - low + 1);
    each(points, progress, [&](const Placed &p) { ++count[p.cell[axis] - low]; });
    std::size_t before = half;
    const std::uint32_t cell = low + nth(count, before);
    count.assign(1 << 16, 0);
    each(points, progress, [&](const Placed &p) {
        if (p.cell[axis] == cell) ++count[p.index >> 16];
    });
    const std::uint32_t upper = nth(count, before);
    count.assign(1 << 16, 0);
    each(points, progress, [&](const Placed &p) {
        if (p.cell[axis] == cell && p.index >> 16 == upper) ++count[p.index & 0xffff];
    });
    const std::uint32_t index = upper << 16 | nth(count, before);
    Placed *end = points.data();
    each(points, progress, [&](Placed &p) {
        if (p.cell[axis] < cell || (p.cell[axis] == cell && p.index < index)) std::swap(*end++, p);
    });
}

// The order of cluster.hpp. Which points make a half does not depend on how they are found.
void halve(std::span<Placed> points, Progress &progress)
{
    if (points.size() <= quarter) {
        std::sort(points.begin(), points.end(),
                  [](const Placed &a, const Placed &b) { return a.index < b.index; });
        return;
    }
    std::array<std::uint32_t, 3> low = points[0].cell, high = low;
    each(points, progress, [&](const Placed &p) {
        for (int i = 0; i < 3; ++i) {
            low[i] = std::min(low[i], p.cell[i]);
            high[i] = std::max(high[i], p.cell[i]);
        }
    });
    int axis = 0;
    for (int i = 1; i < 3; ++i)
        if (high[i] - low[i] > high[axis] - low[axis]) axis = i;
    const std::size_t run = points.size() > size ? size : quarter, runs = (points.size() + run - 1) / run,
                      half = runs / 2 * run;
    if (points.size() > long_work)
        split(points, half, axis, low[axis], high[axis], progress);
    else
        std::nth_element(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(half), points.end(),
                         [axis](const Placed &a, const Placed &b) {
                             return a.cell[axis] != b.cell[axis] ? a.cell[axis] < b.cell[axis]
                                                                 : a.index < b.index;
                         });
    const std::span<Placed> lower = points.first(half), upper = points.subspan(half);
    constexpr std::size_t worth_a_task = 1 << 14;
    if (points.size() <= worth_a_task) {
        halve(lower, progress);
        halve(upper, progress);
        return;
    }
    progress.check();
    tbb::parallel_invoke([&, lower] { halve(lower, progress); }, [&, upper] { halve(upper, progress); });
}

void order(std::vector<ShellPoint> &points, const Cells &cells, Progress &progress)
{
    std::vector<Placed> placed(points.size());
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t p) {
        if (p % long_work == 0) progress.check();
        const BrickAt &at = cells.bricks[points[p].brick].at;
        const int cell = points[p].cell, within[3] = {cell >> 6, cell >> 3 & 7, cell & 7};
        for (int i = 0; i < 3; ++i) placed[p].cell[i] = static_cast<std::uint32_t>(8 * at[i] + within[i]);
        placed[p].index = static_cast<std::uint32_t>(p);
    });
    halve(placed, progress);
    // In place, cycle by cycle: place p takes the point `index`, and is done when it names itself.
    std::size_t moved = 0;
    for (std::uint32_t start = 0; start < placed.size(); ++start) {
        if (placed[start].index == start) continue;
        const ShellPoint first = points[start];
        std::uint32_t to = start;
        for (;;) {
            const std::uint32_t from = placed[to].index;
            placed[to].index = to;
            if (from == start) break;
            points[to] = points[from];
            if (++moved % long_work == 0) progress.check(); // what is left half moved is thrown away
            to = from;
        }
        points[to] = first;
    }
}

} // namespace

void cluster(Shell &shell, const Cells &cells, Progress &progress)
{
    if (shell.points.size() > quarter) order(shell.points, cells, progress);
    const std::span<const ShellPoint> points = shell.points;
    shell.clusters.resize((points.size() + size - 1) / size);
    if (points.empty()) return;
    tbb::parallel_for(std::size_t{0}, shell.clusters.size(), [&](std::size_t c) {
        if (c % 1024 == 0) progress.check();
        const std::span<const ShellPoint> own =
            points.subspan(c * size, std::min(size, points.size() - c * size));
        Cluster &out = shell.clusters[c];
        out.first = static_cast<std::uint32_t>(c * size);
        out.count = static_cast<std::uint32_t>(own.size());
        const Center center = middle(own, 12, progress);
        Center stored;
        for (int i = 0; i < 3; ++i) {
            out.center[i] = static_cast<float>(center[i]);
            stored[i] = static_cast<double>(out.center[i]);
        }
        out.radius = radius_up<float>(farthest(own, stored).distance2);
    });
    shell.center = middle(points, 12, progress);
    shell.radius = radius_up<double>(farthest(points, shell.center).distance2);
}

} // namespace voxshell
