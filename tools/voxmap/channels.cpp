// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/channels.hpp"

#include "voxmap/crossings.hpp"
#include "voxmap/dilate.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace voxshell {
namespace {

using Vec = std::array<double, 3>; ///< in cells, relative to a brick's minimum corner

/// One ring after another: the cells that the next dilation adds.
void make_layers(const Cells &cells, int count, Channels &out)
{
    const std::size_t bricks = cells.bricks.size();
    const BrickNeighbours neighbours(cells);
    std::vector<CellMask> covered(bricks);
    out.layer.resize(bricks);
    tbb::parallel_for(std::size_t{0}, bricks, [&](std::size_t b) {
        covered[b] = cells.bricks[b].surface;
        for (std::size_t c = 0; c < 512; ++c) {
            const bool surface = cells.bricks[b].surface[c >> 6] >> (c & 63) & 1,
                       interior = cells.bricks[b].interior[c >> 6] >> (c & 63) & 1;
            out.layer[b][c] = static_cast<std::int8_t>(surface ? 0 : interior ? -(count + 1) : count + 1);
        }
    });
    for (int ring = 1; ring <= count; ++ring) {
        std::vector<CellMask> wider = dilate(covered, neighbours);
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

double dot(const Vec &a, const Vec &b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vec minus(const Vec &a, const Vec &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Vec cross(const Vec &a, const Vec &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A triangle ready for many point distances. Coordinates in cells relative to a brick's minimum corner.
struct Facet {
    std::array<Vec, 3> vertex, edge, side;   ///< side[e]: in the plane, normal to edge e, pointing inwards
    std::array<double, 3> inverse_length2{}; ///< of the edges; 0 where the edge is a point
    Vec normal{};                            ///< unit; zero for a degenerate triangle
    double not_flat = -1; ///< 0 for a triangle with a plane: no point is inside of a degenerate one
    Vec low, high;

    Facet(const LatticeMesh &mesh, std::uint32_t triangle, const Cell &corner)
    {
        for (std::size_t v = 0; v < 3; ++v)
            for (std::size_t a = 0; a < 3; ++a)
                vertex[v][a] = static_cast<double>(mesh.vertices[mesh.triangles[triangle][v]][a] -
                                                   (corner[a] << lattice_bits)) *
                               0x1p-16;
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] = std::min({vertex[0][a], vertex[1][a], vertex[2][a]});
            high[a] = std::max({vertex[0][a], vertex[1][a], vertex[2][a]});
        }
        for (std::size_t e = 0; e < 3; ++e) {
            edge[e] = minus(vertex[(e + 1) % 3], vertex[e]);
            const double length2 = dot(edge[e], edge[e]);
            if (length2 > 0) inverse_length2[e] = 1 / length2;
        }
        const Vec cross_edges = cross(edge[0], edge[1]);
        const double length = std::sqrt(dot(cross_edges, cross_edges));
        if (length > 0) {
            normal = {cross_edges[0] / length, cross_edges[1] / length, cross_edges[2] / length};
            not_flat = 0;
        }
        for (std::size_t e = 0; e < 3; ++e) side[e] = cross(normal, edge[e]);
    }
};

// The row loop is worth wider registers; without contraction every clone computes the same bits. Sanitizers
// run before the dynamic linker's choice of a clone is safe.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define VXS_CLONES __attribute__((target_clones("avx2", "default")))
#else
#define VXS_CLONES
#endif

/// Lowers the squared distances of the eight cell centres (x, y, k + 1/2). Without branches: eight at a time.
VXS_CLONES void lower_row(const Facet &__restrict f, double x, double y, double *__restrict row)
{
    for (int k = 0; k < 8; ++k) {
        const double z = k + 0.5;
        double inner = f.not_flat, nearest = row[k];
        for (std::size_t e = 0; e < 3; ++e) {
            const double dx = x - f.vertex[e][0], dy = y - f.vertex[e][1], dz = z - f.vertex[e][2];
            const double t0 =
                (dx * f.edge[e][0] + dy * f.edge[e][1] + dz * f.edge[e][2]) * f.inverse_length2[e];
            const double t1 = t0 < 0 ? 0 : t0, t = t1 > 1 ? 1 : t1;
            const double rx = dx - t * f.edge[e][0], ry = dy - t * f.edge[e][1], rz = dz - t * f.edge[e][2];
            const double d2 = rx * rx + ry * ry + rz * rz;
            nearest = d2 < nearest ? d2 : nearest;
            const double s = dx * f.side[e][0] + dy * f.side[e][1] + dz * f.side[e][2];
            inner = s < inner ? s : inner;
        }
        const double height = (x - f.vertex[0][0]) * f.normal[0] + (y - f.vertex[0][1]) * f.normal[1] +
                              (z - f.vertex[0][2]) * f.normal[2];
        const double plane2 = height * height;
        const double over = inner < 0 ? nearest : plane2;
        row[k] = over < nearest ? over : nearest;
    }
}

/// Lowers `best` (squared, in cells) wherever the facet is nearer than what stands there.
void lower_distances(const Facet &f, double band, std::array<double, 512> &best)
{
    // Lower bounds, of the plane and of the box, spare most facets and rows the exact distance: first for the
    // brick.
    double box2 = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const double gap = std::max({f.low[a] - 7.5, 0.5 - f.high[a], 0.0});
        box2 += gap * gap;
    }
    const double spread = 3.5 * (std::abs(f.normal[0]) + std::abs(f.normal[1]) + std::abs(f.normal[2]));
    const double middle = std::abs(dot(f.normal, minus({4, 4, 4}, f.vertex[0]))) - spread;
    if (box2 >= band * band || middle >= band) return;
    std::array<std::array<double, 8>, 2> gap2;
    for (std::size_t a = 0; a < 2; ++a)
        for (int c = 0; c < 8; ++c) {
            const double gap = std::max({f.low[a] - (c + 0.5), c + 0.5 - f.high[a], 0.0});
            gap2[a][static_cast<std::size_t>(c)] = gap * gap;
        }
    const double end_gap = std::max({f.low[2] - 7.5, 0.5 - f.high[2], 0.0});
    for (std::size_t i = 0; i < 8; ++i)
        for (std::size_t j = 0; j < 8; ++j) {
            const double side2 = gap2[0][i] + gap2[1][j] + end_gap * end_gap;
            if (side2 >= band * band) continue;
            const double x = static_cast<double>(i) + 0.5, y = static_cast<double>(j) + 0.5;
            const double first = (x - f.vertex[0][0]) * f.normal[0] + (y - f.vertex[0][1]) * f.normal[1] +
                                 (0.5 - f.vertex[0][2]) * f.normal[2];
            const double last = first + 7 * f.normal[2];
            const double plane = first * last <= 0 ? 0 : std::min(std::abs(first), std::abs(last));
            double *row = best.data() + 64 * i + 8 * j;
            const double bound = std::max(plane * plane, side2);
            double worst = row[0];
            for (int k = 1; k < 8; ++k) worst = std::max(worst, row[k]);
            if (bound < worst) lower_row(f, x, y, row);
        }
}

/// Which cells' centres are inside: by state, and for surface cells by their winding.
std::vector<CellMask> inside_masks(const Cells &cells, const LatticeMesh &mesh, const WindingNumber &winding,
                                   bool closed_and_oriented, Progress &progress)
{
    const Crossings crossings = closed_and_oriented ? Crossings(mesh, cells, progress) : Crossings();
    std::vector<CellMask> inside(cells.bricks.size());
    progress.stage("signs", cells.bricks.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.bricks.size(), 256),
                      [&](const tbb::blocked_range<std::size_t> &range) {
                          progress.check();
                          for (std::size_t b = range.begin(); b != range.end(); ++b) {
                              const Brick &brick = cells.bricks[b];
                              inside[b] = brick.interior;
                              for (std::size_t i = 0; i < 8; ++i)
                                  for (std::uint64_t left = brick.surface[i]; left; left &= left - 1) {
                                      const int bit = std::countr_zero(left),
                                                local[3] = {static_cast<int>(i), bit >> 3, bit & 7};
                                      bool in;
                                      if (closed_and_oriented) {
                                          in = crossings.winding(brick.at, local) != 0;
                                      } else {
                                          Point center;
                                          for (std::size_t a = 0; a < 3; ++a)
                                              center[a] = cells.voxel *
                                                          (static_cast<double>(cells.origin[a] +
                                                                               8 * std::int64_t{brick.at[a]} +
                                                                               local[a]) +
                                                           0.5);
                                          in = std::abs(winding.at(center)) >= 0.5;
                                      }
                                      if (in) inside[b][i] |= std::uint64_t{1} << bit;
                                  }
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
    // In portions: only what is kept stays in memory (reserving costs address space alone).
    constexpr std::size_t portion = 4096;
    std::vector<std::array<std::int16_t, 512>> fresh(portion);
    out.distance.reserve(cells.bricks.size());
    progress.stage("distance", cells.bricks.size());
    for (std::size_t begin = 0; begin < cells.bricks.size(); begin += portion) {
        const std::size_t end = std::min(cells.bricks.size(), begin + portion);
        tbb::parallel_for(
            tbb::blocked_range<std::size_t>(begin, end, 64),
            [&](const tbb::blocked_range<std::size_t> &range) {
                progress.check();
                std::vector<std::uint32_t> near;
                for (std::size_t b = range.begin(); b != range.end(); ++b) {
                    const Brick &brick = cells.bricks[b];
                    Cell corner;
                    BrickAt source; // the brick in the binning's coordinates
                    for (int a = 0; a < 3; ++a) {
                        corner[a] = cells.origin[a] + 8 * std::int64_t{brick.at[a]};
                        source[a] = static_cast<std::int32_t>((corner[a] - binned.origin[a]) / 8);
                    }
                    near.clear();
                    for (int i = -1; i <= 1; ++i)
                        for (int j = -1; j <= 1; ++j) {
                            const BrickAt first{source[0] + i, source[1] + j, source[2] - 1};
                            for (auto it =
                                     std::lower_bound(binned.bricks.begin(), binned.bricks.end(), first);
                                 it != binned.bricks.end() && (*it)[0] == first[0] && (*it)[1] == first[1] &&
                                 (*it)[2] <= source[2] + 1;
                                 ++it) {
                                const auto triangles =
                                    binned.of(static_cast<std::size_t>(it - binned.bricks.begin()));
                                near.insert(near.end(), triangles.begin(), triangles.end());
                            }
                        }
                    std::sort(near.begin(), near.end());
                    near.erase(std::unique(near.begin(), near.end()), near.end());

                    std::array<double, 512> best;
                    best.fill(band * band);
                    for (const std::uint32_t t : near) lower_distances(Facet(mesh, t, corner), band, best);

                    for (std::size_t c = 0; c < 512; ++c) {
                        const double d = std::min(std::nearbyint(std::sqrt(best[c]) * (steps / band)), steps);
                        fresh[b - begin][c] =
                            static_cast<std::int16_t>(inside[b][c >> 6] >> (c & 63) & 1 ? -d : d);
                        if (d < steps) silent[b] = 0;
                    }
                }
                progress.advance(range.size());
            });
        for (std::size_t b = begin; b < end; ++b)
            if (!silent[b]) out.distance.push_back(fresh[b - begin]);
    }
}

/// Bricks of one state, all of them beyond the layers' reach: they may become uniform again
/// (formats/voxmap.md M306).
std::vector<std::uint8_t> silent_bricks(const Cells &cells, const Channels &channels)
{
    std::vector<std::uint8_t> silent(cells.bricks.size());
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        const Brick &brick = cells.bricks[b];
        std::uint64_t surface = 0, any = 0, all = ~std::uint64_t{0};
        for (std::size_t i = 0; i < 8; ++i)
            surface |= brick.surface[i], any |= brick.interior[i], all &= brick.interior[i];
        bool quiet = !surface && (any == 0 || all == ~std::uint64_t{0});
        for (std::size_t c = 0; c < 512 && quiet && !channels.layer.empty(); ++c)
            quiet = std::abs(channels.layer[b][c]) == channels.layer_count + 1;
        silent[b] = quiet;
    }
    return silent;
}

} // namespace

Channels make_channels(Cells &cells, const LatticeMesh &mesh, const BrickTriangles &binned,
                       const WindingNumber &winding, bool closed_and_oriented, const ChannelRequest &request,
                       Progress &progress)
{
    if (request.layers < 0 || request.layers > max_channel_reach || !(request.distance_cells >= 0) ||
        request.distance_cells > max_channel_reach - 1)
        throw Failure(ExitCode::usage, "", "a channel reaches at most 8 layers or 7 cells of distance");
    Channels out;
    if (request.layers == 0 && request.distance_cells == 0) return out;
    // A centre nearer than d to a point of the mesh is less than d + 1/2 cells from that point's cell, along
    // each axis.
    widen(cells, std::max(request.layers, static_cast<int>(std::ceil(request.distance_cells + 0.5)) - 1));
    if (request.layers > 0) make_layers(cells, request.layers, out);
    std::vector<std::uint8_t> silent = silent_bricks(cells, out);
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
