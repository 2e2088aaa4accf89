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

double length(const Point &a)
{
    return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
}

Point between(const Point &a, const Point &b)
{
    return {b[0] - a[0], b[1] - a[1], b[2] - a[2]};
}

/// Fills in `m` from a figure per place; at(place) tells where. Deterministic: figures are made in parallel, compared in order.
template <typename Figure, typename At>
Measure measure(Measure m, std::size_t places, Progress &progress, Figure figure, At at)
{
    progress.stage(m.what, places);
    std::vector<double> figures(places);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, places, 512), [&](const tbb::blocked_range<std::size_t> &range) {
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
    const auto corner = [&](const Triangle &t, std::size_t c) -> const Point & { return mesh.vertices[t[c]]; };
    const auto area = [&](const Triangle &t) {
        const Point u = between(corner(t, 0), corner(t, 1)), v = between(corner(t, 0), corner(t, 2));
        return length({u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]}) / 2;
    };
    double total = 0;
    for (const Triangle &t : mesh.triangles) total += area(t);
    const double density = std::min(4 / (voxel * voxel), static_cast<double>(max_samples) / std::max(total, 1e-300));
    const std::size_t stride = 1 + 4 * mesh.triangles.size() / max_samples;
    for (std::size_t n = 0; n < mesh.triangles.size(); n += stride) {
        const Triangle &t = mesh.triangles[n];
        const auto add = [&](double u, double v) {
            Point p;
            for (std::size_t a = 0; a < 3; ++a)
                p[a] = corner(t, 0)[a] + u * (corner(t, 1)[a] - corner(t, 0)[a]) + v * (corner(t, 2)[a] - corner(t, 0)[a]);
            out.push_back(p);
        };
        for (std::size_t c = 0; c < 3; ++c) out.push_back(corner(t, c));
        add(1.0 / 3, 1.0 / 3);
        const auto more = static_cast<std::size_t>(std::min(density * area(t), static_cast<double>(max_samples)));
        for (std::size_t s = 0; s < more; ++s) { // the additive recurrence of the plastic number, folded into the triangle
            double u = 0.5 + 0.7548776662466927 * static_cast<double>(s), v = 0.5 + 0.5698402909980532 * static_cast<double>(s);
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

std::vector<Cell> surface_cells(const Cells &cells)
{
    std::vector<Cell> out;
    out.reserve(cells.surface_cells);
    for (const Brick &brick : cells.bricks)
        for (std::int64_t i = 0; i < 8; ++i)
            for (std::uint64_t left = brick.surface[static_cast<std::size_t>(i)]; left; left &= left - 1) {
                const int bit = std::countr_zero(left);
                out.push_back({cells.origin[0] + 8 * std::int64_t{brick.at[0]} + i, cells.origin[1] + 8 * std::int64_t{brick.at[1]} + (bit >> 3),
                               cells.origin[2] + 8 * std::int64_t{brick.at[2]} + (bit & 7)});
            }
    return out;
}

/// How far a coordinate may be off: snapped to h/65536, stored in float where `stored`.
double tolerance(const Mesh &mesh, double voxel, bool stored)
{
    double largest = 0;
    for (const Point &p : mesh.vertices)
        for (const double x : p) largest = std::max(largest, std::abs(x));
    return voxel / 65536 + largest * (stored ? 2 * std::numeric_limits<float>::epsilon() : 64 * std::numeric_limits<double>::epsilon());
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
    template <typename Wanted, typename Visit> void around(const Cell &at, Wanted wanted, Visit visit) const
    {
        for (std::int64_t i = -1; i <= 1; ++i)
            for (std::int64_t j = -1; j <= 1; ++j) {
                const Cell row{at[0] + i, at[1] + j, at[2] - 1}; // three cells in a row of the order
                auto found = std::lower_bound(order_.begin(), order_.end(), row, [&](std::size_t p, const Cell &key) { return cells_[p] < key; });
                for (; found != order_.end() && cells_[*found] <= Cell{row[0], row[1], at[2] + 1}; ++found)
                    if (wanted(std::abs(i) + std::abs(j) + std::abs(cells_[*found][2] - at[2]))) visit(*found);
            }
    }

private:
    const Shell &shell_;
    std::vector<Cell> cells_;
    std::vector<std::size_t> order_;
};

Measure inside_and_outside(const Cells &cells, const std::vector<Cell> &surface, const Mesh &mesh, bool closed, Progress &progress)
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
    Measure m{"winding number on the wrong side of 1/2, cells beside the surface", "1", 0, 0.01, 0, 0, {}, closed};
    return measure(m, places, progress, wrong, [&](std::size_t n) { return center_of(beside(n), cells.voxel); });
}

/// Whether the normal points to the side where the winding number's magnitude is larger: 0 yes, 1 no.
Measure inwards(const Shell &shell, const Mesh &mesh, bool closed, Progress &progress)
{
    Mesh outward = mesh;
    orient(outward);
    const WindingNumber winding(outward);
    const std::size_t stride = 1 + shell.points.size() / max_probes, places = (shell.points.size() + stride - 1) / stride;
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
    m = measure(m, places, progress, outwards, [&](std::size_t n) { return Nearby::position(shell.points[n * stride]); });
    m.worst = m.places ? static_cast<double>(m.beyond) / static_cast<double>(m.places) : 0;
    m.bound = 0.01;
    return m;
}

} // namespace

std::vector<Measure> verify_cells(const Cells &cells, const Mesh &mesh, Progress &progress)
{
    std::vector<Measure> out;
    const double h = cells.voxel, slack = tolerance(mesh, h, false);
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
    out.push_back(measure({"surface cells that no triangle meets", "cells", 0, 0, 0, 0, {}, true}, surface.size(), progress, unmet,
                          [&](std::size_t n) { return center_of(surface[n], h); }));
    out.back().worst = static_cast<double>(out.back().beyond);

    const std::vector<Point> points = samples(mesh, h);
    const auto outside = [&](std::size_t n) {
        for (int side = 0; side < 8; ++side) { // the cell, or its neighbour where the sample is within the snap of a border
            Point p = points[n];
            for (std::size_t a = 0; a < 3; ++a) p[a] += side >> a & 1 ? slack : -slack;
            if (cell_state(cells, cell_of(p, h)) == VXS_CELL_SURFACE) return 0.0;
        }
        return 1.0;
    };
    out.push_back(measure({"samples of the mesh outside surface cells", "samples", 0, 0, 0, 0, {}, true}, points.size(), progress, outside,
                          [&](std::size_t n) { return points[n]; }));
    out.back().worst = static_cast<double>(out.back().beyond);
    out.push_back(inside_and_outside(cells, surface, mesh, report(mesh).closed, progress));
    return out;
}

std::vector<Measure> verify_points(const Shell &shell, const Mesh &mesh, Progress &progress)
{
    std::vector<Measure> out;
    const double h = shell.voxel, slack = std::sqrt(3.0) * tolerance(mesh, h, true);
    const std::size_t count = shell.points.size();
    const auto place = [&](std::size_t n) { return Nearby::position(shell.points[n]); };
    const MeshReport mesh_report = report(mesh);
    const TriangleTree tree(mesh);
    const double reach = shell.kind == ShellKind::exact ? slack : std::sqrt(3.0) / 2 * h + slack;
    out.push_back(measure({"distance of a point from the mesh", "m", 0, reach, 0, 0, {}, true}, count, progress,
                          [&](std::size_t n) { return tree.distance(place(n)); }, place));

    const Nearby nearby(shell);
    const std::vector<Point> points = samples(mesh, h);
    const auto uncovered = [&](std::size_t n) {
        double best = std::numeric_limits<double>::infinity();
        nearby.around(cell_of(points[n], h), [](std::int64_t) { return true; },
                      [&](std::size_t p) { best = std::min(best, length(between(points[n], place(p)))); });
        return std::min(best, 1e3 * h);
    };
    out.push_back(measure({"distance of the mesh from the nearest point", "m", 0, std::sqrt(3.0) * h + slack, 0, 0, {}, true}, points.size(),
                          progress, uncovered, [&](std::size_t n) { return points[n]; }));

    const auto gap = [&](std::size_t n) {
        double largest = 0;
        nearby.around(nearby.cell(n), [](std::int64_t steps) { return steps == 1 || steps == 2; },
                      [&](std::size_t p) { largest = std::max(largest, length(between(place(n), place(p)))); });
        return largest;
    };
    out.push_back(measure({"gap between points of adjacent cells", "m", 0, 3 * h + slack, 0, 0, {}, true}, count, progress, gap, place));

    const auto unit = [&](std::size_t n) {
        const auto &v = shell.points[n].normal;
        return std::abs(length({v[0], v[1], v[2]}) - 1);
    };
    out.push_back(measure({"normals: length less 1", "1", 0, 1e-6, 0, 0, {}, true}, count, progress, unit, place));
    out.push_back(inwards(shell, mesh, mesh_report.closed, progress));

    double area = 0;
    for (const ShellPoint &point : shell.points) area += double{point.area};
    Measure total{"area of all points less that of the mesh", "m^2", std::abs(area - mesh_report.area), 1e-3 * mesh_report.area, 1, 0, {}, true};
    total.beyond = !total.holds();
    out.push_back(total);
    return out;
}

} // namespace voxshell
