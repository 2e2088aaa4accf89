// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/cells.hpp"

#include <algorithm>
#include <bit>

namespace voxshell {

int cell_state(const Cells &cells, const Cell &at)
{
    BrickAt brick;
    std::uint32_t local[3];
    for (int a = 0; a < 3; ++a) {
        const std::int64_t c = at[a] - cells.origin[a];
        if (c < 0 || (c >> 3) > INT32_MAX) return VXS_CELL_FREE;
        brick[a] = static_cast<std::int32_t>(c >> 3);
        local[a] = static_cast<std::uint32_t>(c & 7);
    }
    const auto found = std::lower_bound(cells.bricks.begin(), cells.bricks.end(), brick,
                                        [](const Brick &b, const BrickAt &key) { return b.at < key; });
    if (found != cells.bricks.end() && found->at == brick) {
        const std::uint32_t bit = 8 * local[1] + local[2];
        if (found->surface[local[0]] >> bit & 1) return VXS_CELL_SURFACE;
        if (found->interior[local[0]] >> bit & 1) return VXS_CELL_INTERIOR;
        return VXS_CELL_FREE;
    }
    // The last run that does not begin after the brick is the only one that can hold it.
    const auto after = std::upper_bound(cells.solid.begin(), cells.solid.end(), brick,
                                        [](const BrickAt &key, const SolidRun &r) {
                                            return key < BrickAt{r.i, r.j, r.first};
                                        });
    if (after == cells.solid.begin()) return VXS_CELL_FREE;
    const SolidRun &run = *(after - 1);
    return run.i == brick[0] && run.j == brick[1] && brick[2] <= run.last ? VXS_CELL_INTERIOR : VXS_CELL_FREE;
}

void recount(Cells &cells)
{
    cells.surface_cells = cells.interior_cells = 0;
    Cell low{INT64_MAX, INT64_MAX, INT64_MAX}, high{INT64_MIN, INT64_MIN, INT64_MIN};
    const auto grow = [&](int axis, std::int64_t first, std::int64_t last) {
        low[axis] = std::min(low[axis], first);
        high[axis] = std::max(high[axis], last);
    };
    for (const Brick &b : cells.bricks) {
        std::uint64_t columns = 0; // bit 8 j + k: some i holds a cell there
        for (int i = 0; i < 8; ++i) {
            cells.surface_cells += static_cast<std::uint64_t>(std::popcount(b.surface[i]));
            cells.interior_cells += static_cast<std::uint64_t>(std::popcount(b.interior[i]));
            const std::uint64_t any = b.surface[i] | b.interior[i];
            if (any)
                grow(0, cells.origin[0] + 8 * std::int64_t{b.at[0]} + i,
                     cells.origin[0] + 8 * std::int64_t{b.at[0]} + i);
            columns |= any;
        }
        if (!columns) continue;
        grow(1, cells.origin[1] + 8 * std::int64_t{b.at[1]} + std::countr_zero(columns) / 8,
             cells.origin[1] + 8 * std::int64_t{b.at[1]} + 7 - std::countl_zero(columns) / 8);
        std::uint64_t row = columns | columns >> 32;
        row |= row >> 16;
        row = (row | row >> 8) & 0xff;
        grow(2, cells.origin[2] + 8 * std::int64_t{b.at[2]} + std::countr_zero(row),
             cells.origin[2] + 8 * std::int64_t{b.at[2]} + 63 - std::countl_zero(row));
    }
    for (const SolidRun &r : cells.solid) {
        cells.interior_cells += 512 * static_cast<std::uint64_t>(r.last - r.first + 1);
        grow(0, cells.origin[0] + 8 * std::int64_t{r.i}, cells.origin[0] + 8 * std::int64_t{r.i} + 7);
        grow(1, cells.origin[1] + 8 * std::int64_t{r.j}, cells.origin[1] + 8 * std::int64_t{r.j} + 7);
        grow(2, cells.origin[2] + 8 * std::int64_t{r.first}, cells.origin[2] + 8 * std::int64_t{r.last} + 7);
    }
    cells.min = low;
    cells.max = high;
}

} // namespace voxshell
