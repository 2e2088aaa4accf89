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

namespace voxshell {
namespace {

constexpr int near_cells = 16;       ///< a cell nearer than this is found itself, farther ones by their block
constexpr int blocks = 16;           ///< per axis of a chunk
constexpr int far_blocks = 16;       ///< beyond this many blocks a clearance is VXS_VOXMAP_CLEARANCE_BEYOND
constexpr std::int16_t none = 16384; ///< squared distance where nothing was found

__extension__ typedef unsigned __int128 Row; // cells -16 .. 79 of a chunk along k, from bit 0 on

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

    /// Row (i, j) of 64 cells of a chunk, a bit each; of the others than bricks first .. last bits are 0 or
    /// right.
    std::uint64_t row(std::uint32_t entry, int i, int j, int first = 0, int last = 7) const
    {
        if (entry < VXS_VOXMAP_ENTRY_FIRST) return entry == open ? 0 : ~std::uint64_t{0};
        const std::uint32_t *entries =
            map.chunks + std::size_t{entry - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_CHUNK_ENTRIES +
            ((i >> 3) << 6 | (j >> 3) << 3);
        std::uint64_t out = 0;
        for (int b = first; b <= last; ++b)
            out |= std::uint64_t{brick_row(entries[b], i & 7, j & 7)} << (8 * b);
        return out;
    }

    std::uint8_t brick_row(std::uint32_t entry, int i, int j) const
    {
        if (entry < VXS_VOXMAP_ENTRY_FIRST) return entry == open ? 0 : 0xff;
        const std::uint64_t word =
            map.bricks[std::size_t{entry - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_BRICK_WORDS +
                       static_cast<std::size_t>(2 * i + (j >> 2))];
        const auto states = static_cast<std::uint32_t>(word >> (16 * (j & 3))) & 0xffff; // two bits a cell
        std::uint32_t bits = open == VXS_CELL_FREE ? states | states >> 1 : ~(states >> 1);
        bits &= 0x5555;
        bits = (bits | bits >> 1) & 0x3333;
        bits = (bits | bits >> 2) & 0x0f0f;
        return static_cast<std::uint8_t>(bits | bits >> 4);
    }
};

using BlockRows =
    std::array<std::uint16_t, blocks * blocks>; ///< of a chunk: bit kb of row (ib, jb): holds an obstacle

BlockRows block_rows(const Obstacles &o, std::uint32_t entry)
{
    BlockRows out{};
    for (int i = 0; i < 64; ++i)
        for (int j = 0; j < 64; ++j) {
            std::uint64_t row = o.row(entry, i, j);
            row |= row >> 1;
            row = (row | row >> 2) & 0x1111111111111111;
            for (std::uint16_t &target = out[static_cast<std::size_t>(blocks * (i / 4) + j / 4)]; row;
                 row &= row - 1)
                target = static_cast<std::uint16_t>(target | 1u << (std::countr_zero(row) / 4));
        }
    return out;
}

/// Squared distances from the centres of a chunk's 16 x 16 x 16 blocks to obstacles in a window of rows x
/// rows x rows things (cells, or blocks), axis by axis: along k when it is filled, then along j, then along
/// i. A block looks at `reach` rows, from row first + step * block on; gap(n) is how far the n-th of these is
/// from its centre.
template<int rows, int first, int step, int reach>
struct Field {
    std::int16_t along_k[rows][rows][blocks];
    std::int16_t along_j[rows][blocks][blocks];
    std::int16_t squared[blocks][blocks][blocks]; ///< the result
    bool any[rows];                               ///< whether slab i holds an obstacle

    template<typename Gap>
    void spread(Gap gap)
    {
        for (int i = 0; i < rows; ++i) {
            std::fill_n(&along_j[i][0][0], blocks * blocks, none);
            for (int jb = 0; any[i] && jb < blocks; ++jb)
                for (int n = 0; n < reach; ++n)
                    take<blocks>(along_j[i][jb], along_k[i][first + step * jb + n], gap(n));
        }
        for (int ib = 0; ib < blocks; ++ib) {
            std::fill_n(&squared[ib][0][0], blocks * blocks, none);
            for (int n = 0; n < reach; ++n) {
                const int i = first + step * ib + n;
                if (any[i]) take<blocks * blocks>(&squared[ib][0][0], &along_j[i][0][0], gap(n));
            }
        }
    }

  private:
    template<int count>
    static void take(std::int16_t *best, const std::int16_t *from, int gap)
    {
        const auto square = static_cast<std::int16_t>(gap * gap);
        for (int n = 0; n < count; ++n)
            best[n] = std::min(best[n], static_cast<std::int16_t>(from[n] + square));
    }
};

/// Cells within 16 cells. Row 0 is cell -16 of the chunk; of the 32 rows a block looks at, 16 lie on each
/// side.
struct NearField : Field<64 + 2 * near_cells, 2, 4, 2 * near_cells> {
    void fill(const Obstacles &o, const std::array<std::int64_t, 3> &at)
    {
        for (int i = 0; i < 96; ++i) {
            any[i] = false;
            for (int j = 0; j < 96; ++j) {
                const Row row = row_at(o, at, i - near_cells, j - near_cells);
                std::fill_n(along_k[i][j], blocks, none);
                for (int kb = 0; row && kb < blocks; ++kb) {
                    const auto window = static_cast<std::uint32_t>(row >> (4 * kb + 2));
                    const int gap = std::min(std::countr_zero(window >> near_cells | 1u << near_cells),
                                             std::countl_zero(window << near_cells | 1u << (near_cells - 1)));
                    if (gap < near_cells) along_k[i][j][kb] = static_cast<std::int16_t>(gap * gap);
                }
                any[i] = any[i] || row;
            }
        }
        spread([](int n) { return n < near_cells ? near_cells - 1 - n : n - near_cells; });
    }

  private:
    static Row row_at(const Obstacles &o, const std::array<std::int64_t, 3> &at, int i, int j)
    {
        const auto row = [&](int dk, int first, int last) {
            return o.row(o.chunk(at[0] + (i >> 6), at[1] + (j >> 6), at[2] + dk), i & 63, j & 63, first,
                         last);
        };
        return Row{row(-1, 6, 7) >> 48} | Row{row(0, 0, 7)} << 16 | Row{row(1, 0, 1)} << 80;
    }
};

/// Blocks within 16 blocks. Row 0 is block -16 of the chunk; the block itself is the middle one of 33.
struct FarField : Field<3 * blocks, 0, 1, 2 * far_blocks + 1> {
    /// rows_of(chunk): its BlockRows.
    template<typename RowsOf>
    void fill(const std::array<std::int64_t, 3> &at, RowsOf rows_of)
    {
        const auto gap = [](int n) { return std::max(0, 4 * std::abs(n - far_blocks) - 2); };
        for (int i = 0; i < 3 * blocks; ++i) {
            any[i] = false;
            for (int j = 0; j < 3 * blocks; ++j) {
                std::uint64_t row = 0;
                for (int dk = 0; dk < 3; ++dk) {
                    const std::int64_t chunk[3] = {at[0] + i / blocks - 1, at[1] + j / blocks - 1,
                                                   at[2] + dk - 1};
                    row |= std::uint64_t{rows_of(
                               chunk)[static_cast<std::size_t>(blocks * (i % blocks) + j % blocks)]}
                           << (blocks * dk);
                }
                std::fill_n(along_k[i][j], blocks, none);
                for (int kb = 0; row && kb < blocks; ++kb) {
                    const std::uint64_t after = row >> (kb + far_blocks),
                                        before = row << (63 - kb - far_blocks);
                    const int away = std::min(after ? std::countr_zero(after) : 64,
                                              before ? std::countl_zero(before) : 64);
                    if (away > far_blocks) continue;
                    const int d = gap(far_blocks + away);
                    along_k[i][j][kb] = static_cast<std::int16_t>(d * d);
                }
                any[i] = any[i] || row;
            }
        }
        spread(gap);
    }
};

/// The square root is correctly rounded, so the floor is that of the true root.
std::int8_t half_cells(int squared)
{
    return static_cast<std::int8_t>(
        std::min<int>(VXS_VOXMAP_CLEARANCE_BEYOND, static_cast<int>(std::sqrt(4.0 * squared))));
}

struct Fields {
    NearField near;
    FarField far;
};

/// One kind of obstacle over the whole map.
class Side {
  public:
    Side(const vxs_voxmap &map, std::uint32_t open) : obstacles_{map, open}, rows_(map.chunk_count)
    {
        full_.fill(0xffff);
        tbb::parallel_for(std::size_t{0}, rows_.size(), [&](std::size_t chunk) {
            rows_[chunk] = block_rows(obstacles_, VXS_VOXMAP_ENTRY_FIRST + static_cast<std::uint32_t>(chunk));
        });
    }

    void find(const std::array<std::int64_t, 3> &at, Fields &fields, std::int8_t *values) const
    {
        if (is_full(at)) {
            std::fill_n(values, VXS_VOXMAP_CLEARANCE_BLOCKS, std::int8_t{0});
            return;
        }
        fields.near.fill(obstacles_, at);
        fields.far.fill(at, [&](const std::int64_t chunk[3]) -> const BlockRows & {
            const std::uint32_t entry = obstacles_.chunk(chunk[0], chunk[1], chunk[2]);
            if (entry >= VXS_VOXMAP_ENTRY_FIRST) return rows_[entry - VXS_VOXMAP_ENTRY_FIRST];
            return entry == obstacles_.open ? empty_ : full_;
        });
        const std::int16_t *near = &fields.near.squared[0][0][0], *far = &fields.far.squared[0][0][0];
        constexpr int near_squared = near_cells * near_cells;
        for (std::size_t b = 0; b < VXS_VOXMAP_CLEARANCE_BLOCKS; ++b)
            values[b] = half_cells(near[b] < near_squared ? near[b] : std::max<int>(near_squared, far[b]));
    }

  private:
    /// Whether every cell of the chunk is an obstacle: then no clearance on this side is more than 0.
    bool is_full(const std::array<std::int64_t, 3> &at) const
    {
        const std::uint32_t entry = obstacles_.chunk(at[0], at[1], at[2]);
        if (entry < VXS_VOXMAP_ENTRY_FIRST) return entry != obstacles_.open;
        for (int i = 0; i < 64; ++i)
            for (int j = 0; j < 64; ++j)
                if (obstacles_.row(entry, i, j) != ~std::uint64_t{0}) return false;
        return true;
    }

    Obstacles obstacles_;
    std::vector<BlockRows> rows_;
    BlockRows empty_{}, full_;
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

} // namespace

Clearance clearance(const vxs_voxmap &map)
{
    const Side free(map, VXS_CELL_FREE), interior(map, VXS_CELL_INTERIOR);
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
        if (out.index[n] == VXS_VOXMAP_ENTRY_FIRST) near.push_back(n);
    }
    out.values.resize(near.size());
    tbb::enumerable_thread_specific<std::unique_ptr<Fields>> fields(
        [] { return std::make_unique<Fields>(); });
    tbb::parallel_for(std::size_t{0}, near.size(), [&](std::size_t n) {
        Clearance::Values &values = out.values[n], inside;
        free.find(place(near[n]), *fields.local(), values.data());
        interior.find(place(near[n]), *fields.local(), inside.data());
        for (std::size_t b = 0; b < values.size(); ++b)
            if (inside[b]) values[b] = static_cast<std::int8_t>(-inside[b]);
    });
    // A chunk that is beyond throughout needs no values.
    std::size_t kept = 0;
    for (std::size_t n = 0; n < near.size(); ++n) {
        const auto all = [&](int v) {
            return std::ranges::all_of(out.values[n], [v](std::int8_t own) { return own == v; });
        };
        if (all(VXS_VOXMAP_CLEARANCE_BEYOND)) {
            out.index[near[n]] = VXS_CELL_FREE;
        } else if (all(-VXS_VOXMAP_CLEARANCE_BEYOND)) {
            out.index[near[n]] = VXS_CELL_INTERIOR;
        } else {
            if (kept != n) out.values[kept] = out.values[n];
            out.index[near[n]] = static_cast<std::uint32_t>(VXS_VOXMAP_ENTRY_FIRST + kept++);
        }
    }
    out.values.resize(kept);
    return out;
}

} // namespace voxshell
