// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/channels.hpp"

#include "voxmap/crossings.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace voxshell {
namespace {

using Vec = std::array<double, 3>; ///< in cells, relative to a brick's minimum corner

constexpr std::size_t no_brick = SIZE_MAX;

std::size_t find_brick(const std::vector<Brick> &bricks, const BrickAt &at)
{
    const auto found = std::lower_bound(bricks.begin(), bricks.end(), at, [](const Brick &b, const BrickAt &key) { return b.at < key; });
    return found != bricks.end() && found->at == at ? static_cast<std::size_t>(found - bricks.begin()) : no_brick;
}

/// Adds every brick that has a cell within `reach` cells (Chebyshev) of a surface cell. Solid runs give way.
void widen(Cells &cells, int reach)
{
    std::vector<BrickAt> wanted;
    for (const Brick &b : cells.bricks) {
        std::uint64_t all = 0;
        int low[3] = {8, 0, 0}, high[3] = {-1, 0, 0};
        for (int i = 0; i < 8; ++i)
            if (b.surface[i]) all |= b.surface[i], low[0] = std::min(low[0], i), high[0] = i;
        if (!all) continue;
        std::uint64_t row = all | all >> 32;
        row |= row >> 16;
        row = (row | row >> 8) & 0xff;
        low[1] = std::countr_zero(all) / 8, high[1] = 7 - std::countl_zero(all) / 8;
        low[2] = std::countr_zero(row), high[2] = 63 - std::countl_zero(row);
        const auto reaches = [&](int axis, int step) { return step == 0 || (step < 0 ? low[axis] - reach < 0 : high[axis] + reach > 7); };
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k)
                    if ((i || j || k) && reaches(0, i) && reaches(1, j) && reaches(2, k)) wanted.push_back({b.at[0] + i, b.at[1] + j, b.at[2] + k});
    }
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());

    // The band may leave the box: move the origin down by whole chunks so that bricks stay >= 0.
    Cell shift{};
    for (const BrickAt &at : wanted)
        for (int a = 0; a < 3; ++a)
            if (at[a] < 0) shift[a] = VXS_VOXMAP_CHUNK_BRICKS;
    const auto moved = [&](const BrickAt &at) {
        return BrickAt{at[0] + static_cast<std::int32_t>(shift[0]), at[1] + static_cast<std::int32_t>(shift[1]), at[2] + static_cast<std::int32_t>(shift[2])};
    };
    for (Brick &b : cells.bricks) b.at = moved(b.at);
    for (SolidRun &r : cells.solid) {
        r.i += static_cast<std::int32_t>(shift[0]), r.j += static_cast<std::int32_t>(shift[1]);
        r.first += static_cast<std::int32_t>(shift[2]), r.last += static_cast<std::int32_t>(shift[2]);
    }
    for (int a = 0; a < 3; ++a) cells.origin[a] -= 8 * shift[a];

    std::vector<Brick> merged;
    std::vector<SolidRun> solid;
    merged.reserve(cells.bricks.size() + wanted.size());
    std::size_t b = 0, run = 0;
    SolidRun rest = cells.solid.empty() ? SolidRun{INT32_MAX, 0, 0, 0} : cells.solid[0];
    const auto next_run = [&] { rest = ++run < cells.solid.size() ? cells.solid[run] : SolidRun{INT32_MAX, 0, 0, 0}; };
    for (const BrickAt &unmoved : wanted) {
        const BrickAt at = moved(unmoved);
        while (b < cells.bricks.size() && cells.bricks[b].at < at) merged.push_back(cells.bricks[b++]);
        if (b < cells.bricks.size() && cells.bricks[b].at == at) continue;
        while (BrickAt{rest.i, rest.j, rest.last} < at) solid.push_back(rest), next_run();
        Brick extra;
        extra.at = at;
        if (rest.i == at[0] && rest.j == at[1] && rest.first <= at[2]) {
            extra.interior.fill(~std::uint64_t{0});
            if (rest.first < at[2]) solid.push_back({rest.i, rest.j, rest.first, at[2] - 1});
            rest.first = at[2] + 1;
            if (rest.first > rest.last) next_run();
        }
        merged.push_back(extra);
    }
    merged.insert(merged.end(), cells.bricks.begin() + static_cast<std::ptrdiff_t>(b), cells.bricks.end());
    for (; run < cells.solid.size(); next_run()) solid.push_back(rest);
    cells.bricks = std::move(merged);
    cells.solid = std::move(solid);
}

/// Spreads a plane of 8 x 8 bits by one along each axis, inside the brick; the borders come from the neighbours.
struct Neighbourhood {
    std::array<std::array<std::uint64_t, 8>, 27> word{}; ///< brick (i, j, k) of -1..1 at 9 (i + 1) + 3 (j + 1) + k + 1

    /// Bits of plane `i` (-1..8), shifted so that the result's bit (j, k) is the source's (j + dj, k + dk).
    std::uint64_t plane(int i, int dj, int dk) const
    {
        const int bi = i < 0 ? 0 : i > 7 ? 2 : 1, local = i & 7;
        const auto part = [&](int bj, int bk) { return word[static_cast<std::size_t>(9 * bi + 3 * bj + bk)][static_cast<std::size_t>(local)]; };
        const auto along_k = [&](int bj) { // shift by dk with the bytes of the k neighbour
            const std::uint64_t own = part(bj, 1);
            constexpr std::uint64_t top = 0x8080808080808080, bottom = 0x0101010101010101;
            if (dk > 0) return (own >> 1 & ~top) | (part(bj, 2) & bottom) << 7;
            if (dk < 0) return (own << 1 & ~bottom) | (part(bj, 0) & top) >> 7;
            return own;
        };
        if (dj > 0) return along_k(1) >> 8 | along_k(2) << 56;
        if (dj < 0) return along_k(1) << 8 | along_k(0) >> 56;
        return along_k(1);
    }
};

/// One ring after another: bits of ring r are the dilation of all before.
void make_layers(const Cells &cells, const std::vector<std::array<std::size_t, 27>> &neighbours, int count, Channels &out)
{
    const std::size_t bricks = cells.bricks.size();
    std::vector<std::array<std::uint64_t, 8>> covered(bricks), next(bricks);
    out.layer.resize(bricks);
    tbb::parallel_for(std::size_t{0}, bricks, [&](std::size_t b) {
        covered[b] = cells.bricks[b].surface;
        for (std::size_t c = 0; c < 512; ++c) {
            const bool surface = cells.bricks[b].surface[c >> 6] >> (c & 63) & 1, interior = cells.bricks[b].interior[c >> 6] >> (c & 63) & 1;
            out.layer[b][c] = static_cast<std::int8_t>(surface ? 0 : interior ? -(count + 1) : count + 1);
        }
    });
    for (int ring = 1; ring <= count; ++ring) {
        tbb::parallel_for(std::size_t{0}, bricks, [&](std::size_t b) {
            Neighbourhood around;
            for (std::size_t n = 0; n < 27; ++n)
                if (neighbours[b][n] != no_brick) around.word[n] = covered[neighbours[b][n]];
            for (int i = 0; i < 8; ++i) {
                std::uint64_t any = 0;
                for (int di = -1; di <= 1; ++di)
                    for (int dj = -1; dj <= 1; ++dj)
                        for (int dk = -1; dk <= 1; ++dk) any |= around.plane(i + di, dj, dk);
                next[b][i] = any;
                for (std::uint64_t fresh = any & ~covered[b][i]; fresh; fresh &= fresh - 1) {
                    std::int8_t &layer = out.layer[b][64 * static_cast<std::size_t>(i) + static_cast<std::size_t>(std::countr_zero(fresh))];
                    layer = static_cast<std::int8_t>(layer < 0 ? -ring : ring);
                }
            }
        });
        covered.swap(next);
    }
    out.layer_count = count;
}

double dot(const Vec &a, const Vec &b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec minus(const Vec &a, const Vec &b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec cross(const Vec &a, const Vec &b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }

/// A triangle ready for many point distances. Coordinates in cells relative to a brick's minimum corner.
struct Facet {
    std::array<Vec, 3> vertex, edge, side;  ///< side[e]: in the plane, normal to edge e, pointing inwards
    std::array<double, 3> inverse_length2{}; ///< of the edges; 0 where the edge is a point
    Vec normal{};                            ///< unit; zero for a degenerate triangle
    double not_flat = -1;                    ///< 0 for a triangle with a plane: no point is inside of a degenerate one
    Vec low, high;

    Facet(const LatticeMesh &mesh, std::uint32_t triangle, const Cell &corner)
    {
        for (std::size_t v = 0; v < 3; ++v)
            for (std::size_t a = 0; a < 3; ++a)
                vertex[v][a] = static_cast<double>(mesh.vertices[mesh.triangles[triangle][v]][a] - (corner[a] << lattice_bits)) * 0x1p-16;
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

// The row loop is worth wider registers; without contraction every clone computes the same bits. Sanitizers run before
// the dynamic linker's choice of a clone is safe.
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
            const double t0 = (dx * f.edge[e][0] + dy * f.edge[e][1] + dz * f.edge[e][2]) * f.inverse_length2[e];
            const double t1 = t0 < 0 ? 0 : t0, t = t1 > 1 ? 1 : t1;
            const double rx = dx - t * f.edge[e][0], ry = dy - t * f.edge[e][1], rz = dz - t * f.edge[e][2];
            const double d2 = rx * rx + ry * ry + rz * rz;
            nearest = d2 < nearest ? d2 : nearest;
            const double s = dx * f.side[e][0] + dy * f.side[e][1] + dz * f.side[e][2];
            inner = s < inner ? s : inner;
        }
        const double height = (x - f.vertex[0][0]) * f.normal[0] + (y - f.vertex[0][1]) * f.normal[1] + (z - f.vertex[0][2]) * f.normal[2];
        const double plane2 = height * height;
        const double over = inner < 0 ? nearest : plane2;
        row[k] = over < nearest ? over : nearest;
    }
}

/// Lowers `best` (squared, in cells) wherever the facet is nearer than what stands there.
void lower_distances(const Facet &f, double band, std::array<double, 512> &best)
{
    // Lower bounds, of the plane and of the box, spare most facets and rows the exact distance: first for the brick.
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
            const double first = (x - f.vertex[0][0]) * f.normal[0] + (y - f.vertex[0][1]) * f.normal[1] + (0.5 - f.vertex[0][2]) * f.normal[2];
            const double last = first + 7 * f.normal[2];
            const double plane = first * last <= 0 ? 0 : std::min(std::abs(first), std::abs(last));
            double *row = best.data() + 64 * i + 8 * j;
            const double bound = std::max(plane * plane, side2);
            double worst = row[0];
            for (int k = 1; k < 8; ++k) worst = std::max(worst, row[k]);
            if (bound < worst) lower_row(f, x, y, row);
        }
}

void make_distance(const Cells &cells, const LatticeMesh &mesh, const BrickTriangles &binned, const WindingNumber &winding,
                   bool closed_and_oriented, double band, Channels &out, Progress &progress)
{
    constexpr double steps = 32767;
    out.distance_band = band * cells.voxel;
    out.distance_step = out.distance_band / steps;
    out.distance_error = 0.5 * out.distance_step * (1 + 1e-9) + std::sqrt(3.0) * cells.voxel / (2.0 * static_cast<double>(lattice_per_cell));
    out.unsigned_distance = cells.interior_cells == 0 && !closed_and_oriented;
    out.distance.resize(cells.bricks.size());
    const Crossings crossings = out.unsigned_distance || !closed_and_oriented ? Crossings() : Crossings(mesh, cells, progress);

    progress.stage("distance", cells.bricks.size());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.bricks.size(), 64), [&](const tbb::blocked_range<std::size_t> &range) {
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
                    for (auto it = std::lower_bound(binned.bricks.begin(), binned.bricks.end(), first);
                         it != binned.bricks.end() && (*it)[0] == first[0] && (*it)[1] == first[1] && (*it)[2] <= source[2] + 1; ++it) {
                        const auto triangles = binned.of(static_cast<std::size_t>(it - binned.bricks.begin()));
                        near.insert(near.end(), triangles.begin(), triangles.end());
                    }
                }
            std::sort(near.begin(), near.end());
            near.erase(std::unique(near.begin(), near.end()), near.end());

            std::array<double, 512> best;
            best.fill(band * band);
            for (const std::uint32_t t : near) lower_distances(Facet(mesh, t, corner), band, best);

            for (std::size_t c = 0; c < 512; ++c) {
                double d = std::sqrt(best[c]) * (steps / band);
                const bool surface = brick.surface[c >> 6] >> (c & 63) & 1;
                bool inside = brick.interior[c >> 6] >> (c & 63) & 1;
                if (surface && !out.unsigned_distance) {
                    const int at[3] = {static_cast<int>(c >> 6), static_cast<int>(c >> 3 & 7), static_cast<int>(c & 7)};
                    if (closed_and_oriented) {
                        inside = crossings.winding(brick.at, at) != 0;
                    } else {
                        Point center;
                        for (int a = 0; a < 3; ++a) center[a] = cells.voxel * (static_cast<double>(corner[a] + at[a]) + 0.5);
                        inside = std::abs(winding.at(center)) >= 0.5;
                    }
                }
                d = std::min(std::nearbyint(d), steps);
                out.distance[b][c] = static_cast<std::int16_t>(inside ? -d : d);
            }
        }
        progress.advance(range.size());
    });
}

/// Bricks that say nothing more than "beyond", in one state, become uniform again (formats/voxmap.md M306).
void prune(Cells &cells, Channels &channels)
{
    std::size_t kept = 0;
    std::vector<SolidRun> solid;
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        const Brick &brick = cells.bricks[b];
        std::uint64_t surface = 0, any = 0, all = ~std::uint64_t{0};
        for (int i = 0; i < 8; ++i) surface |= brick.surface[i], any |= brick.interior[i], all &= brick.interior[i];
        bool silent = !surface && (any == 0 || all == ~std::uint64_t{0});
        for (std::size_t c = 0; c < 512 && silent; ++c)
            silent = (channels.layer.empty() || std::abs(channels.layer[b][c]) == channels.layer_count + 1) &&
                     (channels.distance.empty() || std::abs(channels.distance[b][c]) == 32767);
        if (silent) {
            if (any) solid.push_back({brick.at[0], brick.at[1], brick.at[2], brick.at[2]});
            continue;
        }
        if (kept != b) {
            cells.bricks[kept] = brick;
            if (!channels.layer.empty()) channels.layer[kept] = channels.layer[b];
            if (!channels.distance.empty()) channels.distance[kept] = channels.distance[b];
        }
        ++kept;
    }
    cells.bricks.resize(kept);
    if (!channels.layer.empty()) channels.layer.resize(kept);
    if (!channels.distance.empty()) channels.distance.resize(kept);
    if (solid.empty()) return;
    solid.insert(solid.end(), cells.solid.begin(), cells.solid.end());
    std::sort(solid.begin(), solid.end(), [](const SolidRun &a, const SolidRun &b) { return BrickAt{a.i, a.j, a.first} < BrickAt{b.i, b.j, b.first}; });
    cells.solid.clear();
    for (const SolidRun &r : solid) {
        if (!cells.solid.empty() && cells.solid.back().i == r.i && cells.solid.back().j == r.j && cells.solid.back().last + 1 == r.first)
            cells.solid.back().last = r.last;
        else
            cells.solid.push_back(r);
    }
}

} // namespace

Channels make_channels(Cells &cells, const LatticeMesh &mesh, const BrickTriangles &binned, const WindingNumber &winding,
                       bool closed_and_oriented, const ChannelRequest &request, Progress &progress)
{
    if (request.layers < 0 || request.layers > max_channel_reach || !(request.distance_cells >= 0) ||
        request.distance_cells > max_channel_reach - 1)
        throw Failure(ExitCode::usage, "", "a channel reaches at most 8 layers or 7 cells of distance");
    Channels out;
    if (request.layers == 0 && request.distance_cells == 0) return out;
    // A centre within d of a point of the mesh is within ceil(d + 1/2) cells of that point's cell.
    widen(cells, std::max(request.layers, static_cast<int>(std::ceil(request.distance_cells + 0.5))));
    if (request.layers > 0) {
        std::vector<std::array<std::size_t, 27>> neighbours(cells.bricks.size());
        tbb::parallel_for(std::size_t{0}, cells.bricks.size(), [&](std::size_t b) {
            for (int n = 0; n < 27; ++n)
                neighbours[b][static_cast<std::size_t>(n)] =
                    find_brick(cells.bricks, {cells.bricks[b].at[0] + n / 9 - 1, cells.bricks[b].at[1] + n / 3 % 3 - 1, cells.bricks[b].at[2] + n % 3 - 1});
        });
        make_layers(cells, neighbours, request.layers, out);
    }
    if (request.distance_cells > 0)
        make_distance(cells, mesh, binned, winding, closed_and_oriented, request.distance_cells, out, progress);
    prune(cells, out);
    return out;
}

} // namespace voxshell
