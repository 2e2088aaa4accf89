// SPDX-License-Identifier: GPL-3.0-or-later
//
// Exact squared distances in integers, axis by axis (Saito and Toriwaki 1994): a block's centre is a corner
// of cells, so it is a whole number of cells away from any cell along each axis.
#include "voxmap/clearance.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <utility>

namespace voxshell {
namespace {

constexpr int near_cells = 16; ///< a cell nearer than this is found itself, farther ones by their block
constexpr int blocks = 16;     ///< per axis of a chunk
constexpr int far_blocks = 16; ///< beyond this many blocks a clearance is VXS_VOXMAP_CLEARANCE_BEYOND

__extension__ typedef unsigned __int128 Row; // cells -16 .. 79, or blocks -16 .. 31, of a chunk along k

/// Where one kind of obstacle is: cells that are not free, seen from free ones, or not interior.
struct Obstacles {
    const vxs_voxmap &map;
    const std::uint32_t open; ///< the state that is none: VXS_CELL_FREE or _INTERIOR

    /// Entry of the chunk; outside the box all is free.
    std::uint32_t chunk(std::int64_t i, std::int64_t j, std::int64_t k) const
    {
        const std::int64_t at[3] = {i, j, k};
        for (int a = 0; a < 3; ++a)
            if (at[a] < 0 || at[a] >= map.root_dims[a]) return VXS_CELL_FREE;
        return map.root[(static_cast<std::size_t>(i) * map.root_dims[1] + static_cast<std::size_t>(j)) *
                            map.root_dims[2] +
                        static_cast<std::size_t>(k)];
    }

    /// Entry of a brick of a chunk, by the chunk's own entry.
    std::uint32_t brick(std::uint32_t chunk_entry, std::size_t slot) const
    {
        if (chunk_entry < VXS_VOXMAP_ENTRY_FIRST) return chunk_entry;
        return map
            .chunks[std::size_t{chunk_entry - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_CHUNK_ENTRIES + slot];
    }

    /// Four rows of eight cells of a brick, by its entry: row r in bits 16 r to 16 r + 7. Word w holds rows 4
    /// (w & 1) on of slab w >> 1.
    std::uint64_t rows(std::uint32_t brick_entry, std::size_t word) const
    {
        if (brick_entry < VXS_VOXMAP_ENTRY_FIRST) return brick_entry == open ? 0 : 0x00ff00ff00ff00ff;
        const std::uint64_t states =
            map.bricks[std::size_t{brick_entry - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_BRICK_WORDS + word];
        std::uint64_t bits =
            (open == VXS_CELL_FREE ? states | states >> 1 : ~(states >> 1)) & 0x5555555555555555;
        bits = (bits | bits >> 1) & 0x3333333333333333;
        bits = (bits | bits >> 2) & 0x0f0f0f0f0f0f0f0f;
        return (bits | bits >> 4) & 0x00ff00ff00ff00ff;
    }
};

/// Of a chunk: bit kb of row (ib, jb): holds an obstacle.
struct BlockRows {
    std::array<std::uint16_t, blocks * blocks> row{};
    bool full = true; ///< all its cells are obstacles
};

BlockRows block_rows(const Obstacles &o, std::uint32_t entry)
{
    BlockRows out;
    for (std::size_t slot = 0; slot < VXS_VOXMAP_CHUNK_ENTRIES; ++slot) {
        const std::uint32_t brick = o.brick(entry, slot);
        const auto bi = slot >> 6, bj = slot >> 3 & 7, bk = slot & 7;
        for (std::size_t block = 0; block < 4; ++block) { // two by two, each along k a pair
            std::uint64_t any = 0, all = ~std::uint64_t{0};
            for (std::size_t i = 0; i < 4; ++i) {
                const std::uint64_t rows = o.rows(brick, 2 * (4 * (block >> 1) + i) + (block & 1));
                any |= rows, all &= rows;
            }
            any |= any >> 32, any |= any >> 16;
            const unsigned pair = (any & 0x0f ? 1u : 0u) | (any & 0xf0 ? 2u : 0u);
            auto &row = out.row[blocks * (2 * bi + (block >> 1)) + 2 * bj + (block & 1)];
            row = static_cast<std::uint16_t>(row | pair << (2 * bk));
            out.full = out.full && all == 0x00ff00ff00ff00ff;
        }
    }
    return out;
}

/// f(first, end) for the runs of ones.
template<typename F>
void each_run(Row row, F f)
{
    const auto zeros = [](Row bits) {
        const auto low = static_cast<std::uint64_t>(bits);
        return low ? std::countr_zero(low) : 64 + std::countr_zero(static_cast<std::uint64_t>(bits >> 64));
    };
    while (row) {
        const Row filled = row | (row - 1);
        f(zeros(row), zeros(~filled));
        row &= filled + 1;
    }
}

/// Squared distances from the centres of a chunk's 16 x 16 x 16 blocks to obstacles in a window of rows x
/// rows x rows things (cells, or blocks), axis by axis: along k, which the caller does, then along j, then
/// along i. A block looks at `pairs` pairs of rows: down from row low + step * block, up from row high + step
/// * block; gap(n) is how far the n-th pair is from its centre. Nothing was found: `none`, which no distance
/// is.
template<typename Squared, Squared none, int rows, int step, int low, int high, int pairs>
class Field {
  public:
    static constexpr int area = blocks * blocks;
    std::array<Squared, blocks * area> squared; ///< the result

  protected:
    using Line = std::array<Squared, blocks>;

    /// Slab i from its rows along k.
    template<typename Gap>
    void spread_along_j(int i, const std::array<Line, rows> &along_k, Gap gap)
    {
        Squared *best = slab(i);
        std::fill_n(best, area, none);
        for (int jb = 0; jb < blocks; ++jb, best += blocks)
            for (int n = 0; n < pairs; ++n)
                take<blocks>(best, along_k[static_cast<std::size_t>(low + step * jb - n)].data(),
                             along_k[static_cast<std::size_t>(high + step * jb + n)].data(), gap(n));
    }

    /// Slab i as the one before.
    void repeat(int i) { std::copy_n(slab(i - 1), area, slab(i)); }

    template<typename Gap>
    void spread_along_i(Gap gap)
    {
        squared.fill(none);
        for (int ib = 0; ib < blocks; ++ib)
            for (int n = 0; n < pairs; ++n)
                take<area>(&squared[static_cast<std::size_t>(ib * area)], slab(low + step * ib - n),
                           slab(high + step * ib + n), gap(n));
    }

  private:
    template<int count>
    static void take(Squared *best, const Squared *down, const Squared *up, int gap)
    {
        const auto square = static_cast<Squared>(gap * gap), most = static_cast<Squared>(none - square);
        for (int n = 0; n < count; ++n) {
            const Squared nearer = std::min(std::min(down[n], up[n]), most);
            best[n] = std::min(best[n], static_cast<Squared>(nearer + square));
        }
    }

    Squared *slab(int i) { return &along_j_[static_cast<std::size_t>(i * area)]; }

    std::array<Squared, rows * area> along_j_;
};

/// Cells within 16 cells; row 0 is cell -16 of the chunk. 255 is no sum of three squares.
class NearField : public Field<std::uint8_t, 255, 64 + 2 * near_cells, 4, 17, 18, near_cells> {
  public:
    static constexpr std::uint8_t none = 255;

    /// around: the entries of the chunk and its 26 neighbours.
    void fill(const Obstacles &o, const std::array<std::uint32_t, 27> &around)
    {
        const auto gap = [](int n) { return n; };
        for (int bi = 0; bi < bricks; ++bi) {
            for (int bj = 0; bj < bricks; ++bj) read(o, around, bi, bj);
            for (int i = 0; i < 8; ++i) {
                const Slab &rows = i ? slabs_[static_cast<std::size_t>(i - 1)] : last_;
                if ((bi || i) && rows == slabs_[static_cast<std::size_t>(i)]) {
                    repeat(8 * bi + i);
                    continue;
                }
                along_k(slabs_[static_cast<std::size_t>(i)]);
                spread_along_j(8 * bi + i, along_k_, gap);
            }
            last_ = slabs_[7];
        }
        spread_along_i(gap);
    }

  private:
    static constexpr int bricks = 12;
    using Slab =
        std::array<std::array<std::uint64_t, 2>, 8 * bricks>; ///< the rows of one i, each a Row in halves

    /// Column (bi, bj) of bricks along k into slabs_.
    void read(const Obstacles &o, const std::array<std::uint32_t, 27> &around, int bi, int bj)
    {
        std::array<std::pair<std::uint32_t, int>, bricks> mixed;
        std::size_t count = 0;
        std::array<std::uint64_t, 2> uniform{};
        for (int bk = 0; bk < bricks; ++bk) {
            const auto chunk = static_cast<std::size_t>((bi + 6) >> 3) * 9 +
                               static_cast<std::size_t>((bj + 6) >> 3) * 3 +
                               static_cast<std::size_t>((bk + 6) >> 3);
            const auto slot =
                static_cast<std::size_t>(((bi + 6) & 7) << 6 | ((bj + 6) & 7) << 3 | ((bk + 6) & 7));
            const std::uint32_t entry = o.brick(around[chunk], slot);
            if (entry >= VXS_VOXMAP_ENTRY_FIRST)
                mixed[count++] = {entry, bk};
            else if (entry != o.open)
                uniform[static_cast<std::size_t>(bk >> 3)] |= std::uint64_t{0xff} << 8 * (bk & 7);
        }
        for (std::size_t i = 0; i < 8; ++i) {
            auto *row = &slabs_[i][static_cast<std::size_t>(8 * bj)];
            std::fill_n(row, 8, uniform);
            for (std::size_t m = 0; m < count; ++m)
                for (std::size_t half = 0; half < 2; ++half) {
                    std::uint64_t rows = o.rows(mixed[m].first, 2 * i + half);
                    for (std::size_t r = 0; r < 4; ++r, rows >>= 16)
                        row[4 * half + r][static_cast<std::size_t>(mixed[m].second >> 3)] |=
                            (rows & 0xff) << 8 * (mixed[m].second & 7);
                }
        }
    }

    void along_k(const Slab &rows)
    {
        for (std::size_t j = 0; j < rows.size(); ++j) {
            if (j && rows[j] == rows[j - 1]) {
                along_k_[j] = along_k_[j - 1];
                continue;
            }
            Line gap;
            gap.fill(none);
            each_run(Row{rows[j][1]} << 64 | rows[j][0], [&](int first, int end) {
                const auto a = static_cast<std::uint8_t>(first), b = static_cast<std::uint8_t>(end);
                for (std::size_t kb = 0; kb < blocks; ++kb) {
                    const auto centre = static_cast<std::uint8_t>(near_cells + 2 + 4 * kb);
                    const auto before = static_cast<std::uint8_t>(std::max(a, centre) - centre);
                    const auto behind = static_cast<std::uint8_t>(std::max(b, centre) - b);
                    gap[kb] = std::min(gap[kb], static_cast<std::uint8_t>(before | behind));
                }
            });
            for (std::size_t kb = 0; kb < blocks; ++kb)
                along_k_[j][kb] = gap[kb] < near_cells ? static_cast<std::uint8_t>(gap[kb] * gap[kb]) : none;
        }
    }

    std::array<Slab, 8> slabs_;
    Slab last_;
    std::array<Line, 8 * bricks> along_k_;
};

/// Blocks within 16 blocks; row 0 is block -16 of the chunk.
class FarField : public Field<std::int16_t, 16384, 3 * blocks, 1, far_blocks, far_blocks, far_blocks + 1> {
  public:
    static constexpr std::int16_t none = 16384;

    /// around: of the chunk and its 26 neighbours.
    void fill(const std::array<const BlockRows *, 27> &around)
    {
        const auto gap = [](int n) { return std::max(0, 4 * n - 2); };
        for (std::size_t i = 0; i < 3 * blocks; ++i) {
            Slab &rows = slabs_[i & 1];
            for (std::size_t j = 0; j < rows.size(); ++j) {
                const auto *chunk = &around[i / blocks * 9 + j / blocks * 3];
                rows[j] = 0;
                for (std::size_t dk = 0; dk < 3; ++dk)
                    rows[j] |= std::uint64_t{chunk[dk]->row[blocks * (i % blocks) + j % blocks]}
                               << (blocks * dk);
            }
            if (i && rows == slabs_[1 - (i & 1)]) {
                repeat(static_cast<int>(i));
                continue;
            }
            along_k(rows, gap);
            spread_along_j(static_cast<int>(i), along_k_, gap);
        }
        spread_along_i(gap);
    }

  private:
    using Slab = std::array<std::uint64_t, 3 * blocks>;

    template<typename Gap>
    void along_k(const Slab &rows, Gap gap)
    {
        for (std::size_t j = 0; j < rows.size(); ++j) {
            if (j && rows[j] == rows[j - 1]) {
                along_k_[j] = along_k_[j - 1];
                continue;
            }
            std::array<int, blocks> away;
            away.fill(far_blocks + 1);
            each_run(rows[j], [&](int first, int end) {
                for (int kb = 0; kb < blocks; ++kb) {
                    int &least = away[static_cast<std::size_t>(kb)];
                    least = std::min(least,
                                     std::max({first - (far_blocks + kb), far_blocks + kb - (end - 1), 0}));
                }
            });
            for (std::size_t kb = 0; kb < blocks; ++kb)
                along_k_[j][kb] =
                    away[kb] <= far_blocks ? static_cast<std::int16_t>(gap(away[kb]) * gap(away[kb])) : none;
        }
    }

    std::array<Slab, 2> slabs_;
    std::array<Line, 3 * blocks> along_k_;
};

/// In half cells, rounded down: the square root is correctly rounded, so the floor is that of the true root.
class HalfCells {
  public:
    HalfCells()
    {
        for (std::size_t n = 0; n < value_.size(); ++n)
            value_[n] = static_cast<std::int8_t>(std::min<int>(
                VXS_VOXMAP_CLEARANCE_BEYOND, static_cast<int>(std::sqrt(4.0 * static_cast<double>(n)))));
    }
    std::int8_t operator()(int squared) const
    {
        return value_[std::min(static_cast<std::size_t>(squared), value_.size() - 1)];
    }

  private:
    std::array<std::int8_t, 64 * 64> value_; ///< beyond the last, all are VXS_VOXMAP_CLEARANCE_BEYOND
};

struct Fields {
    NearField near;
    FarField far;
};

/// One kind of obstacle over the whole map.
class Side {
  public:
    Side(const vxs_voxmap &map, std::uint32_t open, Progress &progress)
        : obstacles_{map, open}, rows_(map.chunk_count)
    {
        full_.row.fill(0xffff);
        empty_.full = false;
        tbb::parallel_for(std::size_t{0}, rows_.size(), [&](std::size_t chunk) {
            progress.check();
            rows_[chunk] = block_rows(obstacles_, VXS_VOXMAP_ENTRY_FIRST + static_cast<std::uint32_t>(chunk));
        });
    }

    void find(const std::array<std::int64_t, 3> &at, Fields &fields, std::int8_t *values) const
    {
        std::array<std::uint32_t, 27> entries;
        std::array<const BlockRows *, 27> rows;
        for (std::size_t n = 0; n < entries.size(); ++n) {
            const auto d = static_cast<std::int64_t>(n);
            entries[n] = obstacles_.chunk(at[0] + d / 9 - 1, at[1] + d / 3 % 3 - 1, at[2] + d % 3 - 1);
            rows[n] = entries[n] >= VXS_VOXMAP_ENTRY_FIRST ? &rows_[entries[n] - VXS_VOXMAP_ENTRY_FIRST]
                      : entries[n] == obstacles_.open      ? &empty_
                                                           : &full_;
        }
        if (rows[13]->full) { // no clearance on this side is more than 0
            std::fill_n(values, VXS_VOXMAP_CLEARANCE_BLOCKS, std::int8_t{0});
            return;
        }
        fields.near.fill(obstacles_, entries);
        const auto &near = fields.near.squared;
        const bool decided = std::ranges::find(near, NearField::none) == near.end();
        if (!decided) fields.far.fill(rows);
        constexpr int near_squared = near_cells * near_cells;
        for (std::size_t b = 0; b < VXS_VOXMAP_CLEARANCE_BLOCKS; ++b)
            values[b] = half_cells_(
                near[b] != NearField::none ? near[b] : std::max<int>(near_squared, fields.far.squared[b]));
    }

  private:
    Obstacles obstacles_;
    std::vector<BlockRows> rows_;
    BlockRows empty_, full_;
    HalfCells half_cells_;
};

/// The state of the chunk and all around it if that is one, else VXS_VOXMAP_ENTRY_FIRST.
std::uint32_t state_around(const Obstacles &o, const std::array<std::int64_t, 3> &at)
{
    const std::uint32_t own = o.chunk(at[0], at[1], at[2]);
    for (int n = 0; n < 27; ++n)
        if (own >= VXS_VOXMAP_ENTRY_FIRST ||
            o.chunk(at[0] + n / 9 - 1, at[1] + n / 3 % 3 - 1, at[2] + n % 3 - 1) != own)
            return VXS_VOXMAP_ENTRY_FIRST;
    return own;
}

/// Squared distances [cells] from the centres of chunks to the nearest one (a closed box) whose root entry is
/// not `open`, axis by axis; no more than just beyond VXS_VOXMAP_CLEARANCE_MOST.
std::vector<std::int32_t> squared_from_others(const vxs_voxmap &map, std::uint32_t open)
{
    constexpr std::int32_t beyond = VXS_VOXMAP_CLEARANCE_MOST * VXS_VOXMAP_CLEARANCE_MOST + 1;
    const std::int32_t outside = open == VXS_CELL_FREE ? beyond : 0;
    const std::array<std::size_t, 3> dims{map.root_dims[0], map.root_dims[1], map.root_dims[2]},
        stride{dims[1] * dims[2], dims[2], 1};
    std::vector<std::int32_t> squared(dims[0] * stride[0]);
    for (std::size_t n = 0; n < squared.size(); ++n) squared[n] = map.root[n] == open ? beyond : 0;
    for (const std::size_t axis : {2u, 1u, 0u}) {
        const std::size_t count = dims[axis], step = stride[axis];
        tbb::parallel_for(std::size_t{0}, squared.size() / count, [&](std::size_t line) {
            std::int32_t *const at = squared.data() + line / step * step * count + line % step;
            std::vector<std::int32_t> before(count);
            for (std::size_t n = 0; n < count; ++n) before[n] = at[n * step];
            for (std::size_t n = 0; n < count; ++n)
                for (std::size_t away = 1;; ++away) {
                    const auto gap = static_cast<std::int32_t>(64 * away - 32);
                    if (gap * gap >= at[n * step]) break;
                    const std::int32_t low = away <= n ? before[n - away] : outside,
                                       high = n + away < count ? before[n + away] : outside;
                    at[n * step] = std::min(at[n * step], std::min(low, high) + gap * gap);
                }
        });
    }
    return squared;
}

/// CLRC for these entries of CLRX.
std::vector<std::int32_t> chunk_clearances(const vxs_voxmap &map, const std::vector<std::uint32_t> &index)
{
    std::vector<std::int32_t> out(index.size());
    for (const std::uint32_t open : {VXS_CELL_FREE, VXS_CELL_INTERIOR}) {
        if (std::ranges::find(index, open) == index.end()) continue;
        const std::vector<std::int32_t> squared = squared_from_others(map, open);
        for (std::size_t n = 0; n < out.size(); ++n) {
            if (index[n] != open) continue;
            // The square root is correctly rounded, so the floor is that of the true root.
            const auto cells = static_cast<std::int32_t>(std::sqrt(static_cast<double>(squared[n])));
            out[n] = open == VXS_CELL_FREE ? cells : -cells;
        }
    }
    return out;
}

} // namespace

Clearance clearance(const vxs_voxmap &map, Progress *watched)
{
    Progress silent, &progress = watched ? *watched : silent;
    const Side free(map, VXS_CELL_FREE, progress), interior(map, VXS_CELL_INTERIOR, progress);
    const Obstacles chunks{map, VXS_CELL_FREE};
    Clearance out;
    out.index.resize(std::size_t{map.root_dims[0]} * map.root_dims[1] * map.root_dims[2]);
    const auto place = [&](std::size_t n) {
        return std::array<std::int64_t, 3>{static_cast<std::int64_t>(n / map.root_dims[2] / map.root_dims[1]),
                                           static_cast<std::int64_t>(n / map.root_dims[2] % map.root_dims[1]),
                                           static_cast<std::int64_t>(n % map.root_dims[2])};
    };
    std::vector<std::size_t> near;
    for (std::size_t n = 0; n < out.index.size(); ++n) {
        out.index[n] = state_around(chunks, place(n));
        if (out.index[n] != VXS_VOXMAP_ENTRY_FIRST) continue;
        out.index[n] += static_cast<std::uint32_t>(near.size());
        near.push_back(n);
    }
    out.values.resize(near.size());
    tbb::enumerable_thread_specific<std::unique_ptr<Fields>> fields(
        [] { return std::make_unique<Fields>(); });
    tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t n) {
        progress.check();
        Clearance::Values &values = out.values[n], inside;
        free.find(place(near[n]), *fields.local(), values.data());
        interior.find(place(near[n]), *fields.local(), inside.data());
        for (std::size_t b = 0; b < values.size(); ++b)
            if (inside[b]) values[b] = static_cast<std::int8_t>(-inside[b]);
    });
    out.chunks = chunk_clearances(map, out.index);
    return out;
}

} // namespace voxshell
