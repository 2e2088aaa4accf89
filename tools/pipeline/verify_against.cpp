// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/verify_against.hpp"

#include "mesh/orient.hpp"
#include "mesh/report.hpp"
#include "pipeline/triangle_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace voxshell {
namespace {

constexpr std::size_t max_samples = 2'000'000, max_probes = 100'000;

Point between(const Point &a, const Point &b)
{
    return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}

/// Fills in `m` from a figure per place; at(place) tells where. Deterministic: figures are made in parallel,
/// compared in order.
template<typename Figure, typename At>
Measure measure(Measure m, std::size_t places, Progress &progress, Figure figure, At at)
{
    progress.stage(m.what, places);
    std::vector<double> figures(places);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, places, 512),
                      [&](const tbb::blocked_range<std::size_t> &range) {
                          for (std::size_t n = range.begin(); n < range.end(); ++n) figures[n] = figure(n);
                          progress.advance(range.size());
                          progress.check();
                      });
    m.places = places;
    for (std::size_t n = 0; n < places; ++n) {
        if (std::isnan(figures[n])) { // not decidable at this place
            --m.places;
            continue;
        }
        m.beyond += figures[n] > m.bound;
        if (figures[n] <= m.worst) continue;
        m.worst = figures[n];
        m.at = at(n);
    }
    return m;
}

/// Points of the surface: corners, centroids, and on triangles larger than a cell an even spread of more.
std::vector<Point> samples(const Mesh &mesh, double voxel)
{
    std::vector<Point> out;
    const auto corner = [&](const Triangle &t, std::size_t c) -> const Point & {
        return mesh.vertices[t[c]];
    };
    const auto area = [&](const Triangle &t) {
        const Point u = between(corner(t, 0), corner(t, 1)), v = between(corner(t, 0), corner(t, 2));
        return length({u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]}) / 2;
    };
    double total = 0;
    for (const Triangle &t : mesh.triangles) total += area(t);
    const double density =
        std::min(4 / (voxel * voxel), static_cast<double>(max_samples) / std::max(total, 1e-300));
    const std::size_t stride = 1 + 4 * mesh.triangles.size() / max_samples;
    for (std::size_t n = 0; n < mesh.triangles.size(); n += stride) {
        const Triangle &t = mesh.triangles[n];
        const auto add = [&](double u, double v) {
            Point p;
            for (std::size_t a = 0; a < 3; ++a)
                p[a] = corner(t, 0)[a] + u * (corner(t, 1)[a] - corner(t, 0)[a]) +
                       v * (corner(t, 2)[a] - corner(t, 0)[a]);
            out.push_back(p);
        };
        for (std::size_t c = 0; c < 3; ++c) out.push_back(corner(t, c));
        add(1.0 / 3, 1.0 / 3);
        const auto more =
            static_cast<std::size_t>(std::min(density * area(t), static_cast<double>(max_samples)));
        for (std::size_t s = 0; s < more;
             ++s) { // the additive recurrence of the plastic number, folded into the triangle
            double u = 0.5 + 0.7548776662466927 * static_cast<double>(s),
                   v = 0.5 + 0.5698402909980532 * static_cast<double>(s);
            u -= std::floor(u);
            v -= std::floor(v);
            u + v > 1 ? add(1 - u, 1 - v) : add(u, v);
        }
    }
    return out;
}

Cell cell_of(const Point &p, double voxel)
{
    Cell cell;
    for (std::size_t a = 0; a < 3; ++a) cell[a] = static_cast<std::int64_t>(std::floor(p[a] / voxel));
    return cell;
}

Point center_of(const Cell &cell, double voxel)
{
    return {voxel * (static_cast<double>(cell[0]) + 0.5), voxel * (static_cast<double>(cell[1]) + 0.5),
            voxel * (static_cast<double>(cell[2]) + 0.5)};
}

Cell cell_at(const Cells &cells, std::size_t brick, std::size_t c)
{
    const BrickAt &at = cells.bricks[brick].at;
    return {cells.origin[0] + 8 * std::int64_t{at[0]} + static_cast<std::int64_t>(c >> 6),
            cells.origin[1] + 8 * std::int64_t{at[1]} + static_cast<std::int64_t>(c >> 3 & 7),
            cells.origin[2] + 8 * std::int64_t{at[2]} + static_cast<std::int64_t>(c & 7)};
}

std::vector<Cell> surface_cells(const Cells &cells)
{
    std::vector<Cell> out;
    out.reserve(cells.surface_cells);
    for (std::size_t b = 0; b < cells.bricks.size(); ++b)
        for (std::size_t i = 0; i < 8; ++i)
            for (std::uint64_t left = cells.bricks[b].surface[i]; left; left &= left - 1)
                out.push_back(cell_at(cells, b, i << 6 | static_cast<std::size_t>(std::countr_zero(left))));
    return out;
}

/// How far a coordinate may be off: snapped to h/65536, stored in float where `stored`.
double tolerance(const Mesh &mesh, double voxel, bool stored)
{
    double largest = 0;
    for (const Point &p : mesh.vertices)
        for (const double x : p) largest = std::max(largest, std::abs(x));
    return voxel / 65536 + largest * (stored ? 2 * std::numeric_limits<float>::epsilon()
                                             : 64 * std::numeric_limits<double>::epsilon());
}

/// The points by their cells: which are near a place.
class Nearby {
  public:
    explicit Nearby(const Shell &shell) : shell_(shell), order_(shell.points.size())
    {
        cells_.reserve(order_.size());
        for (const ShellPoint &point : shell.points) cells_.push_back(cell_of(position(point), shell.voxel));
        std::iota(order_.begin(), order_.end(), std::size_t{0});
        std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) {
            return cells_[a] != cells_[b] ? cells_[a] < cells_[b] : a < b;
        });
    }
    static Point position(const ShellPoint &p) { return {p.position[0], p.position[1], p.position[2]}; }
    const Cell &cell(std::size_t point) const { return cells_[point]; }

    /// visit(point) for all points in the cells around `at` whose offsets `wanted` accepts.
    template<typename Wanted, typename Visit>
    void around(const Cell &at, Wanted wanted, Visit visit) const
    {
        for (std::int64_t i = -1; i <= 1; ++i)
            for (std::int64_t j = -1; j <= 1; ++j) {
                const Cell row{at[0] + i, at[1] + j, at[2] - 1}; // three cells in a row of the order
                auto found =
                    std::lower_bound(order_.begin(), order_.end(), row,
                                     [&](std::size_t p, const Cell &key) { return cells_[p] < key; });
                for (; found != order_.end() && cells_[*found] <= Cell{row[0], row[1], at[2] + 1}; ++found)
                    if (wanted(std::abs(i) + std::abs(j) + std::abs(cells_[*found][2] - at[2])))
                        visit(*found);
            }
    }

  private:
    const Shell &shell_;
    std::vector<Cell> cells_;
    std::vector<std::size_t> order_;
};

Measure inside_and_outside(const Cells &cells, const std::vector<Cell> &surface, const Mesh &mesh,
                           bool closed, Progress &progress)
{
    Mesh outward = mesh;
    orient(outward);
    const WindingNumber winding(outward);
    const std::size_t stride = 1 + surface.size() / (max_probes / 6), places = surface.size() / stride * 6;
    const auto beside = [&](std::size_t n) {
        Cell cell = surface[n / 6 * stride];
        cell[n % 3] += n % 6 < 3 ? -1 : 1;
        return cell;
    };
    const auto wrong = [&](std::size_t n) {
        const Cell cell = beside(n);
        const int state = cell_state(cells, cell);
        if (state == VXS_CELL_SURFACE) return std::nan("");
        const double depth = std::abs(winding.at(center_of(cell, cells.voxel))) - 0.5;
        return state == VXS_CELL_INTERIOR ? -depth : depth;
    };
    Measure m{
        "winding number on the wrong side of 1/2, cells beside the surface", "1", 0, 0.01, 0, 0, {}, closed};
    return measure(m, places, progress, wrong,
                   [&](std::size_t n) { return center_of(beside(n), cells.voxel); });
}

/// The stored distance of a cell's centre against the tree's; beyond the band only that it is beyond.
Measure distances(const VoxmapFile &file, const TriangleTree &tree, double slack, Progress &progress)
{
    const Channels &channels = file.channels;
    const std::size_t total = 512 * file.cells.bricks.size(),
                      stride = (total / max_probes) | 1; // odd: all places in a brick
    const auto cell = [&](std::size_t n) { return cell_at(file.cells, n * stride / 512, n * stride % 512); };
    const double most = std::round(channels.distance_band / channels.distance_step);
    const auto off = [&](std::size_t n) {
        const int steps = std::abs(int{channels.distance[n * stride / 512][n * stride % 512]});
        const double stored = steps * channels.distance_step,
                     true_one = tree.distance(center_of(cell(n), file.cells.voxel));
        return steps >= most ? std::max(0.0, stored - true_one) : std::abs(stored - true_one);
    };
    return measure(
        {"distance channel against the mesh", "m", 0, channels.distance_error + slack, 0, 0, {}, true},
        (total + stride - 1) / stride, progress, off,
        [&](std::size_t n) { return center_of(cell(n), file.cells.voxel); });
}

/// The stored ring against the nearest surface cell in the Chebyshev metric, looked up cell by cell.
Measure rings(const VoxmapFile &file, Progress &progress)
{
    constexpr std::size_t probes = 5000;
    const int most = file.channels.layer_count + 1;
    const std::size_t total = 512 * file.cells.bricks.size(), stride = (total / probes) | 1;
    const auto cell = [&](std::size_t n) { return cell_at(file.cells, n * stride / 512, n * stride % 512); };
    const auto wrong = [&](std::size_t n) {
        const Cell at = cell(n);
        int nearest = most;
        for (std::int64_t i = -most; i <= most; ++i)
            for (std::int64_t j = -most; j <= most; ++j)
                for (std::int64_t k = -most; k <= most; ++k) {
                    const int ring = static_cast<int>(std::max({std::abs(i), std::abs(j), std::abs(k)}));
                    if (ring < nearest &&
                        cell_state(file.cells, {at[0] + i, at[1] + j, at[2] + k}) == VXS_CELL_SURFACE)
                        nearest = ring;
                }
        return static_cast<double>(
            std::abs(std::abs(int{file.channels.layer[n * stride / 512][n * stride % 512]}) - nearest));
    };
    return measure({"layer channel against the surface cells", "rings", 0, 0, 0, 0, {}, true},
                   (total + stride - 1) / stride, progress, wrong,
                   [&](std::size_t n) { return center_of(cell(n), file.cells.voxel); });
}

/// Whether the normal points to the side where the winding number's magnitude is larger: 0 yes, 1 no.
Measure inwards(const Shell &shell, const Mesh &mesh, bool closed, Progress &progress)
{
    Mesh outward = mesh;
    orient(outward);
    const WindingNumber winding(outward);
    const std::size_t stride = 1 + shell.points.size() / max_probes,
                      places = (shell.points.size() + stride - 1) / stride;
    const auto outwards = [&](std::size_t n) {
        const ShellPoint &point = shell.points[n * stride];
        Point in, out;
        for (std::size_t a = 0; a < 3; ++a) {
            in[a] = double{point.position[a]} + shell.voxel / 64 * double{point.normal[a]};
            out[a] = double{point.position[a]} - shell.voxel / 64 * double{point.normal[a]};
        }
        const double step = std::abs(winding.at(in)) - std::abs(winding.at(out));
        return std::abs(step) < 0.25 ? std::nan("") : step > 0 ? 0.0 : 1.0;
    };
    Measure m{"share of normals that point outwards", "1", 0, 0, 0, 0, {}, closed};
    m = measure(m, places, progress, outwards,
                [&](std::size_t n) { return Nearby::position(shell.points[n * stride]); });
    m.worst = m.places ? static_cast<double>(m.beyond) / static_cast<double>(m.places) : 0;
    m.bound = 0.01;
    return m;
}

} // namespace

std::vector<Measure> verify_cells(const VoxmapFile &file, const Mesh &mesh, const MadeWith &made,
                                  Progress &progress)
{
    std::vector<Measure> out;
    const Cells &cells = file.cells;
    const double h = cells.voxel, slack = tolerance(mesh, h, false) + made.weld;
    const TriangleTree tree(mesh);
    const std::vector<Cell> surface = surface_cells(cells);
    const auto unmet = [&](std::size_t n) {
        Point low = center_of(surface[n], h), high = low;
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] -= h / 2 + slack;
            high[a] += h / 2 + slack;
        }
        return tree.meets(low, high) ? 0.0 : 1.0;
    };
    out.push_back(measure({"surface cells that no triangle meets", "cells", 0, 0, 0, 0, {}, true},
                          surface.size(), progress, unmet,
                          [&](std::size_t n) { return center_of(surface[n], h); }));
    out.back().worst = static_cast<double>(out.back().beyond);

    const std::vector<Point> points = samples(mesh, h);
    const auto outside = [&](std::size_t n) {
        for (int side = 0; side < 8;
             ++side) { // the cell, or its neighbour where the sample is within the snap of a border
            Point p = points[n];
            for (std::size_t a = 0; a < 3; ++a) p[a] += side >> a & 1 ? slack : -slack;
            if (cell_state(cells, cell_of(p, h)) == VXS_CELL_SURFACE) return 0.0;
        }
        return 1.0;
    };
    out.push_back(measure({"samples of the mesh outside surface cells", "samples", 0, 0, 0, 0, {}, true},
                          points.size(), progress, outside, [&](std::size_t n) { return points[n]; }));
    out.back().worst = static_cast<double>(out.back().beyond);
    out.push_back(inside_and_outside(cells, surface, mesh, report(mesh).closed, progress));
    if (!file.channels.distance.empty())
        out.push_back(distances(file, tree, std::sqrt(3.0) * slack, progress));
    if (!file.channels.layer.empty()) out.push_back(rings(file, progress));
    return out;
}

std::vector<Measure> verify_points(const Shell &shell, const Mesh &mesh, const MadeWith &made,
                                   Progress &progress)
{
    std::vector<Measure> out;
    const double h = shell.voxel, slack = std::sqrt(3.0) * (tolerance(mesh, h, true) + made.weld);
    const double reach_of_point =
        std::sqrt(3.0) * h * (made.thinned ? 2 : 1); // the diagonal of what it stands for
    const std::size_t count = shell.points.size();
    const auto place = [&](std::size_t n) { return Nearby::position(shell.points[n]); };
    const MeshReport mesh_report = report(mesh);
    const TriangleTree tree(mesh);
    const double reach = shell.kind == ShellKind::exact ? slack : std::sqrt(3.0) / 2 * h + slack;
    out.push_back(measure(
        {"distance of a point from the mesh", "m", 0, reach, 0, 0, {}, true}, count, progress,
        [&](std::size_t n) { return tree.distance(place(n)); }, place));

    const Nearby nearby(shell);
    const std::vector<Point> points = samples(mesh, h);
    const auto uncovered = [&](std::size_t n) {
        double best = std::numeric_limits<double>::infinity();
        nearby.around(
            cell_of(points[n], h), [](std::int64_t) { return true; },
            [&](std::size_t p) { best = std::min(best, length(between(points[n], place(p)))); });
        return std::min(best, 1e3 * h);
    };
    out.push_back(measure(
        {"distance of the mesh from the nearest point", "m", 0, reach_of_point + slack, 0, 0, {}, true},
        points.size(), progress, uncovered, [&](std::size_t n) { return points[n]; }));

    const auto gap = [&](std::size_t n) {
        double largest = 0;
        nearby.around(
            nearby.cell(n), [](std::int64_t steps) { return steps == 1 || steps == 2; },
            [&](std::size_t p) { largest = std::max(largest, length(between(place(n), place(p)))); });
        return largest;
    };
    out.push_back(measure({"gap between points of adjacent cells", "m", 0, 3 * h + slack, 0, 0, {}, true},
                          count, progress, gap, place));

    const auto unit = [&](std::size_t n) {
        const auto &v = shell.points[n].normal;
        return std::abs(length({v[0], v[1], v[2]}) - 1);
    };
    out.push_back(
        measure({"normals: length less 1", "1", 0, 1e-6, 0, 0, {}, true}, count, progress, unit, place));
    out.push_back(inwards(shell, mesh, mesh_report.closed, progress));

    double area = made.areas ? 0 : shell.area;
    for (const ShellPoint &point : shell.points) area += double{point.area};
    Measure total{"area of all points less that of the mesh",
                  "m^2",
                  std::abs(area - mesh_report.area),
                  1e-3 * mesh_report.area,
                  1,
                  0,
                  {},
                  true};
    total.beyond = !total.holds();
    out.push_back(total);
    return out;
}

} // namespace voxshell
