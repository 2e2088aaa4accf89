// SPDX-License-Identifier: GPL-3.0-or-later
// Whole parts against exact arithmetic: every cell of the box, and every shell point, with CGAL's rational
// numbers.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "exact.hpp"
#include "parts.hpp"
#include "pointshell/shell.hpp"

#include <cmath>
#include <cstdio>
#include <map>
#include <set>

using namespace exact;

namespace {

constexpr double cells_long = 24;

using Corners = std::array<LatticePoint, 3>;
using Candidates = std::map<Cell, std::vector<std::uint32_t>>; ///< triangles whose boxes meet a closed cell

Corners corners(const LatticeMesh &mesh, std::uint32_t t)
{
    const Triangle &v = mesh.triangles[t];
    return {mesh.vertices[v[0]], mesh.vertices[v[1]], mesh.vertices[v[2]]};
}

/// Vertices are where the snap promises: within half a lattice unit of the quotient, itself right to a
/// double.
void check_snap(const Mesh &mesh, const LatticeMesh &lattice)
{
    std::uint64_t off = 0;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        for (int a = 0; a < 3; ++a) {
            const Number wanted = Number(mesh.vertices[v][a]) * 65536 / Number(lattice.voxel);
            const Number error = wanted - Number(static_cast<double>(lattice.vertices[v][a]));
            off += error > 0.5000001 || error < -0.5000001;
        }
    CHECK(off == 0);
}

/// Pairs of closed cell and triangle whose boxes meet: no other triangle can have a point in the cell.
Candidates candidates(const LatticeMesh &mesh)
{
    Candidates found;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        const Corners v = corners(mesh, t);
        Cell low, high, c;
        for (int a = 0; a < 3; ++a) {
            low[a] = ((std::min({v[0][a], v[1][a], v[2][a]}) + 65535) >> 16) -
                     1; // a plane belongs to both its cells
            high[a] = std::max({v[0][a], v[1][a], v[2][a]}) >> 16;
        }
        for (c[0] = low[0]; c[0] <= high[0]; ++c[0])
            for (c[1] = low[1]; c[1] <= high[1]; ++c[1])
                for (c[2] = low[2]; c[2] <= high[2]; ++c[2]) found[c].push_back(t);
    }
    return found;
}

Cell upper(const Cell &c)
{
    return corner_of({c[0] + 1, c[1] + 1, c[2] + 1});
}

/// A triangle whose box lies in the half-open cell meets it; the others are clipped.
bool holds_a_point(const LatticeMesh &mesh, const std::vector<std::uint32_t> &triangles, const Cell &cell,
                   std::uint64_t &pairs)
{
    for (const std::uint32_t t : triangles) {
        const Corners v = corners(mesh, t);
        bool within = true;
        for (const LatticePoint &p : v)
            for (int a = 0; a < 3; ++a) within = within && p[a] >> 16 == cell[a];
        ++pairs;
        if (within || meets(v, corner_of(cell), upper(cell))) return true;
    }
    return false;
}

std::set<Cell> surface_of(const Cells &cells)
{
    std::set<Cell> all;
    for (const Brick &brick : cells.bricks)
        for (int c = 0; c < 512; ++c)
            if (brick.surface[c >> 6] >> (c & 63) & 1)
                all.insert({cells.origin[0] + 8 * brick.at[0] + (c >> 6),
                            cells.origin[1] + 8 * brick.at[1] + (c >> 3 & 7),
                            cells.origin[2] + 8 * brick.at[2] + (c & 7)});
    return all;
}

double value(const Number &x)
{
    return CGAL::to_double(CGAL::exact(x)); // to_double of a lazy number is right to 1e-5 only
}

/// The exact points of one cell, in order of distance from its centre, as far as they are asked for.
class Nearest {
  public:
    Nearest(const LatticeMesh &mesh, const std::vector<std::uint32_t> &triangles, const Cell &cell)
        : cell_(cell)
    {
        for (int a = 0; a < 3; ++a) center_[a] = Number(static_cast<double>(cell[a] * 65536 + 32768));
        for (const std::uint32_t t : triangles) queue_.push_back({least(corners(mesh, t)), corners(mesh, t)});
        std::sort(queue_.begin(), queue_.end(),
                  [](const auto &a, const auto &b) { return a.least < b.least; });
    }

    struct Found {
        Vertex at;
        double distance; ///< [lattice units]
    };
    /// Adds the next triangle that meets the cell; nullptr when there is none within `distance`.
    const Found *more(double distance)
    {
        while (next_ < queue_.size() && std::sqrt(static_cast<double>(queue_[next_].least)) <= distance + 1) {
            const Corners &v = queue_[next_++].corners;
            const std::vector<Vertex> polygon = clip(v, corner_of(cell_), upper(cell_));
            if (!reaches_in(polygon, upper(cell_))) continue; // it touches the closed cell alone
            found_.at = nearest(polygon, center_);
            const Vertex off = minus(found_.at, center_);
            found_.distance = std::sqrt(value(dot(off, off)));
            return &found_;
        }
        return nullptr;
    }

  private:
    /// Square of the distance from the centre to the triangle's box within the cell: no point of it is
    /// nearer.
    std::int64_t least(const Corners &v) const
    {
        std::int64_t sum = 0;
        for (int a = 0; a < 3; ++a) {
            const std::int64_t c = cell_[a] * 65536 + 32768, low = std::min({v[0][a], v[1][a], v[2][a]}) - c,
                               high = std::max({v[0][a], v[1][a], v[2][a]}) - c,
                               off = std::min<std::int64_t>(std::max({low, -high, std::int64_t{0}}), 32768);
            sum += off * off;
        }
        return sum;
    }

    struct Waiting {
        std::int64_t least;
        Corners corners;
    };
    Cell cell_;
    Vertex center_;
    std::vector<Waiting> queue_;
    std::size_t next_ = 0;
    Found found_;
};

/// Lattice units that rounding to float32 and back may cost a point: one ulp of each coordinate.
double rounding(const ShellPoint &p, double voxel)
{
    double sum = 0;
    for (const float x : p.position) {
        const double ulp =
            static_cast<double>(std::nextafter(std::abs(x), INFINITY) - std::abs(x)) / voxel * 65536;
        sum += ulp * ulp;
    }
    return std::sqrt(sum) + 1e-4; // and of what two edges with equal distances may differ by in double
}

struct Tally {
    std::uint64_t cells = 0, pairs = 0, wrong_cells = 0, points = 0, not_nearest = 0, off_surface = 0,
                  no_point = 0;
    double worst = 0;
};

void check_points(const LatticeMesh &lattice, const Candidates &near, const Cells &cells, const Shell &shell,
                  Tally &tally)
{
    std::map<Cell, std::vector<const ShellPoint *>> of;
    for (const ShellPoint &p : shell.points)
        of[{cells.origin[0] + 8 * cells.bricks[p.brick].at[0] + (p.cell >> 6),
            cells.origin[1] + 8 * cells.bricks[p.brick].at[1] + (p.cell >> 3 & 7),
            cells.origin[2] + 8 * cells.bricks[p.brick].at[2] + (p.cell & 7)}]
            .push_back(&p);
    tally.no_point += of.size() != cells.surface_cells;
    for (const auto &[cell, points] : of) {
        Nearest search(lattice, near.at(cell), cell);
        double least = INFINITY, worst_stored = 0;
        std::vector<double> miss(points.size(), INFINITY), stored;
        for (const ShellPoint *p : points) {
            double sum = 0;
            for (int a = 0; a < 3; ++a) {
                const double off = static_cast<double>(p->position[a]) / lattice.voxel * 65536 -
                                   static_cast<double>(cell[a] * 65536 + 32768);
                sum += off * off;
            }
            stored.push_back(std::sqrt(sum));
            worst_stored = std::max(worst_stored, stored.back());
        }
        while (const auto *found = search.more(std::max(worst_stored, std::min(least, 60000.0)))) {
            least = std::min(least, found->distance);
            for (std::size_t n = 0; n < points.size(); ++n) {
                double sum = 0;
                for (int a = 0; a < 3; ++a) {
                    const double off = static_cast<double>(points[n]->position[a]) / lattice.voxel * 65536 -
                                       value(found->at[a]);
                    sum += off * off;
                }
                miss[n] = std::min(miss[n], std::sqrt(sum));
            }
        }
        // The nearer of a cell's points is the nearest of all triangles; the other one the nearest of its own
        // triangle.
        const std::size_t first =
            static_cast<std::size_t>(std::min_element(stored.begin(), stored.end()) - stored.begin());
        const double slack = rounding(*points[first], lattice.voxel);
        tally.not_nearest += !(std::abs(stored[first] - least) <= slack);
        tally.worst = std::max(tally.worst, std::abs(stored[first] - least) / slack);
        for (std::size_t n = 0; n < points.size(); ++n)
            tally.off_surface += !(miss[n] <= rounding(*points[n], lattice.voxel));
        tally.points += points.size();
    }
}

void check(const std::vector<parts::Part> &all)
{
    Tally sum;
    for (const parts::Part &part : all) {
        CAPTURE(part.name);
        Tally tally;
        Progress silent;
        const LatticeMesh lattice = snap(part.mesh, parts::longest_side(part.mesh) / cells_long);
        check_snap(part.mesh, lattice);
        const BrickTriangles binned = bin_triangles(lattice, silent);
        const Cells cells = voxelize(lattice, binned, silent);
        const Candidates near = candidates(lattice);
        // Cells without a candidate are free without a test; the box is grown by the cells that planes share.
        std::set<Cell> wanted;
        for (const auto &[cell, triangles] : near)
            if (holds_a_point(lattice, triangles, cell, tally.pairs)) wanted.insert(cell);
        const std::set<Cell> got = surface_of(cells);
        for (const Cell &cell : wanted) tally.wrong_cells += !got.contains(cell);
        for (const Cell &cell : got) tally.wrong_cells += !wanted.contains(cell);
        CHECK(tally.wrong_cells == 0);
        CHECK(got.size() == cells.surface_cells);
        check_points(lattice, near, cells, make_shell(lattice, binned, cells, ShellKind::exact, silent),
                     tally);
        CHECK(tally.not_nearest == 0);
        CHECK(tally.off_surface == 0);
        CHECK(tally.no_point == 0);
        sum.cells += wanted.size();
        sum.pairs += tally.pairs;
        sum.points += tally.points;
        sum.worst = std::max(sum.worst, tally.worst);
    }
    std::printf("%zu parts: %llu cells from %llu pairs, %llu points, nearest to %.2f of what float32 costs\n",
                all.size(), static_cast<unsigned long long>(sum.cells),
                static_cast<unsigned long long>(sum.pairs), static_cast<unsigned long long>(sum.points),
                sum.worst);
}

} // namespace

TEST_CASE("hand-made hard solids: no cell and no point differs from exact arithmetic")
{
    check(parts::hand_made());
}

TEST_CASE("every STL file: no cell and no point differs from exact arithmetic")
{
    const std::vector<parts::Part> files = parts::from_data({"hard", "stl"});
    if (files.empty()) std::puts("the shared data are not here: hand-made solids only");
    check(files);
}

int main(int argc, char **argv)
{
    return doctest::Context(argc, argv).run();
}
