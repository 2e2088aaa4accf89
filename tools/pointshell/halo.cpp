// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/halo.hpp"

#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

namespace voxshell {
namespace {

constexpr int side = 10; // a brick and one cell around it

struct Halo {
    std::array<std::pair<std::uint64_t, std::uint64_t>, side * side * side>
        points; ///< of each cell: first, last

    static int index(int i, int j, int k) { return ((i + 1) * side + j + 1) * side + k + 1; }

    void fill(const Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
              std::size_t brick)
    {
        points.fill({0, 0});
        const BrickAt at = cells.bricks[brick].at;
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k) {
                    const BrickAt other{at[0] + i, at[1] + j, at[2] + k};
                    const auto found =
                        std::lower_bound(cells.bricks.begin(), cells.bricks.end(), other,
                                         [](const Brick &b, const BrickAt &a) { return b.at < a; });
                    if (found == cells.bricks.end() || found->at != other) continue;
                    const auto b = static_cast<std::size_t>(found - cells.bricks.begin());
                    for (std::uint64_t p = first[b]; p < first[b + 1]; ++p) {
                        const int cell = shell.points[p].cell;
                        const int x = 8 * i + (cell >> 6), y = 8 * j + (cell >> 3 & 7),
                                  z = 8 * k + (cell & 7);
                        if (x < -1 || x > 8 || y < -1 || y > 8 || z < -1 || z > 8) continue;
                        auto &range = points[index(x, y, z)];
                        if (range.first == range.second) range.first = p;
                        range.second = p + 1;
                    }
                }
    }
};

// Half of the 18 face and edge neighbours: each pair of cells once.
constexpr int ahead[9][3] = {{0, 0, 1}, {0, 1, 0},  {1, 0, 0}, {0, 1, 1}, {0, 1, -1},
                             {1, 0, 1}, {1, 0, -1}, {1, 1, 0}, {1, -1, 0}};

double distance2(const ShellPoint &p, const ShellPoint &q)
{
    double d2 = 0;
    for (int x = 0; x < 3; ++x) {
        const double d = static_cast<double>(p.position[x]) - static_cast<double>(q.position[x]);
        d2 += d * d;
    }
    return d2;
}

// visit(p, q) for the pairs of points in adjacent cells of which one is in bricks [begin, end), each pair
// once.
template<class Visit>
void each_adjacent(const Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
                   std::size_t begin, std::size_t end, Progress &progress, const Visit &visit)
{
    progress.check();
    Halo halo;
    for (std::size_t b = begin; b != end; ++b) {
        if (first[b] == first[b + 1]) continue;
        halo.fill(shell, cells, first, b);
        for (std::uint64_t p = first[b]; p < first[b + 1]; ++p) {
            const int cell = shell.points[p].cell;
            const int own = Halo::index(cell >> 6, cell >> 3 & 7, cell & 7);
            for (const auto &[i, j, k] : ahead) {
                const auto &other = halo.points[own + (i * side + j) * side + k];
                for (std::uint64_t q = other.first; q < other.second; ++q) visit(p, q);
            }
        }
    }
}

constexpr std::size_t grain = 64; // bricks

} // namespace

double gap_max(const Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
               Progress &progress, Stands stands)
{
    const auto standing = [&](std::uint64_t p) -> const ShellPoint & {
        return shell.points[stands.empty() ? p : stands[p]];
    };
    const double most2 = tbb::parallel_reduce(
        tbb::blocked_range<std::size_t>(0, cells.bricks.size(), grain), 0.0,
        [&](const tbb::blocked_range<std::size_t> &range, double most) {
            each_adjacent(shell, cells, first, range.begin(), range.end(), progress,
                          [&](std::uint64_t p, std::uint64_t q) {
                              most = std::max(most, distance2(standing(p), standing(q)));
                          });
            return most;
        },
        [](double a, double b) { return std::max(a, b); });
    return std::sqrt(most2);
}

std::vector<std::uint8_t> beside_others(const Shell &shell, const Cells &cells,
                                        const std::vector<std::uint64_t> &first, double cosine,
                                        Progress &progress)
{
    std::vector<std::uint8_t> marks(shell.points.size());
    const auto mark = [&](std::uint64_t p) { std::atomic_ref(marks[p]).store(1, std::memory_order_relaxed); };
    const auto compare = [&](std::uint64_t p, std::uint64_t q) {
        const auto &a = shell.points[p].normal, &b = shell.points[q].normal;
        double sum = 0;
        for (int x = 0; x < 3; ++x) sum += static_cast<double>(a[x]) * static_cast<double>(b[x]);
        if (sum < cosine) mark(p), mark(q);
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.bricks.size(), grain),
                      [&](const tbb::blocked_range<std::size_t> &range) {
                          each_adjacent(shell, cells, first, range.begin(), range.end(), progress, compare);
                      });
    return marks;
}

std::vector<std::uint8_t> too_far(const Shell &shell, const Cells &cells,
                                  const std::vector<std::uint64_t> &first, Stands stands, double limit,
                                  Progress &progress)
{
    std::vector<std::uint8_t> marks(shell.points.size());
    const double limit2 = limit * limit;
    const auto mark = [&](std::uint64_t p) {
        if (stands[p] != p) std::atomic_ref(marks[p]).store(1, std::memory_order_relaxed);
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.bricks.size(), grain),
                      [&](const tbb::blocked_range<std::size_t> &range) {
                          each_adjacent(shell, cells, first, range.begin(), range.end(), progress,
                                        [&](std::uint64_t p, std::uint64_t q) {
                                            if (stands[p] == stands[q] || (stands[p] == p && stands[q] == q))
                                                return;
                                            if (distance2(shell.points[stands[p]], shell.points[stands[q]]) <=
                                                limit2)
                                                return;
                                            mark(p), mark(q);
                                        });
                      });
    return marks;
}

void borrow_normals(Shell &shell, const Cells &cells, const std::vector<std::uint64_t> &first,
                    Progress &progress)
{
    const auto bare = [](const ShellPoint &p) { return p.normal == std::array<float, 3>{}; };
    std::vector<std::pair<std::uint64_t, std::array<float, 3>>>
        found; // set at the end: only own normals are lent
    Halo halo;
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        progress.check();
        const std::span<const ShellPoint> own{shell.points.data() + first[b],
                                              shell.points.data() + first[b + 1]};
        if (std::none_of(own.begin(), own.end(), bare)) continue;
        halo.fill(shell, cells, first, b);
        for (std::uint64_t p = first[b]; p < first[b + 1]; ++p) {
            const ShellPoint &point = shell.points[p];
            if (!bare(point)) continue;
            const int i = point.cell >> 6, j = point.cell >> 3 & 7, k = point.cell & 7;
            std::array<double, 3> mean{};
            double area = 0;
            for (int n = 0; n < 27; ++n) {
                const auto &other = halo.points[Halo::index(i + n / 9 - 1, j + n / 3 % 3 - 1, k + n % 3 - 1)];
                for (std::uint64_t q = other.first; q < other.second; ++q) {
                    const double a = static_cast<double>(shell.points[q].area);
                    area += a;
                    for (int x = 0; x < 3; ++x) mean[x] += a * static_cast<double>(shell.points[q].normal[x]);
                }
            }
            const auto size = [](const std::array<double, 3> &v) {
                return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            };
            if (!(size(mean) > 0.25 * area)) {
                const Brick &brick = cells.bricks[b];
                const int at[3] = {i, j, k};
                for (int x = 0; x < 3; ++x)
                    mean[x] =
                        cells.voxel *
                            (static_cast<double>(cells.origin[x] + 8 * std::int64_t{brick.at[x]} + at[x]) +
                             0.5) -
                        static_cast<double>(point.position[x]);
                if (!(size(mean) > 1e-6 * cells.voxel)) mean = {0, -1, 0};
            }
            const double length = size(mean);
            found.push_back({p,
                             {static_cast<float>(mean[0] / length), static_cast<float>(mean[1] / length),
                              static_cast<float>(mean[2] / length)}});
        }
    }
    for (const auto &[p, normal] : found) shell.points[p].normal = normal;
}

} // namespace voxshell
