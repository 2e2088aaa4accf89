// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/planes.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <memory>

namespace voxshell {
namespace {

constexpr int reach = VXS_VOXMAP_PLANE_REACH, across = 2 * reach; // cells of a brick's window along an axis
constexpr vxs_voxmap_plane says_nothing{{0, 0, 0}, -1}, all_is_free{{0, 0, 0}, 0};

/// Which cells of a window are meant: bit k + reach of row [i + reach][j + reach] for the cell (i, j, k) from
/// the brick's centre on.
struct Ball {
    std::array<std::array<std::uint16_t, across>, across>
        touched{},  ///< boxes that come nearer than the reach
        centered{}; ///< cells whose centres do

    constexpr Ball()
    {
        const auto gap = [](int at) { return at > 0 ? at : at < -1 ? -1 - at : 0; };
        for (int i = -reach; i < reach; ++i)
            for (int j = -reach; j < reach; ++j)
                for (int k = -reach; k < reach; ++k) {
                    const auto bit = static_cast<std::uint16_t>(1 << (k + reach));
                    const auto a = static_cast<std::size_t>(i + reach),
                               b = static_cast<std::size_t>(j + reach);
                    if (gap(i) * gap(i) + gap(j) * gap(j) + gap(k) * gap(k) < reach * reach)
                        touched[a][b] |= bit;
                    const int x = 2 * i + 1, y = 2 * j + 1, z = 2 * k + 1;
                    if (x * x + y * y + z * z < 4 * reach * reach) centered[a][b] |= bit;
                }
    }
};

constexpr Ball ball;

/// Of eight bits how many are set, and the sum of their places.
struct Byte {
    std::array<std::uint8_t, 256> count{}, places{};

    constexpr Byte()
    {
        for (unsigned bits = 0; bits < 256; ++bits)
            for (unsigned place = 0; place < 8; ++place)
                if (bits >> place & 1)
                    ++count[bits], places[bits] = static_cast<std::uint8_t>(places[bits] + place);
    }
};

constexpr Byte byte;

/// The cells of a chunk, and of a brick's width around it, that are not free.
class Surroundings {
  public:
    void fill(const vxs_voxmap &map, const std::array<std::int64_t, 3> &chunk)
    {
        for (auto &slab : row_) slab.fill({});
        for (int i = -1; i <= 8; ++i)
            for (int j = -1; j <= 8; ++j)
                for (int k = -1; k <= 8; ++k) {
                    const std::uint32_t brick = brick_at(map, chunk, {i, j, k});
                    is_free(i, j, k) = brick == VXS_CELL_FREE;
                    if (brick != VXS_CELL_FREE) read(map, brick, i, j, k);
                }
    }

    vxs_voxmap_plane plane(int bi, int bj, int bk) const
    {
        bool free = true;
        for (int n = 0; n < 27; ++n)
            free = free && is_free(bi + n / 9 - 1, bj + n / 3 % 3 - 1, bk + n % 3 - 1);
        if (free) return all_is_free;
        const Rows rows = window(bi, bj, bk);
        std::array<int, 3> sum{};
        bool any = false;
        for (std::size_t i = 0; i < across; ++i)
            for (std::size_t j = 0; j < across; ++j) {
                any = any || (rows[i][j] & ball.touched[i][j]);
                const unsigned bits = rows[i][j] & ball.centered[i][j], low = bits & 255, high = bits >> 8;
                const int count = byte.count[low] + byte.count[high],
                          places = byte.places[low] + byte.places[high] + 8 * byte.count[high];
                sum[0] += (2 * static_cast<int>(i) - across + 1) * count;
                sum[1] += (2 * static_cast<int>(j) - across + 1) * count;
                sum[2] += 2 * places - (across - 1) * count;
            }
        if (!any) return all_is_free;
        const int most = std::max({std::abs(sum[0]), std::abs(sum[1]), std::abs(sum[2])});
        if (most == 0) return says_nothing;
        std::array<int, 3> n;
        for (std::size_t a = 0; a < 3; ++a) n[a] = sum[a] * VXS_VOXMAP_PLANE_NORMAL / most;
        const int offset = floor_divided(nearest(rows, n), VXS_VOXMAP_PLANE_STEP);
        if (offset < -128) return says_nothing;
        return {
            {static_cast<std::int8_t>(n[0]), static_cast<std::int8_t>(n[1]), static_cast<std::int8_t>(n[2])},
            static_cast<std::int8_t>(offset)};
    }

  private:
    using Rows = std::array<std::array<std::uint16_t, across>, across>;
    static constexpr std::size_t width = 80; ///< cells: eight before the chunk, and eight after it

    /// The entry of a brick from the chunk's first on; outside the box all is free.
    static std::uint32_t brick_at(const vxs_voxmap &map, const std::array<std::int64_t, 3> &chunk,
                                  const std::array<int, 3> &brick)
    {
        std::array<std::uint32_t, 3> cell;
        for (std::size_t a = 0; a < 3; ++a) {
            const std::int64_t at = 64 * chunk[a] + 8 * brick[a];
            if (at < 0 || at >= map.cells[a]) return VXS_CELL_FREE;
            cell[a] = static_cast<std::uint32_t>(at);
        }
        return vxs_voxmap_entry(&map, cell[0], cell[1], cell[2]);
    }

    void read(const vxs_voxmap &map, std::uint32_t brick, int bi, int bj, int bk)
    {
        const auto i = static_cast<std::size_t>(8 * bi + 8), j = static_cast<std::size_t>(8 * bj + 8),
                   k = static_cast<std::size_t>(bk + 1);
        for (std::uint32_t row = 0; row < 64; ++row) {
            unsigned cells = 255;
            if (brick >= VXS_VOXMAP_ENTRY_FIRST) {
                const std::uint64_t *words =
                    map.bricks + std::size_t{brick - VXS_VOXMAP_ENTRY_FIRST} * VXS_VOXMAP_BRICK_WORDS;
                cells = squeezed(static_cast<unsigned>(words[row >> 2] >> (16 * (row & 3))));
            }
            row_[i + (row >> 3)][j + (row & 7)][k] = static_cast<std::uint8_t>(cells);
        }
    }

    /// One bit for each of eight states: not free.
    static unsigned squeezed(unsigned states)
    {
        unsigned bits = (states | states >> 1) & 0x5555;
        bits = (bits | bits >> 1) & 0x3333;
        bits = (bits | bits >> 2) & 0x0f0f;
        return (bits | bits >> 4) & 0x00ff;
    }

    Rows window(int bi, int bj, int bk) const
    {
        Rows out;
        const auto i0 = static_cast<std::size_t>(8 * bi + 12 - reach),
                   j0 = static_cast<std::size_t>(8 * bj + 12 - reach), k0 = static_cast<std::size_t>(bk);
        for (std::size_t i = 0; i < across; ++i)
            for (std::size_t j = 0; j < across; ++j) {
                const auto &row = row_[i0 + i][j0 + j];
                out[i][j] = static_cast<std::uint16_t>((row[k0] | row[k0 + 1] << 8 | row[k0 + 2] << 16) >>
                                                       (12 - reach));
            }
        return out;
    }

    /// The least n . x of the cells that come nearer than the reach.
    static int nearest(const Rows &rows, const std::array<int, 3> &n)
    {
        const auto least = [](int component, int at) {
            return std::min(component * at, component * (at + 1));
        };
        int out = INT32_MAX;
        for (std::size_t i = 0; i < across; ++i)
            for (std::size_t j = 0; j < across; ++j) {
                const unsigned bits = rows[i][j] & ball.touched[i][j];
                if (!bits) continue;
                const int k = n[2] > 0 ? std::countr_zero(bits) : 31 - std::countl_zero(bits);
                out = std::min(out, least(n[0], static_cast<int>(i) - reach) +
                                        least(n[1], static_cast<int>(j) - reach) + least(n[2], k - reach));
            }
        return out;
    }

    static int floor_divided(int value, int by) { return value >= 0 ? value / by : -((by - 1 - value) / by); }

    bool &is_free(int i, int j, int k)
    {
        return is_free_[static_cast<std::size_t>((i + 1) * 100 + (j + 1) * 10 + k + 1)];
    }
    bool is_free(int i, int j, int k) const
    {
        return is_free_[static_cast<std::size_t>((i + 1) * 100 + (j + 1) * 10 + k + 1)];
    }

    std::array<std::array<std::array<std::uint8_t, 10>, width>, width> row_;
    std::array<bool, 1000> is_free_;
};

static_assert(across == 16, "a row of the window has 16 bits");

} // namespace

std::vector<ChunkPlanes> planes(const vxs_voxmap &map, Progress *watched)
{
    Progress silent, &progress = watched ? *watched : silent;
    std::vector<std::array<std::int64_t, 3>> chunks;
    for (std::int64_t i = 0, n = 0; i < map.root_dims[0]; ++i)
        for (std::int64_t j = 0; j < map.root_dims[1]; ++j)
            for (std::int64_t k = 0; k < map.root_dims[2]; ++k, ++n)
                if (map.root[n] >= VXS_VOXMAP_ENTRY_FIRST)
                    chunks.push_back({i, j, k}); // in the order of CHNK
    std::vector<ChunkPlanes> out(chunks.size());
    tbb::enumerable_thread_specific<std::unique_ptr<Surroundings>> around(
        [] { return std::make_unique<Surroundings>(); });
    tbb::parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t n) {
        progress.check();
        Surroundings &own = *around.local();
        own.fill(map, chunks[n]);
        const std::uint32_t *entries = map.chunks + n * VXS_VOXMAP_CHUNK_ENTRIES;
        for (std::size_t slot = 0; slot < VXS_VOXMAP_CHUNK_ENTRIES; ++slot)
            out[n][slot] = entries[slot] == VXS_CELL_INTERIOR
                               ? says_nothing
                               : own.plane(static_cast<int>(slot >> 6), static_cast<int>(slot >> 3 & 7),
                                           static_cast<int>(slot & 7));
    });
    return out;
}

} // namespace voxshell
