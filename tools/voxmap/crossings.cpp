// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/crossings.hpp"

#include "voxmap/lattice_plane.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <numeric>
#include <tbb/parallel_for.h>

namespace voxshell {
namespace {

constexpr int brick_shift = lattice_bits + 3;

using Local =
    std::array<std::int64_t, 2>; ///< (i, j) in lattice units from the centre of a column's first row

/// Rows (bit 8 i + j) of a brick column that pass the triangle: on the inner side of its three edges, which
/// run counterclockwise. Where a row passes through an edge, its shift along i decides, or else that along j.
template<class Int>
std::uint64_t rows_inside(const std::array<Local, 3> &v)
{
    std::uint64_t rows = ~std::uint64_t{0};
    for (int e = 0; e < 3 && rows; ++e) {
        const Local &p = v[e], &q = v[(e + 1) % 3];
        const Int na = static_cast<Int>(p[1]) - q[1], nb = static_cast<Int>(q[0]) - p[0];
        const bool touching = na > 0 || (na == 0 && nb > 0);
        const Int w = na * p[0] + nb * p[1];
        rows &= half_plane<Int>(na, nb, (w + (touching ? 0 : 1) + lattice_per_cell - 1) >> lattice_bits);
    }
    return rows;
}

Wide ceil_divide(Wide a, Wide b) // b > 0
{
    const Wide q = a / b;
    return q * b < a ? q + 1 : q;
}

} // namespace

/// Calls visit(column, rows, v, up) for each brick column that has rows through the triangle; `v` relative to
/// the centre of the column's first row in i and j, to that of the origin's cell in k; `up`: the normal's k >
/// 0.
template<class Visit>
void Crossings::each_rows(const LatticeMesh &mesh, std::size_t triangle, Progress &progress,
                          Visit &&visit) const
{
    constexpr std::int64_t half = lattice_per_cell / 2, narrow_extent = std::int64_t{1} << 28;
    std::array<LatticePoint, 3> v;
    for (int c = 0; c < 3; ++c)
        for (int a = 0; a < 3; ++a)
            v[c][a] = mesh.vertices[mesh.triangles[triangle][c]][a] - (origin_[a] << lattice_bits) - half;
    const Wide area = static_cast<Wide>(v[1][0] - v[0][0]) * (v[2][1] - v[0][1]) -
                      static_cast<Wide>(v[1][1] - v[0][1]) * (v[2][0] - v[0][0]);
    if (area == 0) return; // parallel to the rows: after the shift no row meets it
    if (area < 0) std::swap(v[1], v[2]);
    const auto [low_i, high_i] = std::minmax({v[0][0], v[1][0], v[2][0]});
    const auto [low_j, high_j] = std::minmax({v[0][1], v[1][1], v[2][1]});
    const bool narrow = std::max(high_i - low_i, high_j - low_j) <= narrow_extent;
    for (std::int64_t i = low_i >> brick_shift; i <= high_i >> brick_shift; ++i) {
        progress.check(); // one triangle can be as long as the part
        const Column first{static_cast<std::int32_t>(i), static_cast<std::int32_t>(low_j >> brick_shift)};
        for (auto at = std::lower_bound(columns_.begin(), columns_.end(), first);
             at != columns_.end() && at->first == i && at->second <= high_j >> brick_shift; ++at) {
            std::array<Local, 3> local;
            for (int c = 0; c < 3; ++c)
                local[c] = {v[c][0] - (i << brick_shift),
                            v[c][1] - (std::int64_t{at->second} << brick_shift)};
            if (const std::uint64_t rows =
                    narrow ? rows_inside<std::int64_t>(local) : rows_inside<Wide>(local))
                visit(static_cast<std::size_t>(at - columns_.begin()), rows, local, v, area > 0);
        }
    }
}

Crossings::Crossings(const LatticeMesh &mesh, const Cells &cells, Progress &progress) : origin_(cells.origin)
{
    progress.stage("crossings", 2 * mesh.triangles.size());
    for (const Brick &b : cells.bricks)
        if (columns_.empty() || columns_.back() != Column{b.at[0], b.at[1]})
            columns_.emplace_back(b.at[0], b.at[1]);

    constexpr std::size_t portion = 64;
    const std::size_t count = mesh.triangles.size();
    const auto each_triangle = [&](auto &&work) {
        tbb::parallel_for(std::size_t{0}, (count + portion - 1) / portion, [&](std::size_t part) {
            const std::size_t last = std::min(count, (part + 1) * portion);
            for (std::size_t t = part * portion; t < last; ++t) work(t);
            progress.advance(last - part * portion);
        });
    };
    // Counted first, then stored, each row from its end: the crossings themselves are all the memory that
    // this takes. Sorting a row afterwards undoes the threads' order.
    start_.assign(64 * columns_.size() + 1, 0);
    each_triangle([&](std::size_t t) {
        each_rows(
            mesh, t, progress, [&](std::size_t column, std::uint64_t rows, const auto &, const auto &, bool) {
                for (; rows; rows &= rows - 1)
                    std::atomic_ref(start_[64 * column + static_cast<std::size_t>(std::countr_zero(rows))])
                        .fetch_add(1, std::memory_order_relaxed);
            });
    });
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    crossings_.resize(start_.back());
    each_triangle([&](std::size_t t) {
        each_rows(mesh, t, progress,
                  [&](std::size_t column, std::uint64_t rows, const std::array<Local, 3> &local,
                      const std::array<LatticePoint, 3> &v, bool up) {
                      Wide n[3];
                      for (int a = 0; a < 3; ++a) {
                          const int b = (a + 1) % 3, c = (a + 2) % 3;
                          n[a] = static_cast<Wide>(v[1][b] - v[0][b]) * (v[2][c] - v[0][c]) -
                                 static_cast<Wide>(v[1][c] - v[0][c]) * (v[2][b] - v[0][b]);
                      }
                      const Wide first = n[0] * local[0][0] + n[1] * local[0][1] + n[2] * v[0][2];
                      for (; rows; rows &= rows - 1) {
                          const int row = std::countr_zero(rows);
                          // The plane's height z over the row: n . p = n . v0. Centres at or above it are
                          // past the crossing.
                          const Wide z = first - ((n[0] * (row >> 3) + n[1] * (row & 7)) << lattice_bits);
                          const auto k = static_cast<std::int32_t>(ceil_divide(z, n[2] << lattice_bits));
                          const std::uint32_t at =
                              std::atomic_ref(start_[64 * column + static_cast<std::size_t>(row)])
                                  .fetch_sub(1, std::memory_order_relaxed) -
                              1;
                          crossings_[at] = {k, up ? -1 : 1};
                      }
                  });
    });
    tbb::parallel_for(std::size_t{0}, start_.size() - 1, [&](std::size_t row) {
        std::sort(crossings_.begin() + start_[row], crossings_.begin() + start_[row + 1]);
        for (std::uint32_t c = start_[row] + 1; c < start_[row + 1]; ++c)
            crossings_[c].sum += crossings_[c - 1].sum;
    });
}

void Crossings::mark(const Brick &brick, CellMask &inside) const
{
    const auto column = static_cast<std::size_t>(
        std::lower_bound(columns_.begin(), columns_.end(), Column{brick.at[0], brick.at[1]}) -
        columns_.begin());
    const std::int32_t base = 8 * brick.at[2];
    for (std::size_t r = 0; r < 64; ++r) {
        const std::uint64_t surface = brick.surface[r >> 3] >> (8 * (r & 7)) & 0xff;
        if (!surface) continue;
        const auto begin = crossings_.begin() + start_[64 * column + r],
                   end = crossings_.begin() + start_[64 * column + r + 1];
        auto next =
            std::upper_bound(begin, end, base, [](std::int32_t k, const Crossing &c) { return k < c.k; });
        std::uint64_t row = next != begin && (next - 1)->sum != 0 ? 0xff : 0;
        for (; next != end && next->k < base + 8; ++next) {
            const std::uint64_t above = 0xff << (next->k - base) & 0xff;
            row = next->sum != 0 ? row | above : row & ~above;
        }
        inside[r >> 3] |= (row & surface) << (8 * (r & 7));
    }
}

} // namespace voxshell
