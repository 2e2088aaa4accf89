// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/vdb_cells.hpp"
#include "voxmap/vdb_parse.hpp"

#include <algorithm>
#include <fmt/core.h>

namespace voxshell {
namespace {

bool before(const Brick &a, const Brick &b)
{
    return a.at < b.at;
}

} // namespace

void BrickBox::grow(const Cell &low, const Cell &high)
{
    for (std::size_t a = 0; a < 3; ++a) {
        min[a] = std::min(min[a], low[a]);
        max[a] = std::max(max[a], high[a]);
    }
}

Cell BrickBox::origin() const
{
    Cell cell;
    for (std::size_t a = 0; a < 3; ++a) cell[a] = (min[a] >> 3) * VXS_VOXMAP_CHUNK_CELLS;
    return cell;
}

void check_box(const BrickBox &box, const std::string &grid, ExitCode code)
{
    std::uint64_t root = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        if (8 * box.min[a] < -vdb_max_index || 8 * box.max[a] + 7 > vdb_max_index)
            throw Failure(code, "",
                          fmt::format("grid `{}` reaches from cell {} to {} on axis {}: limit {}", grid,
                                      8 * box.min[a], 8 * box.max[a] + 7, a, vdb_max_index));
        const std::int64_t chunks = (box.max[a] >> 3) - (box.min[a] >> 3) + 1;
        if (chunks > VXS_VOXMAP_MAX_CELLS / VXS_VOXMAP_CHUNK_CELLS)
            throw Failure(code, "",
                          fmt::format("the box of grid `{}` is {} cells long on axis {}: limit {}", grid,
                                      chunks * VXS_VOXMAP_CHUNK_CELLS, a, int{VXS_VOXMAP_MAX_CELLS}));
        root *= static_cast<std::uint64_t>(chunks);
    }
    if (root > VXS_VOXMAP_MAX_ROOT)
        throw Failure(code, "",
                      fmt::format("the box of grid `{}` has {} chunks of 64^3 cells: limit {}", grid, root,
                                  int{VXS_VOXMAP_MAX_ROOT}));
}

void join(std::vector<SolidRun> &runs)
{
    std::sort(runs.begin(), runs.end(), [](const SolidRun &a, const SolidRun &b) {
        return BrickAt{a.i, a.j, a.first} < BrickAt{b.i, b.j, b.first};
    });
    std::size_t kept = 0;
    for (const SolidRun &run : runs) {
        if (kept && runs[kept - 1].i == run.i && runs[kept - 1].j == run.j &&
            runs[kept - 1].last + 1 == run.first)
            runs[kept - 1].last = run.last;
        else
            runs[kept++] = run;
    }
    runs.resize(kept);
}

void make_unique(std::vector<BrickAt> &bricks)
{
    std::sort(bricks.begin(), bricks.end());
    bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
    bricks.shrink_to_fit(); // up to 27 times as many went in
}

std::vector<bool> take_out(std::vector<SolidRun> &runs, const std::vector<BrickAt> &taken)
{
    std::vector<bool> had(taken.size());
    std::vector<SolidRun> left;
    std::size_t next = 0;
    for (SolidRun run : runs) {
        while (next < taken.size() && taken[next] < BrickAt{run.i, run.j, run.first}) ++next;
        for (; next < taken.size() && taken[next] <= BrickAt{run.i, run.j, run.last}; ++next) {
            had[next] = true;
            if (run.first < taken[next][2]) left.push_back({run.i, run.j, run.first, taken[next][2] - 1});
            run.first = taken[next][2] + 1;
        }
        if (run.first <= run.last) left.push_back(run);
    }
    runs = std::move(left);
    return had;
}

void add_spoken(const std::vector<BrickAt> &spoken, Cells &cells)
{
    std::vector<BrickAt> extra;
    for (const BrickAt &at : spoken)
        if (!std::binary_search(cells.bricks.begin(), cells.bricks.end(), Brick{at, {}, {}}, before))
            extra.push_back(at);
    const std::vector<bool> was_solid = take_out(cells.solid, extra);
    for (std::size_t b = 0; b < extra.size(); ++b)
        cells.bricks.push_back({extra[b], no_cells, was_solid[b] ? all_cells : no_cells});
    std::sort(cells.bricks.begin(), cells.bricks.end(), before);
}

} // namespace voxshell
