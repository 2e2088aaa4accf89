// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/voxmap_file.hpp"

#include "cli/failure.hpp"
#include "container/asset_file.hpp"
#include "voxmap/clearance.hpp"
#include "voxmap/planes.hpp"

#include "voxshell/voxmap.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

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

bool has_channels(const Channels &channels)
{
    return !channels.layer.empty() || !channels.distance.empty();
}

/// The levels while they are built. Brick coordinates of `cells` count from Cells::origin, entries from the
/// file's box.
class Levels {
  public:
    Levels(const VoxmapFile &file, const vxs_voxmap_grid &grid)
        : cells_(file.cells), channels_(file.channels), grid_(grid), with_channels_(has_channels(channels_)),
          root(std::size_t{grid.root_dims[0]} * grid.root_dims[1] * grid.root_dims[2])
    {
        for (int a = 0; a < 3; ++a)
            shift_[a] = (cells_.origin[a] - grid.origin_cell[a]) / VXS_VOXMAP_BRICK_CELLS;
        place_chunks();
        place_bricks();
        fill_bricks();
    }

  private:
    const Cells &cells_;
    const Channels &channels_;
    const vxs_voxmap_grid &grid_;
    const bool with_channels_;
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

    /// The entry of a brick: uniform, or `unnumbered`. A brick that a channel speaks in is never uniform.
    std::uint32_t kind(const Brick &brick) const
    {
        if (with_channels_) return unnumbered;
        return all_free(brick) ? 0 : all_interior(brick) ? interior : unnumbered;
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
            if (kind(brick) == interior)
                ++solid_bricks[at];
            else if (kind(brick) == unnumbered)
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
            const std::size_t at = root_at(brick.at[0], brick.at[1], brick.at[2]);
            if (root[at] < VXS_VOXMAP_ENTRY_FIRST) continue;
            entry(at, slot(brick.at[0], brick.at[1], brick.at[2])) = kind(brick);
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
        layers.resize(channels_.layer.empty() ? 0 : count);
        distances.resize(channels_.distance.empty() ? 0 : count);
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
                    const std::size_t number = e - VXS_VOXMAP_ENTRY_FIRST;
                    if (!layers.empty()) layers[number] = channels_.layer[b];
                    if (!distances.empty()) distances[number] = channels_.distance[b];
                    std::uint64_t *words = &bricks[number * VXS_VOXMAP_BRICK_WORDS];
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
    std::vector<std::array<std::int8_t, 512>> layers;
    std::vector<std::array<std::int16_t, 512>> distances;
};

/// The levels as the runtime looks at them.
vxs_voxmap view_of(const Levels &levels, const vxs_voxmap_grid &grid)
{
    vxs_voxmap map{};
    for (std::size_t a = 0; a < 3; ++a) {
        map.root_dims[a] = grid.root_dims[a];
        map.cells[a] = grid.root_dims[a] * VXS_VOXMAP_CHUNK_CELLS;
    }
    map.root = levels.root.data();
    map.chunks = levels.chunks.data();
    map.bricks = levels.bricks.data();
    map.chunk_count = levels.chunks.size() / VXS_VOXMAP_CHUNK_ENTRIES;
    map.brick_count = levels.bricks.size() / VXS_VOXMAP_BRICK_WORDS;
    return map;
}

/// Tight box of the cells and, where a channel speaks in them, of the bricks, in chunks.
struct ChunkBox {
    std::array<std::int64_t, 3> first, last;
};

ChunkBox chunk_box(const VoxmapFile &file)
{
    ChunkBox box;
    const Cells &cells = file.cells;
    for (std::size_t a = 0; a < 3; ++a) {
        box.first[a] = cells.min[a] >> 6;
        box.last[a] = cells.max[a] >> 6;
    }
    if (!has_channels(file.channels)) return box;
    for (const Brick &brick : cells.bricks) {
        for (std::size_t a = 0; a < 3; ++a) {
            const std::int64_t chunk =
                (cells.origin[a] + std::int64_t{VXS_VOXMAP_BRICK_CELLS} * brick.at[a]) >> 6;
            box.first[a] = std::min(box.first[a], chunk);
            box.last[a] = std::max(box.last[a], chunk);
        }
    }
    return box;
}

vxs_voxmap_grid make_grid(const VoxmapFile &file)
{
    const Cells &cells = file.cells;
    const ChunkBox box = chunk_box(file);
    vxs_voxmap_grid grid{};
    grid.voxel = cells.voxel;
    std::uint64_t entries = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        grid.bbox_min[a] = cells.min[a];
        grid.bbox_max[a] = cells.max[a];
        if (box.last[a] - box.first[a] >= VXS_VOXMAP_MAX_CELLS / VXS_VOXMAP_CHUNK_CELLS ||
            box.first[a] < -(VXS_VOXMAP_MAX_INDEX >> 6) || box.last[a] >= VXS_VOXMAP_MAX_INDEX >> 6)
            throw Failure(ExitCode::requirement, "",
                          "more cells per axis than a voxmap holds (2^20): choose a larger --voxel");
        grid.origin_cell[a] = box.first[a] * VXS_VOXMAP_CHUNK_CELLS;
        grid.root_dims[a] = static_cast<std::uint32_t>(box.last[a] - box.first[a] + 1);
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
    if (!file.channels.layer.empty())
        grid.layer_count = static_cast<std::uint32_t>(file.channels.layer_count);
    if (!file.channels.distance.empty()) {
        grid.distance_step = file.channels.distance_step;
        // Rounding must not put the clamp value beyond the band, nor the band beyond the clamp value (M210,
        // M402).
        grid.distance_band =
            std::round(file.channels.distance_band / grid.distance_step) * grid.distance_step;
        grid.distance_error = file.channels.distance_error;
        if (file.channels.unsigned_distance) grid.flags |= VXS_VOXMAP_FLAG_UNSIGNED;
    }
    return grid;
}

/// A map's levels back to Cells, which takes bricks in lexicographic order over the whole box.
class CellsReader {
  public:
    explicit CellsReader(const vxs_voxmap &map) : map_(map)
    {
        Cells &cells = file.cells;
        cells.voxel = map.voxel;
        std::ranges::copy(map.origin_cell, cells.origin.begin());
        std::ranges::copy(map.bbox_min, cells.min.begin());
        std::ranges::copy(map.bbox_max, cells.max.begin());
        cells.surface_cells = map.surface_cells;
        cells.interior_cells = map.interior_cells;
        cells.closed = map.flags & VXS_VOXMAP_FLAG_CLOSED;
        cells.bricks.reserve(map.brick_count);
        file.channels.layer_count = static_cast<int>(map.layer_count);
        file.channels.distance_band = map.distance_band;
        file.channels.distance_step = map.distance_step;
        file.channels.distance_error = map.distance_error;
        file.channels.unsigned_distance = map.flags & VXS_VOXMAP_FLAG_UNSIGNED;
        for (std::uint32_t i = 0; i < 8 * map.root_dims[0]; ++i) {
            for (std::uint32_t j = 0; j < 8 * map.root_dims[1]; ++j) add_row(i, j);
        }
    }

    VoxmapFile file;

  private:
    const vxs_voxmap &map_;

    /// The bricks (i, j, all k): through chunk after chunk.
    void add_row(std::uint32_t i, std::uint32_t j)
    {
        const auto bi = static_cast<std::int32_t>(i), bj = static_cast<std::int32_t>(j);
        const std::uint32_t *dims = map_.root_dims;
        const std::uint32_t *root = map_.root + (std::size_t{i >> 3} * dims[1] + (j >> 3)) * dims[2];
        for (std::uint32_t chunk = 0; chunk < dims[2]; ++chunk) {
            const auto bk = static_cast<std::int32_t>(8 * chunk);
            if (root[chunk] == interior) add_solid(bi, bj, bk, 8);
            if (root[chunk] < VXS_VOXMAP_ENTRY_FIRST) continue;
            const std::uint32_t *entries =
                map_.chunks + std::size_t{root[chunk] - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_CHUNK_ENTRIES +
                ((i & 7) << 6 | (j & 7) << 3);
            for (int k = 0; k < 8; ++k) {
                if (entries[k] == interior) add_solid(bi, bj, bk + k, 1);
                if (entries[k] >= VXS_VOXMAP_ENTRY_FIRST)
                    add_brick(entries[k] - VXS_VOXMAP_ENTRY_FIRST, {bi, bj, bk + k});
            }
        }
    }

    /// n solid bricks from (i, j, k) on: to the run before where it goes on.
    void add_solid(std::int32_t i, std::int32_t j, std::int32_t k, std::int32_t n)
    {
        auto &solid = file.cells.solid;
        if (!solid.empty() && solid.back().i == i && solid.back().j == j && solid.back().last == k - 1)
            solid.back().last += n;
        else
            solid.push_back({i, j, k, k + n - 1});
    }

    void add_brick(std::size_t number, const BrickAt &at)
    {
        const std::uint64_t *words = map_.bricks + number * VXS_VOXMAP_BRICK_WORDS;
        Brick brick;
        brick.at = at;
        for (std::size_t row = 0; row < 8; ++row) {
            const std::uint64_t low = words[2 * row], high = words[2 * row + 1];
            brick.surface[row] = gather(low) | gather(high) << 32;
            brick.interior[row] = gather(low >> 1) | gather(high >> 1) << 32;
        }
        file.cells.bricks.push_back(brick);
        if (map_.layers)
            std::copy_n(map_.layers + 512 * number, 512, file.channels.layer.emplace_back().begin());
        if (map_.distances)
            std::copy_n(map_.distances + 512 * number, 512, file.channels.distance.emplace_back().begin());
    }
};

void check_writable(const VoxmapFile &file)
{
    const Cells &cells = file.cells;
    if (cells.surface_cells == 0)
        throw Failure(ExitCode::requirement, "", "no surface cell: a voxmap without surface is not written");
    if (!(cells.voxel >= VXS_VOXEL_MIN && cells.voxel <= VXS_VOXEL_MAX))
        throw Failure(
            ExitCode::requirement, "",
            fmt::format("a voxel of {} m is outside {} .. {} m", cells.voxel, VXS_VOXEL_MIN, VXS_VOXEL_MAX));
    const Channels &channels = file.channels;
    if ((!channels.layer.empty() && channels.layer.size() != cells.bricks.size()) ||
        (!channels.distance.empty() && channels.distance.size() != cells.bricks.size()))
        throw Failure(ExitCode::bug, "", "a channel has not one element per brick");
}

} // namespace

std::vector<std::uint8_t> voxmap_bytes(VoxmapFile file, Progress *progress)
{
    check_writable(file);
    const vxs_voxmap_grid grid = make_grid(file);
    std::vector<Section> sections;
    {
        Levels levels(file, grid);
        file.cells = {};
        file.channels = {};
        const auto add = [&](std::uint32_t id, std::uint32_t stride, const auto &elements) {
            if (!elements.empty()) sections.push_back(make_section(id, stride, std::span(elements)));
        };
        add(VXS_VOXMAP_SECTION_GRID, sizeof grid, std::span(&grid, 1));
        add(VXS_VOXMAP_SECTION_ROOT, 4, levels.root);
        add(VXS_VOXMAP_SECTION_CHNK, 4 * VXS_VOXMAP_CHUNK_ENTRIES, levels.chunks);
        add(VXS_VOXMAP_SECTION_BRIK, 8 * VXS_VOXMAP_BRICK_WORDS, levels.bricks);
        add(VXS_VOXMAP_SECTION_LAYR, 512, levels.layers);
        levels.layers = {};
        add(VXS_VOXMAP_SECTION_DIST, 2 * 512, levels.distances);
        levels.distances = {};
        if (file.clearance) {
            const Clearance found = clearance(view_of(levels, grid), progress);
            add(VXS_VOXMAP_SECTION_CLRX, 4, found.index);
            add(VXS_VOXMAP_SECTION_CLRV, VXS_VOXMAP_CLEARANCE_BLOCKS, found.values);
            add(VXS_VOXMAP_SECTION_CLRC, 4, found.chunks);
            add(VXS_VOXMAP_SECTION_CLRP, sizeof(ChunkPlanes), planes(view_of(levels, grid), progress));
        }
        add(VXS_SECTION_META, 1, file.meta);
    }
    return container_bytes(VXS_VOXMAP_MAGIC, VXS_VOXMAP_VERSION_MAJOR, VXS_VOXMAP_VERSION_MINOR,
                           file.source_hash, std::move(sections), progress);
}

VoxmapFile read_voxmap(const std::filesystem::path &path)
{
    const AssetFile file(path, VXS_ASSET_VOXMAP);
    vxs_voxmap map;
    if (vxs_voxmap_open(&file.asset(), &map) != VXS_OK)
        throw Failure(ExitCode::bug, path.string(), "a checked voxmap has no view");
    VoxmapFile out = std::move(CellsReader(map).file);
    out.source_hash = file.source_hash();
    out.meta = file.meta();
    out.clearance = map.clearance != nullptr;
    return out;
}

} // namespace voxshell
