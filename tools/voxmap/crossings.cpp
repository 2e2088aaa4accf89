// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/crossings.hpp"

#include <algorithm>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

namespace voxshell {
namespace {

__extension__ typedef __int128 Wide;

Wide floor_divide(Wide a, Wide b) // b > 0
{
    const Wide q = a / b;
    return a % b < 0 ? q - 1 : q;
}

} // namespace

Crossings::Crossings(const LatticeMesh &mesh, const Cells &cells, Progress &progress)
{
    progress.stage("signs", mesh.triangles.size());
    constexpr std::int64_t half = lattice_per_cell / 2;
    constexpr std::size_t portion = 4096;
    const std::size_t count = mesh.triangles.size(), portions = (count + portion - 1) / portion;
    const auto each_crossing = [&](std::size_t t, auto &&visit) {
        // Coordinates relative to the centre of the cell at the origin: centres are multiples of the cell.
        std::array<LatticePoint, 3> v;
        for (int c = 0; c < 3; ++c)
            for (int a = 0; a < 3; ++a)
                v[c][a] = mesh.vertices[mesh.triangles[t][c]][a] - (cells.origin[a] << lattice_bits) - half;
        Wide n[3];
        for (int a = 0; a < 3; ++a) {
            const int b = (a + 1) % 3, c = (a + 2) % 3;
            n[a] = static_cast<Wide>(v[1][b] - v[0][b]) * (v[2][c] - v[0][c]) -
                   static_cast<Wide>(v[1][c] - v[0][c]) * (v[2][b] - v[0][b]);
        }
        if (n[2] == 0) return; // parallel to the rows: after the shift no row meets it
        const int up = n[2] > 0 ? 1 : -1;
        const auto [low_i, high_i] = std::minmax({v[0][0], v[1][0], v[2][0]});
        const auto [low_j, high_j] = std::minmax({v[0][1], v[1][1], v[2][1]});
        for (std::int64_t i = low_i >> lattice_bits; i <= high_i >> lattice_bits; ++i)
            for (std::int64_t j = low_j >> lattice_bits; j <= high_j >> lattice_bits; ++j) {
                const std::int64_t x = i << lattice_bits, y = j << lattice_bits;
                bool inside = true;
                for (int e = 0; e < 3 && inside; ++e) {
                    const LatticePoint &p = v[e], &q = v[(e + 1) % 3];
                    // The edge function at (x + e, y + e^2): its sign is that of its first term that is not
                    // zero.
                    const std::int64_t di = q[0] - p[0], dj = q[1] - p[1];
                    Wide f = static_cast<Wide>(di) * (y - p[1]) - static_cast<Wide>(dj) * (x - p[0]);
                    if (f == 0) f = -dj;
                    if (f == 0) f = di;
                    inside = up > 0 ? f > 0 : f < 0;
                }
                if (!inside) continue;
                // The plane's height over (x, y): z with n . (p - v0) = 0. Centres at or above it are past
                // the crossing.
                const Wide down = up > 0 ? n[2] : -n[2];
                const Wide above = (n[0] * (v[0][0] - x) + n[1] * (v[0][1] - y)) * up; // down * (z - v0z)
                const Wide top =
                    static_cast<Wide>(v[0][2]) + floor_divide(above + down - 1, down); // ceil of z
                const Wide k = floor_divide(top + lattice_per_cell - 1, lattice_per_cell);
                visit(Crossing{static_cast<std::uint64_t>(i) << 32 | static_cast<std::uint64_t>(j),
                               static_cast<std::int32_t>(k), -up});
            }
    };
    // Counted first, then stored: the crossings themselves are all the memory that this takes.
    std::vector<std::size_t> start(portions + 1, 0);
    const auto each_portion = [&](auto &&work) {
        tbb::parallel_for(std::size_t{0}, portions, [&](std::size_t part) {
            progress.check();
            for (std::size_t t = part * portion; t < std::min(count, (part + 1) * portion); ++t)
                work(part, t);
        });
    };
    each_portion([&](std::size_t part, std::size_t t) {
        each_crossing(t, [&](const Crossing &) { ++start[part + 1]; });
    });
    progress.advance(count / 2);
    for (std::size_t part = 0; part < portions; ++part) start[part + 1] += start[part];
    crossings_.resize(start[portions]);
    each_portion([&](std::size_t part, std::size_t t) {
        each_crossing(t, [&](const Crossing &c) { crossings_[start[part]++] = c; });
    });
    progress.advance(count - count / 2);
    tbb::parallel_sort(crossings_.begin(), crossings_.end(), [](const Crossing &a, const Crossing &b) {
        return a.row != b.row ? a.row < b.row : a.k != b.k ? a.k < b.k : a.sum < b.sum;
    });
    for (std::size_t c = 1; c < crossings_.size(); ++c)
        if (crossings_[c].row == crossings_[c - 1].row) crossings_[c].sum += crossings_[c - 1].sum;
}

int Crossings::winding(const BrickAt &at, const int local[3]) const
{
    const std::uint64_t row = static_cast<std::uint64_t>(8 * std::int64_t{at[0]} + local[0]) << 32 |
                              static_cast<std::uint64_t>(8 * std::int64_t{at[1]} + local[1]);
    const std::int32_t k = 8 * at[2] + local[2];
    const auto after = std::upper_bound(crossings_.begin(), crossings_.end(), std::pair{row, k},
                                        [](const auto &key, const Crossing &c) {
                                            return key.first != c.row ? key.first < c.row : key.second < c.k;
                                        });
    return after == crossings_.begin() || (after - 1)->row != row ? 0 : (after - 1)->sum;
}

} // namespace voxshell
