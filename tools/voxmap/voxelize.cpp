// SPDX-License-Identifier: GPL-3.0-or-later
// Triangle against 8 x 8 x 8 half-open boxes, by separating axes in integers.
//
// A closed triangle T misses the half-open box B = [lo, hi) exactly if one of 13 axes n separates them: the
// box's three, the triangle's normal, and nine edge x axis. B is the union of the closed boxes [lo, hi - e],
// e -> 0, so a tie counts as "separated" whenever the end of the box that ties moves with e: the maximum if
// some n_i > 0, the minimum if some n_i < 0. Of an edge axis only the side on which the edge is extremal
// needs a test (the faces of the Minkowski difference), both where the triangle projects to a segment.
//
// Boxes are S [x, x+1)^3 with S = 2^shift and x in 0..7 relative to the block. For an axis n the box's
// projection is S (n.x + n+ ) at its maximum and S (n.x + n-) at its minimum, with n+ and n- the sums of
// positive and negative components; S divides out of every comparison with the triangle's value w:
//   not separated above:  n.x + n+ >= ceil ((w + [some n_i > 0]) / S)
//   not separated below:  n.x + n- <= floor((w - [some n_i < 0]) / S)
// so that after one shift of w the loops over cells need no wide arithmetic. The nine edge axes each live in
// one coordinate plane: three 8 x 8 masks decide them, and their product leaves few cells for the plane test.
#include "voxmap/voxelize.hpp"

#include "voxmap/lattice_plane.hpp"

#include <algorithm>
#include <bit>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

namespace voxshell {
namespace {

constexpr std::uint64_t every_byte = 0x0101010101010101;

/// Extents up to 2^28 lattice units (4096 cells) and blocks of at most four times that keep the edges' n.p
/// below 2^61 and the plane's n.x below 2^62 (normal below 2^57, x below 8, three terms).
constexpr std::int64_t narrow_extent = std::int64_t{1} << 28;

using Local = std::array<std::int64_t, 3>; ///< lattice units relative to the block's minimum corner

template<class Int>
Int narrowed(Wide value)
{
    if constexpr (sizeof(Int) == sizeof(Wide)) return value;
    // Saturation keeps the comparison's outcome: the other side is below 2^62.
    constexpr Wide limit = Wide{1} << 62;
    return static_cast<Int>(std::clamp(value, -limit, limit));
}

/// Cells of the coordinate plane (a, b), bit 8 a + b, that no edge axis of this plane separates. `low` and
/// `high` limit the cells to the triangle's bounding box.
template<class Int>
std::uint64_t plane_mask(const std::array<Local, 3> &v, int a, int b, int shift, const int *low,
                         const int *high)
{
    const std::uint64_t row = (0xffu << low[b] & 0xff) & (0xffu >> (7 - high[b]));
    std::uint64_t mask =
        row * every_byte & ~std::uint64_t{0} << (8 * low[a]) & ~std::uint64_t{0} >> (56 - 8 * high[a]);

    for (int e = 0; e < 3 && mask; ++e) {
        const Local &p = v[e], &q = v[(e + 1) % 3], &r = v[(e + 2) % 3];
        Int na = static_cast<Int>(p[b]) - q[b], nb = static_cast<Int>(q[a]) - p[a];
        if (na == 0 && nb == 0) continue;
        Int w = na * p[a] + nb * p[b];
        const Int third = na * r[a] + nb * r[b];
        const bool flat = third == w;
        if (third < w) na = -na, nb = -nb, w = -w; // now the triangle lies on the side of larger values

        const Int plus = std::max<Int>(na, 0) + std::max<Int>(nb, 0),
                  minus = std::min<Int>(na, 0) + std::min<Int>(nb, 0), ceil = (Int{1} << shift) - 1;
        const Int above = ((w + (plus > 0) + ceil) >> shift) - plus;
        // The whole block lies on the inner side (7 minus is its least n.x): nothing to cut.
        if (7 * minus < above) mask &= half_plane<Int>(na, nb, above);
        if (flat) {
            const Int below = ((w - (minus < 0)) >> shift) - minus;
            mask &= half_plane<Int>(-na, -nb, -below);
        }
    }
    return mask;
}

/// Bit j of `row` -> byte j all ones.
std::uint64_t spread_bits(std::uint64_t row)
{
    const std::uint64_t own = row * every_byte & 0x8040201008040201; // byte j keeps bit j
    return ((own + 0x7f * every_byte) >> 7 & every_byte) * 0xff;
}

template<class Int>
void met_boxes(const std::array<Local, 3> &v, int shift, const int *low, const int *high,
               std::array<std::uint64_t, 8> &met)
{
    const std::uint64_t yz = plane_mask<Int>(v, 1, 2, shift, low, high);
    if (!yz) return;
    const std::uint64_t xz = plane_mask<Int>(v, 0, 2, shift, low, high);
    if (!xz) return;
    const std::uint64_t xy = plane_mask<Int>(v, 0, 1, shift, low, high);

    Int n[3];
    Wide w = 0;
    for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        n[a] = static_cast<Int>(v[1][b] - v[0][b]) * (v[2][c] - v[0][c]) -
               static_cast<Int>(v[1][c] - v[0][c]) * (v[2][b] - v[0][b]);
        w += static_cast<Wide>(n[a]) * v[0][a];
    }
    Int plus = 0, minus = 0;
    for (const Int c : n) (c > 0 ? plus : minus) += c;
    const Int above = narrowed<Int>((w + (plus > 0) + ((Wide{1} << shift) - 1)) >> shift) - plus;
    const Int below = narrowed<Int>((w - (minus < 0)) >> shift) - minus;

    for (int i = low[0]; i <= high[0]; ++i) {
        const std::uint64_t word =
            yz & (xz >> (8 * i) & 0xff) * every_byte & spread_bits(xy >> (8 * i) & 0xff);
        for (std::uint64_t left = word; left; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const Int value = n[0] * i + n[1] * (bit >> 3) + n[2] * (bit & 7);
            met[i] |= static_cast<std::uint64_t>((value >= above) & (value <= below)) << bit;
        }
    }
}

/// Boxes S (x, x+1)^3, S = 2^shift, of the 8^3 block at `corner` [lattice units] that the closed triangle
/// meets.
void triangle_boxes(const LatticeMesh &mesh, std::uint32_t triangle, const LatticePoint &corner, int shift,
                    std::array<std::uint64_t, 8> &met)
{
    std::array<Local, 3> v;
    std::int64_t extent = 0;
    int low[3], high[3];
    for (int a = 0; a < 3; ++a) {
        for (int c = 0; c < 3; ++c) v[c][a] = mesh.vertices[mesh.triangles[triangle][c]][a] - corner[a];
        const auto [least, most] = std::minmax({v[0][a], v[1][a], v[2][a]});
        extent = std::max(extent, most - least);
        const std::int64_t first = least >> shift, last = most >> shift;
        if (last < 0 || first > 7) return;
        low[a] = static_cast<int>(std::max<std::int64_t>(first, 0));
        high[a] = static_cast<int>(std::min<std::int64_t>(last, 7));
    }
    if (extent <= narrow_extent)
        met_boxes<std::int64_t>(v, shift, low, high, met);
    else
        met_boxes<Wide>(v, shift, low, high, met);
}

constexpr int brick_bits = 3, chunk_bits = 6;
constexpr int brick_shift = lattice_bits + brick_bits;

struct Pair {
    std::uint64_t brick; ///< 21 bits an axis: sorts as BrickAt does
    std::uint32_t triangle;
    bool operator<(const Pair &o) const { return brick != o.brick ? brick < o.brick : triangle < o.triangle; }
};

std::uint64_t brick_key(std::uint64_t i, std::uint64_t j, std::uint64_t k)
{
    return i << 42 | j << 21 | k;
}

/// Descends from a block of 8^3 boxes of size 2^shift to bricks; each level asks the same exact question.
void collect(const LatticeMesh &mesh, std::uint32_t triangle, const LatticePoint &base,
             const LatticePoint &corner, int shift, std::vector<Pair> &out)
{
    std::array<std::uint64_t, 8> met{};
    triangle_boxes(mesh, triangle, corner, shift, met);
    for (int i = 0; i < 8; ++i)
        for (std::uint64_t left = met[i]; left; left &= left - 1) {
            const int bit = std::countr_zero(left);
            const LatticePoint at{corner[0] + (std::int64_t{i} << shift),
                                  corner[1] + (std::int64_t{bit >> 3} << shift),
                                  corner[2] + (std::int64_t{bit & 7} << shift)};
            if (shift == brick_shift) {
                const auto brick = [&](int a) {
                    return static_cast<std::uint64_t>((at[a] - base[a]) >> brick_shift);
                };
                out.push_back({brick_key(brick(0), brick(1), brick(2)), triangle});
            } else {
                collect(mesh, triangle, base, at, shift - brick_bits, out);
            }
        }
}

} // namespace

void triangle_cells(const LatticeMesh &mesh, std::uint32_t triangle, const Cell &brick_min,
                    std::array<std::uint64_t, 8> &met)
{
    triangle_boxes(mesh, triangle,
                   {brick_min[0] << lattice_bits, brick_min[1] << lattice_bits, brick_min[2] << lattice_bits},
                   lattice_bits, met);
}

BrickTriangles bin_triangles(const LatticeMesh &mesh, Progress &progress)
{
    BrickTriangles out;
    LatticePoint base;
    for (int a = 0; a < 3; ++a) {
        out.origin[a] = mesh.min[a] >> chunk_bits << chunk_bits;
        base[a] = out.origin[a] << lattice_bits;
    }

    // Triangles in fixed portions, so that neither memory nor order depends on the number of threads.
    constexpr std::size_t portion = 4096;
    const std::size_t count = mesh.triangles.size(), portions = (count + portion - 1) / portion;
    progress.stage("bin triangles", count);
    std::vector<std::vector<Pair>> pairs(portions);
    tbb::parallel_for(std::size_t{0}, portions, [&](std::size_t p) {
        progress.check();
        const std::size_t last = std::min(count, (p + 1) * portion);
        for (std::size_t t = p * portion; t < last; ++t) {
            LatticePoint low{INT64_MAX, INT64_MAX, INT64_MAX}, high{INT64_MIN, INT64_MIN, INT64_MIN};
            for (const std::uint32_t vertex : mesh.triangles[t])
                for (int a = 0; a < 3; ++a) {
                    low[a] = std::min(low[a], mesh.vertices[vertex][a] - base[a]);
                    high[a] = std::max(high[a], mesh.vertices[vertex][a] - base[a]);
                }
            // The level whose blocks of 8^3 boxes are about as large as the triangle: it meets few of them.
            int shift = brick_shift;
            const std::int64_t extent = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
            while ((extent >> (shift + brick_bits)) > 1) shift += brick_bits;
            const int block = shift + brick_bits;
            LatticePoint at;
            for (at[0] = low[0] >> block << block; at[0] <= high[0]; at[0] += std::int64_t{1} << block)
                for (at[1] = low[1] >> block << block; at[1] <= high[1]; at[1] += std::int64_t{1} << block)
                    for (at[2] = low[2] >> block << block; at[2] <= high[2];
                         at[2] += std::int64_t{1} << block)
                        collect(mesh, static_cast<std::uint32_t>(t), base,
                                {base[0] + at[0], base[1] + at[1], base[2] + at[2]}, shift, pairs[p]);
        }
        progress.advance(last - p * portion);
    });

    std::size_t total = 0;
    for (const auto &part : pairs) total += part.size();
    std::vector<Pair> all;
    all.reserve(total);
    for (auto &part : pairs) {
        all.insert(all.end(), part.begin(), part.end());
        std::vector<Pair>().swap(part);
    }
    progress.check();
    tbb::parallel_sort(all.begin(), all.end());

    out.triangle.resize(total);
    for (std::size_t p = 0; p < total; ++p) {
        if (p == 0 || all[p].brick != all[p - 1].brick) {
            const std::uint64_t key = all[p].brick;
            out.bricks.push_back({static_cast<std::int32_t>(key >> 42),
                                  static_cast<std::int32_t>(key >> 21 & 0x1fffff),
                                  static_cast<std::int32_t>(key & 0x1fffff)});
            out.start.push_back(p);
        }
        out.triangle[p] = all[p].triangle;
    }
    out.start.push_back(total);
    return out;
}

Cells voxelize(const LatticeMesh &mesh, const BrickTriangles &binned, Progress &progress)
{
    Cells out;
    out.voxel = mesh.voxel;
    out.origin = binned.origin;
    out.bricks.resize(binned.bricks.size());
    progress.stage("voxelise", binned.bricks.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, binned.bricks.size(), 256),
                      [&](const tbb::blocked_range<std::size_t> &range) {
                          progress.check();
                          for (std::size_t b = range.begin(); b != range.end(); ++b) {
                              Brick &brick = out.bricks[b];
                              brick.at = binned.bricks[b];
                              const Cell corner{out.origin[0] + 8 * std::int64_t{brick.at[0]},
                                                out.origin[1] + 8 * std::int64_t{brick.at[1]},
                                                out.origin[2] + 8 * std::int64_t{brick.at[2]}};
                              for (const std::uint32_t t : binned.of(b))
                                  triangle_cells(mesh, t, corner, brick.surface);
                          }
                          progress.advance(range.size());
                      });
    recount(out);
    return out;
}

} // namespace voxshell
