// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/voxmap_file.hpp"

#include "cli/failure.hpp"
#include "container/asset_file.hpp"

#include "voxshell/voxmap.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>

namespace voxshell {
namespace {

constexpr std::uint64_t all_cells = ~std::uint64_t{0};
constexpr std::uint32_t interior = VXS_CELL_INTERIOR;
constexpr std::uint32_t unnumbered = VXS_VOXMAP_ENTRY_FIRST; ///< marks what gets a number in a second pass

/// Bit n of the low half to bit 2n.
constexpr std::uint64_t spread(std::uint64_t bits)
{
    bits &= 0xffffffff;
    bits = (bits | bits << 16) & 0x0000ffff0000ffff;
    bits = (bits | bits << 8) & 0x00ff00ff00ff00ff;
    bits = (bits | bits << 4) & 0x0f0f0f0f0f0f0f0f;
    bits = (bits | bits << 2) & 0x3333333333333333;
    return (bits | bits << 1) & 0x5555555555555555;
}

/// Bit 2n to bit n: undoes spread().
constexpr std::uint64_t gather(std::uint64_t bits)
{
    bits &= 0x5555555555555555;
    bits = (bits | bits >> 1) & 0x3333333333333333;
    bits = (bits | bits >> 2) & 0x0f0f0f0f0f0f0f0f;
    bits = (bits | bits >> 4) & 0x00ff00ff00ff00ff;
    bits = (bits | bits >> 8) & 0x0000ffff0000ffff;
    return (bits | bits >> 16) & 0xffffffff;
}

bool all_interior(const Brick &brick)
{
    return std::ranges::all_of(brick.interior, [](std::uint64_t row) { return row == all_cells; });
}

bool all_free(const Brick &brick)
{
    std::uint64_t any = 0;
    for (int i = 0; i < 8; ++i) any |= brick.surface[i] | brick.interior[i];
    return any == 0;
}

/// The three levels while they are built. Brick coordinates count from the file's box, not from
/// Cells::origin.
class Levels {
  public:
    Levels(const Cells &cells, const vxs_voxmap_grid &grid)
        : cells_(cells), grid_(grid),
          root(std::size_t{grid.root_dims[0]} * grid.root_dims[1] * grid.root_dims[2])
    {
        for (int a = 0; a < 3; ++a)
            shift_[a] = (cells.origin[a] - grid.origin_cell[a]) / VXS_VOXMAP_BRICK_CELLS;
        place_chunks();
        place_bricks();
        fill_bricks();
    }

  private:
    const Cells &cells_;
    const vxs_voxmap_grid &grid_;
    std::array<std::int64_t, 3> shift_;

    std::size_t root_at(std::int64_t i, std::int64_t j, std::int64_t k) const
    {
        const std::int64_t at[3] = {i + shift_[0], j + shift_[1], k + shift_[2]};
        for (int a = 0; a < 3; ++a) {
            if (at[a] < 0 || at[a] >= std::int64_t{VXS_VOXMAP_CHUNK_BRICKS} * grid_.root_dims[a])
                throw Failure(ExitCode::bug, "", "cells lie outside their own box: recount() was left out");
        }
        return (static_cast<std::size_t>(at[0] >> 3) * grid_.root_dims[1] +
                static_cast<std::size_t>(at[1] >> 3)) *
                   grid_.root_dims[2] +
               static_cast<std::size_t>(at[2] >> 3);
    }

    std::uint32_t slot(std::int64_t i, std::int64_t j, std::int64_t k) const
    {
        return static_cast<std::uint32_t>(((i + shift_[0]) & 7) << 6 | ((j + shift_[1]) & 7) << 3 |
                                          ((k + shift_[2]) & 7));
    }

    /// The pieces of all solid runs within one chunk each: f(root index, i, j, first, last).
    template<typename F>
    void each_solid_piece(F f) const
    {
        for (const SolidRun &run : cells_.solid) {
            for (std::int64_t k = run.first; k <= run.last;) {
                const std::int64_t last = std::min<std::int64_t>(run.last, ((k + shift_[2]) | 7) - shift_[2]);
                f(root_at(run.i, run.j, k), run.i, run.j, k, last);
                k = last + 1;
            }
        }
    }

    std::uint32_t &entry(std::size_t root_index, std::uint32_t slot_index)
    {
        return chunks[std::size_t{root[root_index] - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_CHUNK_ENTRIES +
                      slot_index];
    }

    /// ROOT: a chunk that is neither all free nor all interior gets the next number, in root order.
    void place_chunks()
    {
        std::vector<std::uint16_t> solid_bricks(root.size());
        for (const Brick &brick : cells_.bricks) {
            const std::size_t at = root_at(brick.at[0], brick.at[1], brick.at[2]);
            if (all_interior(brick))
                ++solid_bricks[at];
            else if (!all_free(brick))
                root[at] = unnumbered;
        }
        each_solid_piece(
            [&](std::size_t at, std::int64_t, std::int64_t, std::int64_t first, std::int64_t last) {
                solid_bricks[at] = static_cast<std::uint16_t>(solid_bricks[at] + (last - first + 1));
            });
        std::uint32_t count = 0;
        for (std::size_t at = 0; at < root.size(); ++at) {
            if (solid_bricks[at] == VXS_VOXMAP_CHUNK_ENTRIES)
                root[at] = interior;
            else if (solid_bricks[at] || root[at])
                root[at] = VXS_VOXMAP_ENTRY_FIRST + count++;
        }
        chunks.resize(std::size_t{count} * VXS_VOXMAP_CHUNK_ENTRIES);
    }

    /// CHNK: the same one level down.
    void place_bricks()
    {
        for (const Brick &brick : cells_.bricks) {
            if (all_free(brick)) continue;
            const std::size_t at = root_at(brick.at[0], brick.at[1], brick.at[2]);
            if (root[at] < VXS_VOXMAP_ENTRY_FIRST) continue;
            entry(at, slot(brick.at[0], brick.at[1], brick.at[2])) =
                all_interior(brick) ? interior : unnumbered;
        }
        each_solid_piece(
            [&](std::size_t at, std::int64_t i, std::int64_t j, std::int64_t first, std::int64_t last) {
                if (root[at] < VXS_VOXMAP_ENTRY_FIRST) return;
                for (std::int64_t k = first; k <= last; ++k) entry(at, slot(i, j, k)) = interior;
            });
        std::uint64_t count = 0;
        for (std::uint32_t &e : chunks) {
            if (e == unnumbered) e = static_cast<std::uint32_t>(VXS_VOXMAP_ENTRY_FIRST + count++);
        }
        if (count > VXS_VOXMAP_MAX_BRICKS)
            throw Failure(ExitCode::requirement, "",
                          fmt::format("{} bricks of 8x8x8 cells, a voxmap holds {}: choose a larger --voxel",
                                      count, static_cast<int>(VXS_VOXMAP_MAX_BRICKS)));
        bricks.resize(count * VXS_VOXMAP_BRICK_WORDS);
    }

    void fill_bricks()
    {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(0, cells_.bricks.size(), 1024), [&](const auto &range) {
                for (std::size_t b = range.begin(); b < range.end(); ++b) {
                    const Brick &brick = cells_.bricks[b];
                    const std::size_t at = root_at(brick.at[0], brick.at[1], brick.at[2]);
                    if (root[at] < VXS_VOXMAP_ENTRY_FIRST) continue;
                    const std::uint32_t e = entry(at, slot(brick.at[0], brick.at[1], brick.at[2]));
                    if (e < VXS_VOXMAP_ENTRY_FIRST) continue;
                    std::uint64_t *words =
                        &bricks[std::size_t{e - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_BRICK_WORDS];
                    for (int i = 0; i < 8; ++i) {
                        words[2 * i] = spread(brick.surface[i]) | spread(brick.interior[i]) << 1;
                        words[2 * i + 1] = spread(brick.surface[i] >> 32) | spread(brick.interior[i] >> 32)
                                                                                << 1;
                    }
                }
            });
    }

  public:
    std::vector<std::uint32_t> root, chunks;
    std::vector<std::uint64_t> bricks;
};

/// The smallest box of whole chunks around the cells.
vxs_voxmap_grid make_grid(const Cells &cells)
{
    vxs_voxmap_grid grid{};
    grid.voxel = cells.voxel;
    std::uint64_t entries = 1;
    for (int a = 0; a < 3; ++a) {
        grid.bbox_min[a] = cells.min[a];
        grid.bbox_max[a] = cells.max[a];
        const std::int64_t first = cells.min[a] >> 6, last = cells.max[a] >> 6;
        if (last - first >= VXS_VOXMAP_MAX_CELLS / VXS_VOXMAP_CHUNK_CELLS ||
            first < -(VXS_VOXMAP_MAX_INDEX >> 6) || last >= VXS_VOXMAP_MAX_INDEX >> 6)
            throw Failure(ExitCode::requirement, "",
                          "more cells per axis than a voxmap holds (2^20): choose a larger --voxel");
        grid.origin_cell[a] = first * VXS_VOXMAP_CHUNK_CELLS;
        grid.root_dims[a] = static_cast<std::uint32_t>(last - first + 1);
        entries *= grid.root_dims[a];
    }
    if (entries > VXS_VOXMAP_MAX_ROOT)
        throw Failure(
            ExitCode::requirement, "",
            fmt::format("the box has {} chunks of 64x64x64 cells, a voxmap holds {}: choose a larger --voxel",
                        entries, static_cast<int>(VXS_VOXMAP_MAX_ROOT)));
    grid.surface_cells = cells.surface_cells;
    grid.interior_cells = cells.interior_cells;
    if (cells.closed) grid.flags |= VXS_VOXMAP_FLAG_CLOSED;
    return grid;
}

/// Appends n solid bricks from (i, j, k) on, to the run before where it goes on.
void add_solid(std::vector<SolidRun> &solid, std::int32_t i, std::int32_t j, std::int32_t k, std::int32_t n)
{
    if (!solid.empty() && solid.back().i == i && solid.back().j == j && solid.back().last == k - 1)
        solid.back().last += n;
    else
        solid.push_back({i, j, k, k + n - 1});
}

Cells cells_of(const vxs_voxmap &map)
{
    Cells cells;
    cells.voxel = map.voxel;
    std::ranges::copy(map.origin_cell, cells.origin.begin());
    std::ranges::copy(map.bbox_min, cells.min.begin());
    std::ranges::copy(map.bbox_max, cells.max.begin());
    cells.surface_cells = map.surface_cells;
    cells.interior_cells = map.interior_cells;
    cells.closed = map.flags & VXS_VOXMAP_FLAG_CLOSED;
    cells.bricks.reserve(map.brick_count);

    const auto add = [&](std::uint32_t entry, std::int32_t i, std::int32_t j, std::int32_t k) {
        if (entry == interior) add_solid(cells.solid, i, j, k, 1);
        if (entry < VXS_VOXMAP_ENTRY_FIRST) return;
        const std::uint64_t *words =
            map.bricks + std::size_t{entry - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_BRICK_WORDS;
        Brick brick;
        brick.at = {i, j, k};
        for (int row = 0; row < 8; ++row) {
            const std::uint64_t low = words[2 * row], high = words[2 * row + 1];
            brick.surface[row] = gather(low) | gather(high) << 32;
            brick.interior[row] = gather(low >> 1) | gather(high >> 1) << 32;
        }
        if (all_interior(brick))
            add_solid(cells.solid, i, j, k, 1); // a channel's brick
        else if (!all_free(brick))
            cells.bricks.push_back(brick);
    };

    // Brick order is lexicographic over the whole box: rows of bricks run through chunk after chunk.
    const auto *dims = map.root_dims;
    for (std::uint32_t i = 0; i < 8 * dims[0]; ++i) {
        for (std::uint32_t j = 0; j < 8 * dims[1]; ++j) {
            const std::uint32_t *row = map.root + (std::size_t{i >> 3} * dims[1] + (j >> 3)) * dims[2];
            for (std::uint32_t chunk = 0; chunk < dims[2]; ++chunk) {
                const auto bi = static_cast<std::int32_t>(i), bj = static_cast<std::int32_t>(j),
                           bk = static_cast<std::int32_t>(8 * chunk);
                if (row[chunk] == interior) add_solid(cells.solid, bi, bj, bk, 8);
                if (row[chunk] < VXS_VOXMAP_ENTRY_FIRST) continue;
                const std::uint32_t *entries =
                    map.chunks + std::size_t{row[chunk] - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_CHUNK_ENTRIES +
                    ((i & 7) << 6 | (j & 7) << 3);
                for (int k = 0; k < 8; ++k) add(entries[k], bi, bj, bk + k);
            }
        }
    }
    return cells;
}

} // namespace

std::vector<std::uint8_t> voxmap_bytes(const VoxmapFile &file)
{
    const Cells &cells = file.cells;
    if (cells.surface_cells == 0)
        throw Failure(ExitCode::requirement, "", "no surface cell: a voxmap without surface is not written");
    if (!(cells.voxel >= VXS_VOXEL_MIN && cells.voxel <= VXS_VOXEL_MAX))
        throw Failure(
            ExitCode::requirement, "",
            fmt::format("a voxel of {} m is outside {} .. {} m", cells.voxel, VXS_VOXEL_MIN, VXS_VOXEL_MAX));
    const vxs_voxmap_grid grid = make_grid(cells);
    std::vector<Section> sections;
    {
        const Levels levels(cells, grid);
        sections.push_back(make_section(VXS_VOXMAP_SECTION_GRID, sizeof grid, std::span(&grid, 1)));
        sections.push_back(make_section(VXS_VOXMAP_SECTION_ROOT, 4, std::span(levels.root)));
        sections.push_back(
            make_section(VXS_VOXMAP_SECTION_CHNK, 4 * VXS_VOXMAP_CHUNK_ENTRIES, std::span(levels.chunks)));
        sections.push_back(
            make_section(VXS_VOXMAP_SECTION_BRIK, 8 * VXS_VOXMAP_BRICK_WORDS, std::span(levels.bricks)));
    }
    sections.push_back(make_section(VXS_SECTION_META, 1, std::span(file.meta)));
    return container_bytes(VXS_VOXMAP_MAGIC, VXS_VOXMAP_VERSION_MAJOR, VXS_VOXMAP_VERSION_MINOR,
                           file.source_hash, sections);
}

VoxmapFile read_voxmap(const std::filesystem::path &path)
{
    const AssetFile file(path, VXS_ASSET_VOXMAP);
    vxs_voxmap map;
    if (vxs_voxmap_open(&file.asset(), &map) != VXS_OK)
        throw Failure(ExitCode::bug, path.string(), "a checked voxmap has no view");
    return {cells_of(map), file.source_hash(), file.meta()};
}

} // namespace voxshell
