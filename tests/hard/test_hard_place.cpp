// SPDX-License-Identifier: GPL-3.0-or-later
// The same part at any scale, place and axis rotation has the same cells; what refines converges.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "parts.hpp"
#include "pipeline/convert_part.hpp"
#include "voxmap/voxelize.hpp"

#include <cmath>
#include <cstdio>
#include <limits>

using namespace voxshell;

namespace {

struct States { ///< sorted
    std::vector<Cell> surface, interior;
    bool operator==(const States &) const = default;
};

using Turn = std::function<Cell(const Cell &)>;

/// Every surface and interior cell, each where `turn` takes it.
States states(
    const Cells &cells, const Turn &turn = [](const Cell &c) { return c; })
{
    States out;
    const auto cell = [&](std::int64_t i, std::int64_t j, std::int64_t k, int c) {
        return turn({cells.origin[0] + 8 * i + (c >> 6), cells.origin[1] + 8 * j + (c >> 3 & 7),
                     cells.origin[2] + 8 * k + (c & 7)});
    };
    for (const Brick &b : cells.bricks)
        for (int c = 0; c < 512; ++c) {
            if (b.surface[c >> 6] >> (c & 63) & 1) out.surface.push_back(cell(b.at[0], b.at[1], b.at[2], c));
            if (b.interior[c >> 6] >> (c & 63) & 1)
                out.interior.push_back(cell(b.at[0], b.at[1], b.at[2], c));
        }
    for (const SolidRun &run : cells.solid)
        for (std::int32_t k = run.first; k <= run.last; ++k)
            for (int c = 0; c < 512; ++c) out.interior.push_back(cell(run.i, run.j, k, c));
    std::sort(out.surface.begin(), out.surface.end());
    std::sort(out.interior.begin(), out.interior.end());
    return out;
}

Cells cells_of(const Mesh &mesh, double voxel)
{
    Progress silent;
    const LatticeMesh lattice = snap(mesh, voxel);
    Cells cells = voxelize(lattice, bin_triangles(lattice, silent), silent);
    classify(cells, WindingNumber(mesh), silent);
    return cells;
}

/// The whole way to files: what a user would get.
Part converted(const Mesh &mesh, double voxel, double scale, const Point &place)
{
    Scene scene;
    scene.name = "part";
    scene.meshes = {mesh};
    scene.instances = {{"/part", 0, {scale, 0, 0, place[0], 0, scale, 0, place[1], 0, 0, scale, place[2]}}};
    PartOptions options;
    options.voxel = voxel * scale;
    Progress silent;
    return convert_part(scene, options, silent);
}

void check_same(const Part &a, const Part &b)
{
    CHECK(a.surface_cells == b.surface_cells);
    CHECK(a.interior_cells == b.interior_cells);
    CHECK(a.points == b.points);
    CHECK(a.cells.components == b.cells.components);
    CHECK(a.cells.cavities == b.cells.cavities);
}

std::vector<parts::Part> all_parts()
{
    std::vector<parts::Part> all = parts::hand_made();
    for (parts::Part &part : parts::from_data({"stl"})) all.push_back(std::move(part));
    return all;
}

double power_of_two(double x)
{
    return std::exp2(std::floor(std::log2(x)));
}

/// Coordinates as multiples of 2^-38 of the voxel's own power: a move by 10 km then loses nothing.
Mesh on_a_grid(const Mesh &mesh, double step)
{
    return parts::moved(mesh, [&](const Point &p) {
        return Point{std::nearbyint(p[0] / step) * step, std::nearbyint(p[1] / step) * step,
                     std::nearbyint(p[2] / step) * step};
    });
}

/// The 24 rotations that take axes to axes.
struct Rotation {
    std::array<int, 3> from, sign;
};
std::vector<Rotation> rotations()
{
    std::vector<Rotation> all;
    for (const std::array<int, 3> &from :
         {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}})
        for (int bits = 0; bits < 8; ++bits) {
            const Rotation r{from, {bits & 1 ? -1 : 1, bits & 2 ? -1 : 1, bits & 4 ? -1 : 1}};
            const bool even = (from[1] - from[0] + 3) % 3 == 1;
            if ((r.sign[0] * r.sign[1] * r.sign[2] > 0) == even) all.push_back(r);
        }
    return all;
}

Mesh turned(const Mesh &mesh, const Rotation &r)
{
    return parts::moved(mesh, [&](const Point &p) {
        return Point{r.sign[0] * p[r.from[0]], r.sign[1] * p[r.from[1]], r.sign[2] * p[r.from[2]]};
    });
}

/// Half-open cells turn into half-open ones the other way round: [i, i + 1) becomes (-i - 1, -i].
Turn turn_cells(const Rotation &r)
{
    return [r](const Cell &c) {
        Cell out;
        for (int a = 0; a < 3; ++a) out[a] = r.sign[a] > 0 ? c[r.from[a]] : -c[r.from[a]] - 1;
        return out;
    };
}

/// Slope of log(error) over log(h), least squares.
double slope(const std::vector<double> &h, const std::vector<double> &error)
{
    double x = 0, y = 0, xx = 0, xy = 0;
    for (std::size_t n = 0; n < h.size(); ++n) {
        const double a = std::log(h[n]), b = std::log(error[n]);
        x += a, y += b, xx += a * a, xy += a * b;
    }
    const double count = static_cast<double>(h.size());
    return (count * xy - x * y) / (count * xx - x * x);
}

double snapped_area(const LatticeMesh &lattice)
{
    double sum = 0;
    for (const Triangle &t : lattice.triangles) {
        double u[3], v[3];
        for (int a = 0; a < 3; ++a) {
            u[a] = static_cast<double>(lattice.vertices[t[1]][a] - lattice.vertices[t[0]][a]) / 65536;
            v[a] = static_cast<double>(lattice.vertices[t[2]][a] - lattice.vertices[t[0]][a]) / 65536;
        }
        sum +=
            std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
    }
    return sum * lattice.voxel * lattice.voxel;
}

} // namespace

TEST_CASE("1 um, 1 m, 1 km: the same cells")
{
    for (const parts::Part &part : all_parts()) {
        CAPTURE(part.name);
        const double size = parts::longest_side(part.mesh), h = size / 40.7;
        const States here = states(cells_of(part.mesh, h));
        const Part whole = converted(part.mesh, h, 1, {});
        for (const double target : {1e-6, 1.0, 1e3})
            for (const double scale :
                 {power_of_two(target / size), target / size}) { // exact, and as people scale
                CAPTURE(scale);
                const Mesh scaled = parts::moved(part.mesh, [&](const Point &p) {
                    return Point{p[0] * scale, p[1] * scale, p[2] * scale};
                });
                CHECK(states(cells_of(scaled, h * scale)) == here);
            }
        for (const double target : {1e-6, 1e3})
            check_same(converted(part.mesh, h, power_of_two(target / size), {}), whole);
    }
}

TEST_CASE("moved 10 km by whole cells: the same cells, shifted")
{
    for (const parts::Part &part : all_parts()) {
        CAPTURE(part.name);
        const double h = power_of_two(parts::longest_side(part.mesh) / 40);
        const Mesh near = on_a_grid(part.mesh, 0x1p-38);
        const std::int64_t shift =
            static_cast<std::int64_t>(10000 / h) | 1; // whole cells, but not whole bricks
        const double away = static_cast<double>(shift) * h;
        const Mesh far = parts::moved(near, [&](const Point &p) {
            return Point{p[0] + away, p[1] - away, p[2] + 3 * h};
        });
        const States there = states(cells_of(far, h)), wanted = states(cells_of(near, h), [&](const Cell &c) {
                                                           return Cell{c[0] + shift, c[1] - shift, c[2] + 3};
                                                       });
        CHECK(there == wanted);
        check_same(converted(near, h, 1, {away, -away, 3 * h}), converted(near, h, 1, {}));
    }
}

TEST_CASE("the 24 axis rotations turn the cells of a part without a face on a grid plane")
{
    CHECK(rotations().size() == 24);
    for (const parts::Part &part : all_parts()) {
        CAPTURE(part.name);
        const double h = parts::longest_side(part.mesh) / 23.3;
        const Mesh off_planes = parts::moved(part.mesh, [&](const Point &p) {
            return Point{p[0] + 0.1371 * h, p[1] + 0.2913 * h, p[2] + 0.4197 * h};
        });
        const Cells cells = cells_of(off_planes, h);
        for (const Rotation &r : rotations())
            CHECK(states(cells_of(turned(off_planes, r), h)) == states(cells, turn_cells(r)));
    }
}

TEST_CASE("a face on a grid plane belongs to the cells above it, so a half turn moves it by one")
{
    const double h = 0x1p-6;
    const Mesh cube = solids::box({0, 0, 0}, {4 * h, 4 * h, 4 * h});
    const Cells cells = cells_of(cube, h);
    CHECK(cells.surface_cells == 98); // one layer a wall, cells 0..4: 5^3 - 3^3
    CHECK(cells.min == Cell{0, 0, 0});
    CHECK(cells.max == Cell{4, 4, 4});
    const Rotation half{{0, 1, 2}, {-1, 1, -1}};
    const Cells other = cells_of(turned(cube, half), h);
    CHECK(other.surface_cells == 98);
    CHECK(other.min == Cell{-4, 0, -4}); // turned cells would be -5..-1
    CHECK(other.max == Cell{0, 4, 0});
    CHECK(states(other) != states(cells, turn_cells(half)));
    CHECK(states(other) == states(cells, [&](const Cell &c) {
              const Cell back = turn_cells(half)(c);
              return Cell{back[0] + 1, back[1], back[2] + 1};
          }));
}

TEST_CASE("the cells' volume converges to the mesh's with O(h), the weights' sum is its area")
{
    std::vector<parts::Part> solid;
    for (parts::Part &part : all_parts()) {
        const MeshReport mesh = report(part.mesh);
        // The needle is as thin as what the snap may move a vertex by: its area is the lattice's.
        if (mesh.closed && mesh.oriented && mesh.shells == 1 && mesh.duplicate == 0 && part.name != "needle")
            solid.push_back(std::move(part));
    }
    CHECK(solid.size() >= 3);
    double worst_area = 0, worst_snap = 0;
    for (const parts::Part &part : solid) {
        CAPTURE(part.name);
        const MeshReport mesh = report(part.mesh);
        std::vector<double> hs, errors;
        for (const double cells_long : {33.0, 57.0, 98.0, 170.0}) {
            const double h = parts::longest_side(part.mesh) / cells_long;
            Progress silent;
            const LatticeMesh lattice = snap(part.mesh, h);
            const BrickTriangles binned = bin_triangles(lattice, silent);
            Cells cells = voxelize(lattice, binned, silent);
            classify(cells, WindingNumber(part.mesh), silent);
            const double inner = static_cast<double>(cells.interior_cells) * h * h * h,
                         outer = inner + static_cast<double>(cells.surface_cells) * h * h * h;
            // Interior cells lie in the solid, and interior and surface cells cover it.
            CHECK(inner <= mesh.volume * (1 + 1e-9));
            CHECK(outer >= mesh.volume * (1 - 1e-9));
            hs.push_back(h);
            errors.push_back(outer - mesh.volume);
            const Shell shell = make_shell(lattice, binned, cells, ShellKind::exact, silent);
            double stored = 0;
            for (const ShellPoint &p : shell.points) stored += static_cast<double>(p.area);
            worst_area = std::max(worst_area, std::abs(stored / mesh.area - 1));
            worst_snap = std::max(worst_snap, std::abs(snapped_area(lattice) / mesh.area - 1));
            CAPTURE(h);
            CHECK(std::abs(shell.area / snapped_area(lattice) - 1) < 1e-9);
            CHECK(std::abs(shell.area / mesh.area - 1) < 1e-6);
            CHECK(std::abs(stored / mesh.area - 1) < 1e-6);
        }
        const double order = slope(hs, errors);
        std::printf("%-40s error of the volume ~ h^%.2f, at most %.2f area x h\n", part.name.c_str(), order,
                    errors.back() / (mesh.area * hs.back()));
        for (std::size_t n = 0; n < hs.size(); ++n) CHECK(errors[n] < 2 * mesh.area * hs[n]);
        CHECK(order > 0.7);
    }
    std::printf("area: stored weights off by at most %.2g, of which the snap %.2g\n", worst_area, worst_snap);
}

int main(int argc, char **argv)
{
    if (parts::from_data({"stl"}).empty()) std::puts("the shared data are not here: hand-made solids only");
    return doctest::Context(argc, argv).run();
}
