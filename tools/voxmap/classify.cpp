// SPDX-License-Identifier: GPL-3.0-or-later
// Components of the cells that are not surface, without ever storing those cells.
//
// Along k every column of cells is a sequence of runs between surface cells. A column without a surface cell,
// and the two ends of any other, reach the border of the scene: they are outside. What is left are the runs
// between two surface cells of one column: there are fewer of them than surface cells, and a union-find over
// the runs that overlap in neighbouring columns is the whole flood fill.
#include "voxmap/classify.hpp"

#include "voxmap/dilate.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <numeric>
#include <tbb/parallel_for.h>

namespace voxshell {
namespace {

constexpr std::uint32_t outside = 0; ///< the node of the outside component

struct Run {
    std::int32_t first, last; ///< k, inclusive, relative to Cells::origin
};

/// Bricks [begin, end) share (i, j): 64 columns of cells.
struct BrickColumn {
    std::int32_t i, j;
    std::size_t begin, end;
};

struct Columns {
    std::vector<BrickColumn> bricks; ///< sorted by (i, j)
    std::vector<std::uint32_t>
        start;             ///< runs of column c of brick column b: [start[64 b + c], start[64 b + c + 1])
    std::vector<Run> runs; ///< run r is node r + 1
    std::vector<std::int32_t> low, high; ///< first and last surface k per column; low > high: no surface cell
};

/// Threads may look for roots and unite at the same time: whatever one of them reads of a node that is not a
/// root is an ancestor of it.
std::uint32_t root(std::vector<std::uint32_t> &parent, std::uint32_t node)
{
    for (;;) {
        const std::atomic_ref own(parent[node]);
        const std::uint32_t up = own.load(std::memory_order_relaxed);
        if (up == node) return node;
        const std::uint32_t above = std::atomic_ref(parent[up]).load(std::memory_order_relaxed);
        if (above != up) own.store(above, std::memory_order_relaxed);
        node = above;
    }
}

/// The smaller index becomes the root: the result does not depend on the order of unions.
void unite(std::vector<std::uint32_t> &parent, std::uint32_t a, std::uint32_t b)
{
    for (;;) {
        a = root(parent, a);
        b = root(parent, b);
        if (a == b) return;
        if (a < b) std::swap(a, b);
        std::uint32_t still = a;
        if (std::atomic_ref(parent[a]).compare_exchange_weak(still, b, std::memory_order_relaxed)) return;
    }
}

Columns find_runs(const Cells &cells)
{
    Columns out;
    for (std::size_t b = 0; b < cells.bricks.size();) {
        std::size_t end = b + 1;
        while (end < cells.bricks.size() && cells.bricks[end].at[0] == cells.bricks[b].at[0] &&
               cells.bricks[end].at[1] == cells.bricks[b].at[1])
            ++end;
        out.bricks.push_back({cells.bricks[b].at[0], cells.bricks[b].at[1], b, end});
        b = end;
    }
    const std::size_t columns = out.bricks.size() * 64;
    out.low.assign(columns, 1);
    out.high.assign(columns, 0);
    const auto each_gap = [&](std::size_t column, auto &&gap) {
        const BrickColumn &at = out.bricks[column >> 6];
        const int ci = static_cast<int>(column >> 3 & 7), cj = static_cast<int>(column & 7);
        std::int32_t last = -1; // the surface cell before
        for (std::size_t b = at.begin; b < at.end; ++b) {
            unsigned bits = static_cast<unsigned>(cells.bricks[b].surface[ci] >> (8 * cj) & 0xff);
            const std::int32_t base = 8 * cells.bricks[b].at[2];
            while (bits) { // a sequence of surface cells at a time
                const unsigned first = bits & -bits, above = bits & (bits + first);
                const std::int32_t k = base + std::countr_zero(first);
                if (last < 0)
                    out.low[column] = k;
                else if (k > last + 1)
                    gap(Run{last + 1, k - 1});
                last = base + std::countr_zero(bits + first) - 1;
                bits = above;
            }
        }
        if (last >= 0) out.high[column] = last;
    };
    std::vector<std::uint32_t> count(columns + 1, 0);
    tbb::parallel_for(std::size_t{0}, columns,
                      [&](std::size_t c) { each_gap(c, [&](Run) { ++count[c + 1]; }); });
    std::partial_sum(count.begin(), count.end(), count.begin());
    out.runs.resize(count.back());
    tbb::parallel_for(std::size_t{0}, columns, [&](std::size_t c) {
        std::uint32_t next = count[c];
        each_gap(c, [&](Run run) { out.runs[next++] = run; });
    });
    out.start = std::move(count);
    return out;
}

/// Unites the runs of two neighbouring columns that overlap in k, and runs that overlap the other's outer
/// ends.
void join_columns(const Columns &columns, std::size_t a, std::size_t b, std::vector<std::uint32_t> &parent)
{
    for (const auto &[from, to] : {std::pair{a, b}, std::pair{b, a}}) {
        const std::int32_t low = columns.low[to], high = columns.high[to];
        for (std::uint32_t r = columns.start[from]; r < columns.start[from + 1]; ++r)
            if (low > high || columns.runs[r].first < low || columns.runs[r].last > high)
                unite(parent, r + 1, outside);
    }
    std::uint32_t p = columns.start[a], q = columns.start[b];
    while (p < columns.start[a + 1] && q < columns.start[b + 1]) {
        const Run &x = columns.runs[p], &y = columns.runs[q];
        if (x.first <= y.last && y.first <= x.last) unite(parent, p + 1, q + 1);
        x.last < y.last ? ++p : ++q;
    }
}

/// Cells of column `column` at height k as the scene sees them.
Point center(const Cells &cells, const Columns &columns, std::size_t column, std::int64_t k)
{
    const BrickColumn &at = columns.bricks[column >> 6];
    const std::int64_t cell[3] = {8 * std::int64_t{at.i} + static_cast<std::int64_t>(column >> 3 & 7),
                                  8 * std::int64_t{at.j} + static_cast<std::int64_t>(column & 7), k};
    Point p;
    for (int a = 0; a < 3; ++a) p[a] = cells.voxel * (static_cast<double>(cells.origin[a] + cell[a]) + 0.5);
    return p;
}

std::size_t column_of(const Columns &columns, std::uint32_t run)
{
    return static_cast<std::size_t>(std::upper_bound(columns.start.begin(), columns.start.end(), run) -
                                    columns.start.begin()) -
           1;
}

/// Outside cells next to the surface, evenly over the scene, that the winding number calls inside.
std::optional<Leak> find_leak(const Cells &cells, const Columns &columns,
                              const std::vector<std::uint32_t> &node_root, const WindingNumber &winding)
{
    constexpr std::size_t most = 8192;
    std::vector<Point> samples;
    const std::size_t runs = columns.runs.size(), run_step = std::max<std::size_t>(1, runs / (most / 2));
    for (std::size_t r = 0; r < runs; r += run_step)
        if (node_root[r + 1] == outside)
            samples.push_back(center(cells, columns, column_of(columns, static_cast<std::uint32_t>(r)),
                                     (std::int64_t{columns.runs[r].first} + columns.runs[r].last) / 2));
    const std::size_t count = columns.low.size(), column_step = std::max<std::size_t>(1, count / (most / 4));
    for (std::size_t c = 0; c < count; c += column_step)
        if (columns.low[c] <= columns.high[c]) {
            samples.push_back(center(cells, columns, c, std::int64_t{columns.low[c]} - 1));
            samples.push_back(center(cells, columns, c, std::int64_t{columns.high[c]} + 1));
        }
    std::vector<double> value(samples.size());
    tbb::parallel_for(std::size_t{0}, samples.size(),
                      [&](std::size_t s) { value[s] = winding.at(samples[s]); });
    std::optional<Leak> leak;
    for (std::size_t s = 0; s < samples.size(); ++s) {
        if (std::abs(value[s]) < 0.5) continue;
        if (!leak) leak = Leak{samples[s], value[s], 0};
        ++leak->cells;
        if (std::abs(value[s]) > std::abs(leak->winding)) leak->at = samples[s], leak->winding = value[s];
    }
    return leak;
}

/// Marks the cells of interior runs: bits in bricks that hold surface, whole bricks between them.
template<class Interior>
void fill(Cells &cells, const Columns &columns, const Interior &interior)
{
    std::vector<std::vector<SolidRun>> solid(columns.bricks.size());
    tbb::parallel_for(std::size_t{0}, columns.bricks.size(), [&](std::size_t b) {
        const BrickColumn &at = columns.bricks[b];
        for (std::size_t c = 0; c < 64; ++c) {
            std::size_t brick = at.begin;
            for (std::uint32_t r = columns.start[64 * b + c]; r < columns.start[64 * b + c + 1]; ++r) {
                if (!interior(r)) continue;
                const Run &run = columns.runs[r];
                while (8 * cells.bricks[brick].at[2] + 7 < run.first) ++brick;
                for (std::size_t inner = brick; inner < at.end && 8 * cells.bricks[inner].at[2] <= run.last;
                     ++inner) {
                    const std::int32_t base = 8 * cells.bricks[inner].at[2];
                    const int first = std::max(run.first - base, 0), last = std::min(run.last - base, 7);
                    const std::uint64_t bits = (std::uint64_t{0xff} << first & 0xff) & (0xff >> (7 - last));
                    cells.bricks[inner].interior[c >> 3] |= bits << (8 * (c & 7));
                }
                // A brick without surface is of one state: its first column speaks for all 64.
                if (c != 0) continue;
                // The gap below `brick` is looked at too: a run may begin right at its lower end.
                for (std::size_t inner = brick > at.begin ? brick - 1 : brick;
                     inner + 1 < at.end && 8 * cells.bricks[inner].at[2] <= run.last; ++inner) {
                    const std::int32_t next = cells.bricks[inner].at[2] + 1,
                                       until = cells.bricks[inner + 1].at[2] - 1;
                    if (next <= until && run.first <= 8 * next && run.last >= 8 * until + 7)
                        solid[b].push_back({at.i, at.j, next, until});
                }
            }
        }
    });
    for (const auto &part : solid) cells.solid.insert(cells.solid.end(), part.begin(), part.end());
}

} // namespace

Classification classify(Cells &cells, const WindingNumber &winding, Progress &progress)
{
    progress.stage("classify", 4);
    Classification out;
    cells.solid.clear(); // whatever was decided before is decided anew
    for (Brick &brick : cells.bricks) brick.interior = {};
    const Columns columns = find_runs(cells);
    progress.advance(1);
    progress.check();

    std::vector<std::uint32_t> parent(columns.runs.size() + 1);
    std::iota(parent.begin(), parent.end(), 0u);
    const auto brick_column = [&](std::int32_t i, std::int32_t j) -> std::ptrdiff_t {
        const auto found = std::lower_bound(columns.bricks.begin(), columns.bricks.end(), std::pair{i, j},
                                            [](const BrickColumn &b, const auto &key) {
                                                return std::pair{b.i, b.j} < key;
                                            });
        return found != columns.bricks.end() && found->i == i && found->j == j
                   ? found - columns.bricks.begin()
                   : -1;
    };
    tbb::parallel_for(std::size_t{0}, columns.bricks.size(), [&](std::size_t b) {
        if ((b & 255) == 0) progress.check();
        const BrickColumn &at = columns.bricks[b];
        const std::ptrdiff_t right = brick_column(at.i + 1, at.j), up = brick_column(at.i, at.j + 1);
        const bool left = brick_column(at.i - 1, at.j) >= 0, down = brick_column(at.i, at.j - 1) >= 0;
        const auto open = [&](std::size_t column) { // a neighbour without any surface cell: outside
            for (std::uint32_t r = columns.start[column]; r < columns.start[column + 1]; ++r)
                unite(parent, r + 1, outside);
        };
        for (std::size_t ci = 0; ci < 8; ++ci)
            for (std::size_t cj = 0; cj < 8; ++cj) {
                const std::size_t here = 64 * b + 8 * ci + cj;
                if (ci < 7)
                    join_columns(columns, here, here + 8, parent);
                else if (right >= 0)
                    join_columns(columns, here, 64 * static_cast<std::size_t>(right) + cj, parent);
                else
                    open(here);
                if (cj < 7)
                    join_columns(columns, here, here + 1, parent);
                else if (up >= 0)
                    join_columns(columns, here, 64 * static_cast<std::size_t>(up) + 8 * ci, parent);
                else
                    open(here);
                if ((ci == 0 && !left) || (cj == 0 && !down)) open(here);
            }
    });
    tbb::parallel_for(std::size_t{0}, parent.size(), [&](std::size_t n) {
        const std::uint32_t top = root(parent, static_cast<std::uint32_t>(n));
        std::atomic_ref(parent[n]).store(top, std::memory_order_relaxed);
    });
    progress.advance(1);

    // A component is judged at the middle of its longest run: as far from the surface as is cheap to find.
    std::vector<std::uint32_t> longest(parent.size(), UINT32_MAX);
    std::vector<std::uint32_t> components;
    for (std::uint32_t r = 0; r < columns.runs.size(); ++r) {
        const std::uint32_t component = parent[r + 1];
        if (component == outside) continue;
        std::uint32_t &best = longest[component];
        if (best == UINT32_MAX) components.push_back(component);
        if (best == UINT32_MAX ||
            columns.runs[r].last - columns.runs[r].first > columns.runs[best].last - columns.runs[best].first)
            best = r;
    }
    std::vector<std::uint8_t> solid(parent.size(), 0);
    tbb::parallel_for(std::size_t{0}, components.size(), [&](std::size_t c) {
        if ((c & 1023) == 0) progress.check();
        const std::uint32_t run = longest[components[c]];
        const Run &r = columns.runs[run];
        solid[components[c]] = std::abs(winding.at(center(cells, columns, column_of(columns, run),
                                                          (std::int64_t{r.first} + r.last) / 2))) >= 0.5;
    });
    out.components = components.size();
    for (const std::uint32_t c : components) out.cavities += !solid[c];
    out.leak = find_leak(cells, columns, parent, winding);
    progress.advance(1);
    progress.check();

    fill(cells, columns, [&](std::uint32_t run) { return solid[parent[run + 1]] != 0; });
    recount(cells);
    progress.advance(1);
    return out;
}

Classification classify_closing(Cells &cells, const WindingNumber &winding, double gap, Progress &progress)
{
    const double wanted = std::ceil(gap / 2 / cells.voxel);
    if (!(gap > 0) || wanted > 32)
        throw Failure(ExitCode::usage, "", "a gap to close is between one and 64 voxels wide");

    // Thicken: the surface of `thick` is every cell within the radius; `cells` gets the same bricks.
    Cells thick = cells;
    for (int left = static_cast<int>(wanted); left > 0;) {
        const int step = std::min(left, 8);
        widen(thick, step, progress);
        const BrickNeighbours neighbours(thick, progress);
        std::vector<CellMask> masks(thick.bricks.size());
        for (std::size_t b = 0; b < masks.size(); ++b) masks[b] = thick.bricks[b].surface;
        for (int ring = 0; ring < step; ++ring) masks = dilate(masks, neighbours, progress);
        for (std::size_t b = 0; b < masks.size(); ++b) thick.bricks[b].surface = masks[b];
        left -= step;
    }
    const Classification out = classify(thick, winding, progress);

    std::vector<CellMask> covered(thick.bricks.size());
    std::size_t own = 0;
    const Cell shift{(cells.origin[0] - thick.origin[0]) / 8, (cells.origin[1] - thick.origin[1]) / 8,
                     (cells.origin[2] - thick.origin[2]) / 8};
    for (std::size_t b = 0; b < thick.bricks.size(); ++b) {
        Brick &brick = thick.bricks[b];
        covered[b] = brick.surface;
        brick.surface = {};
        if (own == cells.bricks.size()) continue;
        BrickAt at = cells.bricks[own].at;
        for (std::size_t a = 0; a < 3; ++a) at[a] += static_cast<std::int32_t>(shift[a]);
        if (at == brick.at) brick.surface = cells.bricks[own++].surface;
    }
    progress.stage("close gaps", thick.bricks.size());
    tbb::parallel_for(std::size_t{0}, thick.bricks.size(), [&](std::size_t b) {
        if ((b & 7) == 0) progress.check(); // 512 winding numbers each
        Brick &brick = thick.bricks[b];
        for (std::size_t i = 0; i < 8; ++i)
            for (std::uint64_t left = covered[b][i] & ~brick.surface[i]; left; left &= left - 1) {
                const int bit = std::countr_zero(left);
                const int local[3] = {static_cast<int>(i), bit >> 3, bit & 7};
                Point center;
                for (std::size_t a = 0; a < 3; ++a)
                    center[a] =
                        cells.voxel *
                        (static_cast<double>(thick.origin[a] + 8 * std::int64_t{brick.at[a]} + local[a]) +
                         0.5);
                if (std::abs(winding.at(center)) >= 0.5) brick.interior[i] |= std::uint64_t{1} << bit;
            }
        progress.advance(1);
    });
    std::vector<std::uint8_t> silent(thick.bricks.size());
    for (std::size_t b = 0; b < silent.size(); ++b) {
        std::uint64_t surface = 0, any = 0, all = ~std::uint64_t{0};
        for (std::size_t i = 0; i < 8; ++i)
            surface |= thick.bricks[b].surface[i], any |= thick.bricks[b].interior[i],
                all &= thick.bricks[b].interior[i];
        silent[b] = !surface && (any == 0 || all == ~std::uint64_t{0});
    }
    make_uniform(thick, silent);
    recount(thick);
    thick.closed = cells.closed;
    cells = std::move(thick);
    return out;
}

} // namespace voxshell
