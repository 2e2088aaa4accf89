// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/thin.hpp"

#include "pointshell/halo.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace voxshell {
namespace {

using Run = std::pair<std::uint64_t, std::uint64_t>; // points of one block: first, last

int block_of(const ShellPoint &p)
{
    return p.cell & 0b110'110'110;
}

std::array<double, 3> wide(const std::array<float, 3> &v)
{
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

std::array<double, 3> from_to(const ShellPoint &p, const ShellPoint &q)
{
    const auto a = wide(p.position), b = wide(q.position);
    return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}

class Thinner {
  public:
    Thinner(const Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first, double angle,
            Progress &progress)
        : points_(shell.points), cells_(cells), cosine_(cosine_of(angle)),
          height_(std::sin(angle) * shell.voxel),
          stays_(beside_others(shell, cells, first, cosine_, progress))
    {
    }

    // Who stands for the points of one block.
    void block(const Run &run, std::vector<std::uint32_t> &stands) const
    {
        const std::uint64_t kept = nearest_to_anchor(run);
        if (kept == run.second) return;
        for (std::uint64_t p = run.first; p < run.second; ++p)
            if (p != kept && !stays(run, p) && agrees(points_[kept], points_[p]))
                stands[p] = static_cast<std::uint32_t>(kept);
    }

  private:
    // Of stored normals, which are unit to 1e-6 only.
    static double cosine_of(double angle) { return std::cos(angle) - 1e-6; }

    bool stays(const Run &run, std::uint64_t p) const
    {
        return stays_[p] || (p > run.first && points_[p - 1].cell == points_[p].cell) ||
               (p + 1 < run.second && points_[p + 1].cell == points_[p].cell);
    }

    // The same place of every block, the centre of its first cell: so kept points of a plane stand in rows, 2
    // h apart.
    std::uint64_t nearest_to_anchor(const Run &run) const
    {
        std::array<double, 3> anchor;
        const BrickAt &at = cells_.bricks[points_[run.first].brick].at;
        const int block = block_of(points_[run.first]), within[3] = {block >> 6, block >> 3 & 7, block & 7};
        for (int i = 0; i < 3; ++i)
            anchor[i] = cells_.voxel *
                        (static_cast<double>(cells_.origin[i] + 8 * std::int64_t{at[i]} + within[i]) + 0.5);
        std::uint64_t best = run.second;
        double least = INFINITY;
        for (std::uint64_t p = run.first; p < run.second; ++p) {
            if (stays(run, p)) continue;
            const auto position = wide(points_[p].position);
            const std::array<double, 3> off{position[0] - anchor[0], position[1] - anchor[1],
                                            position[2] - anchor[2]};
            if (dot(off, off) < least) least = dot(off, off), best = p;
        }
        return best;
    }

    bool agrees(const ShellPoint &kept, const ShellPoint &other) const
    {
        const auto normal = wide(kept.normal);
        return dot(normal, wide(other.normal)) >= cosine_ &&
               std::abs(dot(from_to(kept, other), normal)) <= height_;
    }

    const std::vector<ShellPoint> &points_;
    const Cells &cells_;
    double cosine_, height_;
    std::vector<std::uint8_t> stays_; // for what is around it
};

} // namespace

void thin(Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first, double angle,
          Progress &progress)
{
    std::vector<ShellPoint> &points = shell.points;
    std::vector<std::uint32_t> stands(points.size());
    for (std::uint32_t p = 0; p < stands.size(); ++p) stands[p] = p;
    const Thinner thinner(shell, cells, first, angle, progress);
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, cells.bricks.size(), 64),
        [&](const tbb::blocked_range<std::size_t> &range) {
            for (std::size_t b = range.begin(); b != range.end(); ++b)
                for (std::uint64_t begin = first[b], end = begin; begin < first[b + 1]; begin = end) {
                    while (end < first[b + 1] && block_of(points[end]) == block_of(points[begin])) ++end;
                    thinner.block({begin, end}, stands);
                }
        });

    // Points come back, each its own again, until none is too far. Each round brings back at least one.
    const double limit = 3 * shell.voxel;
    for (bool again = true; again;) {
        const std::vector<std::uint8_t> back = too_far(shell, cells, first, stands, limit, progress);
        again = false;
        for (std::uint32_t p = 0; p < stands.size(); ++p)
            if (back[p]) stands[p] = p, again = true;
    }

    Thinning &report = shell.thinning;
    report = {};
    report.angle = angle;
    report.points_before = points.size();
    report.gap_before = shell.gap_max;
    shell.gap_max = gap_max(shell, cells, first, progress, stands);

    std::vector<double> area(points.size());
    double least_cosine = 1, farthest2 = 0;
    for (std::uint32_t p = 0; p < stands.size(); ++p) {
        const ShellPoint &kept = points[stands[p]];
        area[stands[p]] += static_cast<double>(points[p].area);
        if (stands[p] == p) continue;
        const auto off = from_to(kept, points[p]);
        farthest2 = std::max(farthest2, dot(off, off));
        const auto a = wide(kept.normal), b = wide(points[p].normal);
        least_cosine = std::min(least_cosine, dot(a, b) / std::sqrt(dot(a, a) * dot(b, b)));
    }
    report.distance_max = std::sqrt(farthest2);
    report.normal_max = std::acos(std::clamp(least_cosine, -1.0, 1.0));

    std::size_t kept = 0;
    shell.surface_cells = 0;
    for (std::uint32_t p = 0; p < stands.size(); ++p) {
        if (stands[p] != p) continue;
        ShellPoint point = points[p];
        point.area = static_cast<float>(area[p]);
        const bool same_cell =
            kept > 0 && points[kept - 1].brick == point.brick && points[kept - 1].cell == point.cell;
        shell.surface_cells += !same_cell;
        points[kept++] = point;
    }
    points.resize(kept);
}

} // namespace voxshell
