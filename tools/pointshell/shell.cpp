// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/shell.hpp"

#include "pointshell/cluster.hpp"
#include "pointshell/halo.hpp"
#include "pointshell/sides.hpp"
#include "pointshell/thin.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/core.h>
#include <limits>
#include <utility>

namespace voxshell {
namespace {

// A brick's 512 cells so that blocks of 2^3 (and 4^3) stand together: thin.hpp relies on it.
std::array<std::uint16_t, 512> cell_order()
{
    std::array<std::uint16_t, 512> order{};
    for (std::uint16_t c = 0; c < 512; ++c) {
        int place = 0; // the bits of i, j and k in turn
        for (int bit = 0; bit < 3; ++bit)
            place |= (c >> (6 + bit) & 1) << (3 * bit + 2) | (c >> (3 + bit) & 1) << (3 * bit + 1) |
                     (c >> bit & 1) << 3 * bit;
        order[place] = c;
    }
    return order;
}

// Buffers of one thread, kept from brick to brick.
struct Scratch {
    std::vector<Piece> found, pieces; ///< as found; sorted by cell
    std::array<std::uint32_t, 513> start{};
};

struct Portion { // what a run of bricks gives
    std::vector<ShellPoint> points;
    double area = 0, surface_error = 0;
    std::uint64_t cells = 0;
};

class Maker {
  public:
    Maker(const LatticeMesh &mesh, const BrickTriangles &binned, const Cells &cells, ShellKind kind)
        : mesh_(mesh), binned_(binned), cells_(cells), kind_(kind)
    {
    }

    // Points of one brick, appended to `out` in cell_order().
    void brick(std::size_t index, Scratch &scratch, Portion &out) const;

  private:
    void find_pieces(const Brick &brick, const Cell &corner, Scratch &scratch) const;
    Vec inward(const Side &side, std::span<const Piece> pieces, const Cell &cell) const;
    ShellPoint point(const Side &side, const Cell &cell, Portion &out) const;

    const LatticeMesh &mesh_;
    const BrickTriangles &binned_;
    const Cells &cells_;
    ShellKind kind_;
    std::array<std::uint16_t, 512> order_ = cell_order();
};

LatticeTriangle triangle_of(const LatticeMesh &mesh, std::uint32_t t)
{
    const auto &[a, b, c] = mesh.triangles[t];
    return lattice_triangle(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]);
}

void Maker::find_pieces(const Brick &brick, const Cell &corner, Scratch &scratch) const
{
    scratch.found.clear();
    BrickAt at{}; // in the bins' own frame
    for (int i = 0; i < 3; ++i)
        at[i] = static_cast<std::int32_t>((corner[i] - binned_.origin[i]) / VXS_VOXMAP_BRICK_CELLS);
    const auto bin = std::lower_bound(binned_.bricks.begin(), binned_.bricks.end(), at);
    if (bin == binned_.bricks.end() || *bin != at) return;
    for (const std::uint32_t t : binned_.of(static_cast<std::size_t>(bin - binned_.bricks.begin()))) {
        std::array<std::uint64_t, 8> met{};
        triangle_cells(mesh_, t, corner, met);
        const LatticeTriangle triangle = triangle_of(mesh_, t);
        for (int i = 0; i < 8; ++i)
            for (std::uint64_t bits = met[i] & brick.surface[i]; bits; bits &= bits - 1) {
                const int jk = std::countr_zero(bits);
                const Cell cell{corner[0] + i, corner[1] + (jk >> 3), corner[2] + (jk & 7)};
                const Projection p = project(seen_from(cell, triangle));
                scratch.found.push_back({p.point, p.distance2, p.area, triangle.normal, t,
                                         static_cast<std::uint16_t>(i << 6 | jk)});
            }
    }
}

// The side's normal, led into the solid where one of the faces that its point lies on asks for it.
Vec Maker::inward(const Side &side, std::span<const Piece> pieces, const Cell &cell) const
{
    const Vec &point = side.nearest->point;
    const auto asks = [&](const Piece &piece) {
        return has_plane(piece) && dot(piece.normal, side.inward) > -grazing;
    };
    if (std::none_of(pieces.begin(), pieces.end(), asks)) return side.inward;
    std::vector<CellTriangle> facets;
    for (const Piece &piece : pieces) {
        if (!has_plane(piece) || std::abs(dot(piece.normal, piece.point - point)) > on_facet) continue;
        const CellTriangle facet = seen_from(cell, triangle_of(mesh_, piece.triangle));
        const Vec off = point - nearest_on_triangle(facet, point);
        if (dot(off, off) <= on_facet * on_facet) facets.push_back(facet);
    }
    return into_solid(side.inward, point, facets);
}

// The float nearest to `x` that lies in [low, high], or the nearest of all where the cell is too small for
// floats.
float into(double x, double low, double high)
{
    const float f = static_cast<float>(x);
    float g = f;
    if (static_cast<double>(f) < low) g = std::nextafter(f, std::numeric_limits<float>::infinity());
    if (static_cast<double>(f) > high) g = std::nextafter(f, -std::numeric_limits<float>::infinity());
    return static_cast<double>(g) < low || static_cast<double>(g) > high ? f : g;
}

ShellPoint Maker::point(const Side &side, const Cell &cell, Portion &out) const
{
    const double h = mesh_.voxel;
    ShellPoint p{};
    Vec stored; // as rounded, in the cell's frame
    for (int i = 0; i < 3; ++i) {
        const double low = h * static_cast<double>(cell[i]), high = h * static_cast<double>(cell[i] + 1);
        const double within = kind_ == ShellKind::exact ? 0.5 + side.nearest->point[i] : 0.5;
        p.position[i] = into(low + h * within, low, high);
        stored[i] = (static_cast<double>(p.position[i]) - low) / h - 0.5;
        p.normal[i] = static_cast<float>(side.inward[i]);
    }
    const double area = side.area * h * h;
    p.area = static_cast<float>(area);
    out.area += area;
    const CellTriangle triangle = seen_from(cell, triangle_of(mesh_, side.nearest->triangle));
    const Vec off = stored - nearest_on_triangle(triangle, stored);
    out.surface_error = std::max(out.surface_error, h * std::sqrt(dot(off, off)));
    return p;
}

void Maker::brick(std::size_t index, Scratch &scratch, Portion &out) const
{
    const Brick &brick = cells_.bricks[index];
    Cell corner;
    for (int i = 0; i < 3; ++i)
        corner[i] = cells_.origin[i] + VXS_VOXMAP_BRICK_CELLS * std::int64_t{brick.at[i]};
    find_pieces(brick, corner, scratch);

    // Stable counting sort by cell: triangles stay in ascending order.
    scratch.start.fill(0);
    for (const Piece &piece : scratch.found) ++scratch.start[piece.cell + 1];
    for (int c = 0; c < 512; ++c) scratch.start[c + 1] += scratch.start[c];
    scratch.pieces.resize(scratch.found.size());
    std::array<std::uint32_t, 512> next;
    std::copy_n(scratch.start.begin(), 512, next.begin());
    for (const Piece &piece : scratch.found) scratch.pieces[next[piece.cell]++] = piece;

    for (const std::uint16_t c : order_) {
        const std::span<const Piece> pieces{scratch.pieces.data() + scratch.start[c],
                                            scratch.pieces.data() + scratch.start[c + 1]};
        if (pieces.empty()) continue;
        const Cell cell{corner[0] + (c >> 6), corner[1] + (c >> 3 & 7), corner[2] + (c & 7)};
        const Sides sides = sides_of(pieces);
        for (int s = 0; s < sides.count; ++s) {
            Side side = sides.side[s];
            side.inward = inward(side, pieces, cell);
            ShellPoint p = point(side, cell, out);
            p.brick = static_cast<std::uint32_t>(index);
            p.cell = c;
            out.points.push_back(p);
        }
        ++out.cells;
    }
}

} // namespace

Shell make_shell(const LatticeMesh &mesh, const BrickTriangles &binned, const Cells &cells, ShellKind kind,
                 Progress &progress, double thin_angle)
{
    // Portions do not depend on the number of threads, nor does the order of their sums.
    constexpr std::size_t bricks_per_portion = 32;
    const std::size_t bricks = cells.bricks.size();
    std::vector<Portion> portions((bricks + bricks_per_portion - 1) / bricks_per_portion);
    std::vector<std::uint64_t> first(bricks + 1);
    const Maker maker(mesh, binned, cells, kind);
    tbb::enumerable_thread_specific<Scratch> scratch;
    progress.stage("points", bricks);
    tbb::parallel_for(
        std::size_t{0}, portions.size(),
        [&](std::size_t p) {
            const std::size_t begin = p * bricks_per_portion,
                              end = std::min(bricks, begin + bricks_per_portion);
            for (std::size_t b = begin; b < end; ++b) {
                progress.check();
                first[b] = portions[p].points.size(); // within the portion, for now
                maker.brick(b, scratch.local(), portions[p]);
            }
            progress.advance(end - begin);
        },
        tbb::simple_partitioner());

    Shell shell;
    shell.kind = kind;
    shell.voxel = mesh.voxel;
    std::size_t count = 0;
    for (const Portion &portion : portions) count += portion.points.size();
    if (count > VXS_POINTSHELL_MAX_POINTS)
        throw Failure(ExitCode::requirement, "",
                      fmt::format("{} points, a pointshell holds at most {}: use a larger voxel", count,
                                  static_cast<int>(VXS_POINTSHELL_MAX_POINTS)));
    shell.points.reserve(count);
    for (std::size_t p = 0; p < portions.size(); ++p) {
        progress.check();
        Portion &portion = portions[p];
        const std::size_t end = std::min(bricks, (p + 1) * bricks_per_portion);
        for (std::size_t b = p * bricks_per_portion; b < end; ++b) first[b] += shell.points.size();
        shell.points.insert(shell.points.end(), portion.points.begin(), portion.points.end());
        std::vector<ShellPoint>().swap(portion.points);
        shell.area += portion.area;
        shell.surface_error = std::max(shell.surface_error, portion.surface_error);
        shell.surface_cells += portion.cells;
    }
    first[bricks] = shell.points.size();
    progress.check();
    borrow_normals(shell, cells, first, progress);
    shell.gap_max = gap_max(shell, cells, first, progress);
    if (thin_angle > 0) thin(shell, cells, first, thin_angle, progress);
    cluster(shell, cells, progress);
    return shell;
}

} // namespace voxshell
