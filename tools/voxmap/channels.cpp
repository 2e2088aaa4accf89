// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/channels.hpp"

#include "voxmap/crossings.hpp"
#include "voxmap/dilate.hpp"
#include "voxmap/lattice_plane.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

namespace voxshell {
namespace {

using Vec = std::array<double, 3>; ///< in cells, relative to a brick's minimum corner

/// One ring after another: the cells that the next dilation adds.
void make_layers(const Cells &cells, int count, Channels &out, Progress &progress)
{
    const std::size_t bricks = cells.bricks.size();
    const BrickNeighbours neighbours(cells, progress);
    std::vector<CellMask> covered(bricks);
    out.layer.resize(bricks);
    tbb::parallel_for(std::size_t{0}, bricks, [&](std::size_t b) {
        if ((b & 1023) == 0) progress.check();
        covered[b] = cells.bricks[b].surface;
        for (std::size_t c = 0; c < 512; ++c) {
            const bool surface = cells.bricks[b].surface[c >> 6] >> (c & 63) & 1,
                       interior = cells.bricks[b].interior[c >> 6] >> (c & 63) & 1;
            out.layer[b][c] = static_cast<std::int8_t>(surface ? 0 : interior ? -(count + 1) : count + 1);
        }
    });
    for (int ring = 1; ring <= count; ++ring) {
        std::vector<CellMask> wider = dilate(covered, neighbours, progress);
        tbb::parallel_for(std::size_t{0}, bricks, [&](std::size_t b) {
            for (std::size_t i = 0; i < 8; ++i)
                for (std::uint64_t fresh = wider[b][i] & ~covered[b][i]; fresh; fresh &= fresh - 1) {
                    std::int8_t &layer =
                        out.layer[b][64 * i + static_cast<std::size_t>(std::countr_zero(fresh))];
                    layer = static_cast<std::int8_t>(layer < 0 ? -ring : ring);
                }
        });
        covered.swap(wider);
    }
    out.layer_count = count;
}

Vec minus(const Vec &a, const Vec &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vec times(double a, const Vec &b)
{
    return {a * b[0], a * b[1], a * b[2]};
}
Vec cross(const Vec &a, const Vec &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double norm1(const Vec &a)
{
    return std::abs(a[0]) + std::abs(a[1]) + std::abs(a[2]);
}

// The loops over rows and cells are worth wider registers; without contraction every clone computes the same
// bits. Sanitizers run before the dynamic linker's choice of a clone is safe.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VXS_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define VXS_CLONES
#endif

/// A triangle ready for many point distances. Coordinates in cells relative to a brick's minimum corner.
///
/// Over the plane a point has a height, and towards each edge a depth: how far its foot lies inside. The
/// nearest point of the triangle is the foot if no depth is negative, and on an edge of negative depth
/// otherwise; so height^2 + min(depth, 0)^2 bounds the squared distance from below.
struct Facet {
    std::array<Vec, 3> vertex, edge, inward; ///< inward[e]: unit, in the plane, normal to edge e
    std::array<double, 3> inverse_length2{}; ///< of the edges; 0 where the edge is a point
    Vec normal{};                            ///< unit; zero, as inward, for a degenerate triangle
    double foot = 0;    ///< least depth of a foot that counts: infinite for a degenerate triangle
    double apart2 = 0;  ///< lower bound of the squared distance of all cell centres of the brick,
    double middle2 = 0; ///< and of its middle

    /// `corner` in lattice units.
    explicit Facet(const std::array<LatticePoint, 3> &corner)
    {
        for (std::size_t v = 0; v < 3; ++v)
            for (std::size_t a = 0; a < 3; ++a) vertex[v][a] = static_cast<double>(corner[v][a]) * 0x1p-16;
        for (std::size_t e = 0; e < 3; ++e) {
            edge[e] = minus(vertex[(e + 1) % 3], vertex[e]);
            const double length2 = dot(edge[e], edge[e]);
            if (length2 > 0) inverse_length2[e] = 1 / length2;
        }
        // In integers: a sliver's normal, too, is good to the last bits.
        Vec area;
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
            area[a] = static_cast<double>(
                static_cast<Wide>(corner[1][b] - corner[0][b]) * (corner[2][c] - corner[1][c]) -
                static_cast<Wide>(corner[1][c] - corner[0][c]) * (corner[2][b] - corner[1][b]));
        }
        const double length = std::sqrt(dot(area, area));
        if (length > 0)
            normal = {area[0] / length, area[1] / length, area[2] / length};
        else
            foot = INFINITY;

        const Vec middle{4, 4, 4};
        double outside = 0, outside_middle = 0;
        for (std::size_t e = 0; e < 3; ++e) {
            inward[e] = times(std::sqrt(inverse_length2[e]), cross(normal, edge[e]));
            const double depth = dot(inward[e], minus(middle, vertex[e]));
            outside = std::min(outside, depth + 3.5 * norm1(inward[e]));
            outside_middle = std::min(outside_middle, depth);
        }
        const double height = std::abs(dot(normal, minus(middle, vertex[0]))),
                     clear = std::max(0.0, height - 3.5 * norm1(normal));
        apart2 = clear * clear + outside * outside;
        middle2 = height * height + outside_middle * outside_middle;
    }
};

/// Squared distances [cells^2] of a brick's cell centres from what was seen so far, at most the band's.
struct Nearest {
    std::array<double, 512> d2;
    std::array<double, 64> row; ///< the largest of each row along k

    explicit Nearest(double band)
    {
        d2.fill(band * band);
        row.fill(band * band);
    }
};

/// Bounds are a hair smaller than computed: what they spare lies farther whatever was rounded.
constexpr double surely = 1 - 1e-9;

/// Rows along k (bit 8 i + j) of which some cell may be nearer to the facet than to what was seen so far.
inline std::uint64_t near_rows(const Facet &f, const Nearest &nearest)
{
    static constexpr std::uint64_t lane[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    std::uint64_t out = 0;
    for (std::size_t i = 0; i < 8; ++i) {
        const double x = static_cast<double>(i) + 0.5;
        std::uint64_t bits = 0;
        for (int j = 0; j < 8; ++j) {
            const double y = j + 0.5;
            const double first = (x - f.vertex[0][0]) * f.normal[0] + (y - f.vertex[0][1]) * f.normal[1] +
                                 (0.5 - f.vertex[0][2]) * f.normal[2];
            const double last = first + 7 * f.normal[2], a = std::abs(first), b = std::abs(last);
            const double height = first * last <= 0 ? 0 : a < b ? a : b;
            double outside = 0;
            for (std::size_t e = 0; e < 3; ++e) {
                const double begin = (x - f.vertex[e][0]) * f.inward[e][0] +
                                     (y - f.vertex[e][1]) * f.inward[e][1] +
                                     (0.5 - f.vertex[e][2]) * f.inward[e][2];
                const double end = begin + 7 * f.inward[e][2], most = begin > end ? begin : end;
                outside = most < outside ? most : outside;
            }
            const double bound = height * height + outside * outside;
            bits |= bound * surely < nearest.row[8 * i + static_cast<std::size_t>(j)] ? lane[j] : 0;
        }
        out |= bits << (8 * i);
    }
    return out;
}

/// Lowers the squared distances of the eight cell centres (x, y, k + 1/2) by those from an edge.
inline void lower_by_edge(const Facet &f, std::size_t e, double x, double y, double *row)
{
    const Vec edge = f.edge[e], from = f.vertex[e];
    const double dx = x - from[0], dy = y - from[1], inverse = f.inverse_length2[e];
#pragma GCC unroll 1
    for (int k = 0; k < 8; ++k) {
        const double dz = k + 0.5 - from[2];
        const double t0 = (dx * edge[0] + dy * edge[1] + dz * edge[2]) * inverse;
        const double t1 = t0 < 0 ? 0 : t0, t = t1 > 1 ? 1 : t1;
        const double rx = dx - t * edge[0], ry = dy - t * edge[1], rz = dz - t * edge[2];
        const double d2 = rx * rx + ry * ry + rz * rz;
        row[k] = d2 < row[k] ? d2 : row[k];
    }
}

/// Lowers what was seen so far by one facet. The loops over eight cells are free of branches.
VXS_CLONES void lower(const Facet &__restrict f, Nearest &__restrict nearest)
{
    for (std::uint64_t left = near_rows(f, nearest); left; left &= left - 1) {
        const int r = std::countr_zero(left);
        const double x = (r >> 3) + 0.5, y = (r & 7) + 0.5;
        double *const row = nearest.d2.data() + 8 * r;
        std::uint64_t nearer = 0; // bit e: some cell may be nearest to edge e; bit 3: or to any of the facet
        for (int k = 0; k < 8; ++k) {
            const double z = k + 0.5;
            const double height = (x - f.vertex[0][0]) * f.normal[0] + (y - f.vertex[0][1]) * f.normal[1] +
                                  (z - f.vertex[0][2]) * f.normal[2];
            std::uint64_t edges = 8;
            double least = 0;
            for (std::size_t e = 0; e < 3; ++e) {
                const double depth = (x - f.vertex[e][0]) * f.inward[e][0] +
                                     (y - f.vertex[e][1]) * f.inward[e][1] +
                                     (z - f.vertex[e][2]) * f.inward[e][2];
                edges |= depth < f.foot ? std::uint64_t{1} << e : 0;
                least = depth < least ? depth : least;
            }
            const double plane2 = height * height;
            nearer |= (plane2 + least * least) * surely < row[k] ? edges : 0;
            const double over = least < f.foot ? row[k] : plane2;
            row[k] = over < row[k] ? over : row[k];
        }
        if (!nearer) continue;
        for (std::size_t e = 0; e < 3; ++e)
            if (nearer >> e & 1) lower_by_edge(f, e, x, y, row);
        double most = row[0];
        for (int k = 1; k < 8; ++k) most = row[k] > most ? row[k] : most;
        nearest.row[r] = most;
    }
}

/// The triangles around a brick.
class Surroundings {
  public:
    Surroundings(const LatticeMesh &mesh, const BrickTriangles &binned, double band)
        : mesh_(mesh), binned_(binned), band2_(band * band),
          reach_(static_cast<std::int32_t>((band + 7.5) / 8))
    {
    }

    /// Lowers `nearest` for the brick at `corner` [cells]. From near bins to far ones: most bricks are done
    /// after the first lot, whatever the band.
    void lower(const Cell &corner, Nearest &nearest)
    {
        find_bins(corner);
        seen_.clear();
        near_.clear();
        double most2 = band2_; // of the cells' squared distances
        for (auto bin = bins_.begin(); bin != bins_.end() && bin->gap2 * surely < most2;) {
            merged_.clear();
            std::set_union(seen_.begin(), seen_.end(), near_.begin(), near_.end(),
                           std::back_inserter(merged_));
            seen_.swap(merged_);
            near_.clear();
            const double lot = std::sqrt(bin->gap2) + 8, until = lot * lot;
            for (; bin != bins_.end() && bin->gap2 < until; ++bin) {
                const auto triangles = binned_.of(bin->index);
                near_.insert(near_.end(), triangles.begin(), triangles.end());
            }
            std::sort(near_.begin(), near_.end());
            near_.erase(std::unique(near_.begin(), near_.end()), near_.end());
            collect(corner, most2);
            for (const std::uint32_t f : order_) voxshell::lower(facets_[f], nearest);
            most2 = *std::max_element(nearest.row.begin(), nearest.row.end());
        }
    }

  private:
    struct Bin {
        double gap2; ///< squared distance of the bin from the box of the brick's cell centres
        std::size_t index;
        auto operator<=>(const Bin &) const = default;
    };
    struct Column {
        double gap2;
        std::vector<BrickAt>::const_iterator begin, end;
    };

    /// From a cell's centre in a brick to a bin that is `step` bricks away, squared.
    static double gap2(std::int32_t step)
    {
        const double gap = std::max(0.0, 8.0 * std::abs(step) - 7.5);
        return gap * gap;
    }

    /// Bins that may hold something nearer than the band, near ones first.
    void find_bins(const Cell &corner)
    {
        BrickAt at; // in the binning's coordinates
        for (int a = 0; a < 3; ++a) at[a] = static_cast<std::int32_t>((corner[a] - binned_.origin[a]) / 8);
        if (!has_columns_ || at[0] != column_[0] || at[1] != column_[1]) find_columns(at);
        bins_.clear();
        for (const Column &column : columns_) {
            auto it = std::lower_bound(column.begin, column.end, at[2] - reach_,
                                       [](const BrickAt &b, std::int32_t k) { return b[2] < k; });
            for (; it != column.end && (*it)[2] <= at[2] + reach_; ++it)
                if (const double gap = column.gap2 + gap2((*it)[2] - at[2]); gap < band2_)
                    bins_.push_back({gap, static_cast<std::size_t>(it - binned_.bricks.begin())});
        }
        std::sort(bins_.begin(), bins_.end());
    }

    /// Columns of bins along k: the same for all bricks of a column.
    void find_columns(const BrickAt &at)
    {
        columns_.clear();
        for (std::int32_t i = -reach_; i <= reach_; ++i)
            for (std::int32_t j = -reach_; j <= reach_; ++j) {
                const double gap = gap2(i) + gap2(j);
                if (gap >= band2_) continue;
                const BrickAt first{at[0] + i, at[1] + j, INT32_MIN}, last{at[0] + i, at[1] + j, INT32_MAX};
                const auto begin = std::lower_bound(binned_.bricks.begin(), binned_.bricks.end(), first),
                           end = std::upper_bound(begin, binned_.bricks.end(), last);
                if (begin != end) columns_.push_back({gap, begin, end});
            }
        column_ = at;
        has_columns_ = true;
    }

    /// Facets of `near_` that were not seen and may be nearer than `most2` to a cell centre. In the order of
    /// `order_` the nearest come first: they spare the others most.
    void collect(const Cell &corner, double most2)
    {
        facets_.clear();
        auto seen = seen_.begin();
        for (const std::uint32_t t : near_) {
            while (seen != seen_.end() && *seen < t) ++seen;
            if (seen != seen_.end() && *seen == t) continue;
            std::array<LatticePoint, 3> v;
            double box2 = 0;
            for (std::size_t a = 0; a < 3; ++a) {
                for (std::size_t c = 0; c < 3; ++c)
                    v[c][a] = mesh_.vertices[mesh_.triangles[t][c]][a] - (corner[a] << lattice_bits);
                const auto [low, high] = std::minmax({v[0][a], v[1][a], v[2][a]});
                const double gap = // from the box of the cells' centres
                    std::max({static_cast<double>(low) * 0x1p-16 - 7.5,
                              0.5 - static_cast<double>(high) * 0x1p-16, 0.0});
                box2 += gap * gap;
            }
            if (box2 * surely >= most2) continue;
            const Facet facet(v);
            if (facet.apart2 * surely < most2) facets_.push_back(facet);
        }
        order_.resize(facets_.size());
        std::iota(order_.begin(), order_.end(), 0u);
        std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
            return std::pair{facets_[a].middle2, a} < std::pair{facets_[b].middle2, b};
        });
    }

    const LatticeMesh &mesh_;
    const BrickTriangles &binned_;
    const double band2_;
    const std::int32_t reach_; ///< in bricks
    BrickAt column_{};
    bool has_columns_ = false;
    std::vector<Column> columns_;
    std::vector<Bin> bins_;
    std::vector<std::uint32_t> near_, seen_, merged_, order_; ///< triangles; places in facets_
    std::vector<Facet> facets_;
};

/// Distances in steps, negative inside. Whether one of them is within the band.
VXS_CLONES bool quantise(const Nearest &nearest, const CellMask &inside, double steps_per_cell, double most,
                         std::array<std::int16_t, 512> &out)
{
    static constexpr std::int16_t lane[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    constexpr double to_even = 0x1.8p52; // added and taken away, rounds to the nearest integer
    std::int32_t least = INT16_MAX;
    for (std::size_t c = 0; c < 512; ++c) {
        const double d = std::sqrt(nearest.d2[c]) * steps_per_cell + to_even - to_even;
        const std::int32_t n = static_cast<std::int32_t>(d < most ? d : most);
        least = n < least ? n : least;
        out[c] = static_cast<std::int16_t>(n);
    }
    for (std::size_t r = 0; r < 64; ++r) {
        const auto row = static_cast<std::int16_t>(inside[r >> 3] >> (8 * (r & 7)) & 0xff);
        for (std::size_t k = 0; k < 8; ++k) {
            std::int16_t &d = out[8 * r + k];
            d = static_cast<std::int16_t>(row & lane[k] ? -d : d);
        }
    }
    return least < static_cast<std::int32_t>(most);
}

/// Which cells' centres are inside: by state, and for surface cells by their winding.
std::vector<CellMask> inside_masks(const Cells &cells, const LatticeMesh &mesh, const WindingNumber &winding,
                                   bool closed_and_oriented, Progress &progress)
{
    std::optional<Crossings> crossings;
    if (closed_and_oriented) crossings.emplace(mesh, cells, progress);
    std::vector<CellMask> inside(cells.bricks.size());
    progress.stage("signs", cells.bricks.size());
    const auto mark_by_winding = [&](const Brick &brick, CellMask &mask) {
        for (std::size_t i = 0; i < 8; ++i)
            for (std::uint64_t left = brick.surface[i]; left; left &= left - 1) {
                const int bit = std::countr_zero(left), local[3] = {static_cast<int>(i), bit >> 3, bit & 7};
                Point center;
                for (std::size_t a = 0; a < 3; ++a)
                    center[a] =
                        cells.voxel *
                        (static_cast<double>(cells.origin[a] + 8 * std::int64_t{brick.at[a]} + local[a]) +
                         0.5);
                if (std::abs(winding.at(center)) >= 0.5) mask[i] |= std::uint64_t{1} << bit;
            }
    };
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.bricks.size(), 256),
                      [&](const tbb::blocked_range<std::size_t> &range) {
                          for (std::size_t b = range.begin(); b != range.end(); ++b) {
                              if (((b - range.begin()) & 15) == 0) progress.check();
                              inside[b] = cells.bricks[b].interior;
                              if (crossings)
                                  crossings->mark(cells.bricks[b], inside[b]);
                              else
                                  mark_by_winding(cells.bricks[b], inside[b]);
                          }
                          progress.advance(range.size());
                      });
    return inside;
}

/// Clears `silent` where the distance says something; stores the distance of bricks that are not silent, in
/// their order.
void make_distance(const Cells &cells, const LatticeMesh &mesh, const BrickTriangles &binned,
                   const WindingNumber &winding, bool closed_and_oriented, double band,
                   std::vector<std::uint8_t> &silent, Channels &out, Progress &progress)
{
    constexpr double steps = 32767;
    out.distance_band = band * cells.voxel;
    out.distance_step = out.distance_band / steps;
    out.distance_error = 0.5 * out.distance_step * (1 + 1e-9) +
                         std::sqrt(3.0) * cells.voxel / (2.0 * static_cast<double>(lattice_per_cell));
    out.unsigned_distance = cells.interior_cells == 0 && !closed_and_oriented;
    const std::vector<CellMask> inside =
        out.unsigned_distance ? std::vector<CellMask>(cells.bricks.size())
                              : inside_masks(cells, mesh, winding, closed_and_oriented, progress);
    // In portions: only what is kept stays in memory (reserving costs address space alone). While a portion
    // is computed, what is kept of the one before moves to its place.
    constexpr std::size_t portion = 4096;
    using Portion = std::vector<std::array<std::int16_t, 512>>;
    Portion fresh(portion), before(portion);
    out.distance.reserve(cells.bricks.size());
    progress.stage("distance", cells.bricks.size());
    const auto compute = [&](std::size_t begin) {
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(begin, std::min(cells.bricks.size(), begin + portion), 64),
            [&](const tbb::blocked_range<std::size_t> &range) {
                Surroundings surroundings(mesh, binned, band);
                for (std::size_t b = range.begin(); b != range.end(); ++b) {
                    progress.check();
                    Cell corner;
                    for (int a = 0; a < 3; ++a)
                        corner[a] = cells.origin[a] + 8 * std::int64_t{cells.bricks[b].at[a]};
                    Nearest nearest(band);
                    surroundings.lower(corner, nearest);
                    if (quantise(nearest, inside[b], steps / band, steps, fresh[b - begin])) silent[b] = 0;
                }
                progress.advance(range.size());
            });
    };
    const auto keep = [&](std::size_t begin, const Portion &from) {
        for (std::size_t b = begin; b < std::min(cells.bricks.size(), begin + portion); ++b)
            if (!silent[b]) out.distance.push_back(from[b - begin]);
    };
    std::size_t begin = 0;
    for (; begin < cells.bricks.size(); begin += portion) {
        tbb::parallel_invoke([&] { compute(begin); },
                             [&] {
                                 if (begin > 0) keep(begin - portion, before);
                             });
        fresh.swap(before);
    }
    if (begin > 0) keep(begin - portion, before);
}

/// Bricks of one state, all of them beyond the layers' reach: they may become uniform again
/// (formats/voxmap.md M306).
std::vector<std::uint8_t> silent_bricks(const Cells &cells, const Channels &channels, Progress &progress)
{
    std::vector<std::uint8_t> silent(cells.bricks.size());
    tbb::parallel_for(std::size_t{0}, cells.bricks.size(), [&](std::size_t b) {
        if ((b & 1023) == 0) progress.check();
        const Brick &brick = cells.bricks[b];
        std::uint64_t surface = 0, any = 0, all = ~std::uint64_t{0};
        for (std::size_t i = 0; i < 8; ++i)
            surface |= brick.surface[i], any |= brick.interior[i], all &= brick.interior[i];
        bool quiet = !surface && (any == 0 || all == ~std::uint64_t{0});
        for (std::size_t c = 0; c < 512 && quiet && !channels.layer.empty(); ++c)
            quiet = std::abs(channels.layer[b][c]) == channels.layer_count + 1;
        silent[b] = quiet;
    });
    return silent;
}

} // namespace

Channels make_channels(Cells &cells, const LatticeMesh &mesh, const BrickTriangles &binned,
                       const WindingNumber &winding, bool closed_and_oriented, const ChannelRequest &request,
                       Progress &progress)
{
    if (request.layers < 0 || request.layers > most_layers || !(request.distance_cells >= 0) ||
        request.distance_cells > most_distance_cells)
        throw Failure(ExitCode::usage, "", "a channel reaches at most 8 layers or 64 cells of distance");
    Channels out;
    if (request.layers == 0 && request.distance_cells == 0) return out;
    // A centre nearer than d to a point of the mesh is less than d + 1/2 cells from that point's cell, along
    // each axis.
    widen(cells, std::max(request.layers, static_cast<int>(std::ceil(request.distance_cells + 0.5)) - 1),
          progress);
    if (request.layers > 0) make_layers(cells, request.layers, out, progress);
    std::vector<std::uint8_t> silent = silent_bricks(cells, out, progress);
    if (request.distance_cells > 0)
        make_distance(cells, mesh, binned, winding, closed_and_oriented, request.distance_cells, silent, out,
                      progress);
    const std::vector<std::size_t> kept = make_uniform(cells, silent);
    if (request.layers > 0) {
        for (std::size_t n = 0; n < kept.size(); ++n) out.layer[n] = out.layer[kept[n]];
        out.layer.resize(kept.size());
    }
    return out;
}

} // namespace voxshell
