// SPDX-License-Identifier: GPL-3.0-or-later
// Makes a shell and puts to it what holds of every shell.
#pragma once

#include "pointshell/cluster.hpp"
#include "pointshell/shell.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace voxshell {

struct Made {
    LatticeMesh mesh;
    Cells cells;
    Shell shell;
};

inline Made make(const Mesh &mesh, double voxel, ShellKind kind = ShellKind::exact)
{
    Progress silent;
    Made m;
    m.mesh = snap(mesh, voxel);
    const BrickTriangles binned = bin_triangles(m.mesh, silent);
    m.cells = voxelize(m.mesh, binned, silent);
    m.shell = make_shell(m.mesh, binned, m.cells, kind, silent);
    return m;
}

inline double mesh_area(const LatticeMesh &mesh)
{
    double sum = 0;
    for (const Triangle &t : mesh.triangles) {
        std::array<double, 3> u, v;
        for (int i = 0; i < 3; ++i) {
            u[i] = static_cast<double>(mesh.vertices[t[1]][i] - mesh.vertices[t[0]][i]);
            v[i] = static_cast<double>(mesh.vertices[t[2]][i] - mesh.vertices[t[0]][i]);
        }
        const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
        sum += std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
    }
    const double unit = mesh.voxel / static_cast<double>(lattice_per_cell);
    return sum * unit * unit;
}

inline Cell cell_of(const Made &m, const ShellPoint &p)
{
    const BrickAt &at = m.cells.bricks[p.brick].at;
    return {m.cells.origin[0] + 8 * at[0] + (p.cell >> 6), m.cells.origin[1] + 8 * at[1] + (p.cell >> 3 & 7),
            m.cells.origin[2] + 8 * at[2] + (p.cell & 7)};
}

// What holds of every shell. `floats`: the cells are large against the floats at their place.
inline void check_rules(const Made &m, bool floats = true)
{
    const Shell &s = m.shell;
    const double h = m.mesh.voxel;
    REQUIRE(!s.points.empty());
    CHECK(s.voxel == h);
    CHECK(s.surface_cells == m.cells.surface_cells);
    double area = 0, gap = 0;
    std::map<Cell, std::vector<std::size_t>> of_cell;
    for (std::size_t i = 0; i < s.points.size(); ++i) {
        const ShellPoint &p = s.points[i];
        const Cell cell = cell_of(m, p);
        REQUIRE(cell_state(m.cells, cell) == VXS_CELL_SURFACE);
        of_cell[cell].push_back(i);
        double n2 = 0;
        for (int a = 0; a < 3; ++a) {
            const double x = static_cast<double>(p.position[a]), n = static_cast<double>(p.normal[a]);
            REQUIRE(std::isfinite(x));
            REQUIRE(std::isfinite(n));
            n2 += n * n;
            if (floats) {
                REQUIRE(x >= h * static_cast<double>(cell[a]));
                REQUIRE(x <= h * static_cast<double>(cell[a] + 1));
            }
        }
        REQUIRE(std::abs(std::sqrt(n2) - 1) <= 1e-6);
        REQUIRE(p.area >= 0);
        REQUIRE(!std::signbit(p.area));
        area += static_cast<double>(p.area);
    }
    CHECK(of_cell.size() == s.surface_cells);
    CHECK(std::abs(area - s.area) <= 1e-6 * s.area);
    CHECK(s.area == doctest::Approx(mesh_area(m.mesh)).epsilon(1e-6));

    for (const auto &[cell, points] : of_cell) {
        REQUIRE(points.size() <= 2);
        for (int n = 0; n < 27; ++n) {
            const int d[3] = {n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
            if (std::abs(d[0]) + std::abs(d[1]) + std::abs(d[2]) > 2) continue;
            if (n == 13) continue;
            const auto other = of_cell.find({cell[0] + d[0], cell[1] + d[1], cell[2] + d[2]});
            if (other == of_cell.end()) continue;
            for (const std::size_t p : points)
                for (const std::size_t q : other->second) {
                    double d2 = 0;
                    for (int a = 0; a < 3; ++a)
                        d2 += std::pow(static_cast<double>(s.points[p].position[a]) -
                                           static_cast<double>(s.points[q].position[a]),
                                       2);
                    gap = std::max(gap, std::sqrt(d2));
                }
        }
    }
    CHECK(s.gap_max == doctest::Approx(gap).epsilon(1e-14));
    if (floats) CHECK(s.gap_max <= 3 * h * (1 + 1e-6));

    std::uint32_t first = 0;
    for (const Cluster &c : s.clusters) {
        CHECK(c.first == first);
        CHECK(c.count == std::min<std::size_t>(64, s.points.size() - first));
        for (std::uint32_t i = first; i < first + c.count; ++i) {
            double d[3];
            for (int a = 0; a < 3; ++a)
                d[a] = static_cast<double>(s.points[i].position[a]) - static_cast<double>(c.center[a]);
            REQUIRE((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2] <=
                    static_cast<double>(c.radius) * static_cast<double>(c.radius));
            for (int a = 0; a < 3; ++a) d[a] = static_cast<double>(s.points[i].position[a]) - s.center[a];
            REQUIRE((d[0] * d[0] + d[1] * d[1]) + d[2] * d[2] <= s.radius * s.radius);
        }
        first += c.count;
    }
    CHECK(first == s.points.size());
}

} // namespace voxshell
