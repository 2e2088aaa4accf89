// SPDX-License-Identifier: GPL-3.0-or-later
// How long the exact shell of the cup takes: bench_pointshell CELLS [RUNS] [FILE.stl [UNIT_M]], or that of
// another part. One line of JSON per run; the last line tells how large the clusters' spheres are, in voxels.
#include "cup.hpp"

#include "import/scene.hpp"
#include "pipeline/estimate.hpp"
#include "pointshell/shell.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>

using namespace voxshell;

namespace {

Mesh part(int argc, char **argv)
{
    if (argc <= 3) return bench_cup();
    ImportOptions import;
    import.unit = argc > 4 ? std::atof(argv[4]) : 1e-3;
    return flatten(import_scene(argv[3], import));
}

double longest_side(const Mesh &mesh)
{
    double most = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto by_axis = [axis](const Point &a, const Point &b) { return a[axis] < b[axis]; };
        const auto [low, high] = std::minmax_element(mesh.vertices.begin(), mesh.vertices.end(), by_axis);
        most = std::max(most, (*high)[axis] - (*low)[axis]);
    }
    return most;
}

} // namespace

int main(int argc, char **argv)
{
    const int cells_long = argc > 1 ? std::atoi(argv[1]) : 1024, runs = argc > 2 ? std::atoi(argv[2]) : 3;
    const Mesh mesh = part(argc, argv);
    Progress silent;
    const LatticeMesh lattice = snap(mesh, longest_side(mesh) / cells_long);
    const BrickTriangles binned = bin_triangles(lattice, silent);
    const Cells cells = voxelize(lattice, binned, silent);
    Shell shell;
    for (int run = 0; run < runs; ++run) {
        shell = {};
        const auto start = std::chrono::steady_clock::now();
        const std::clock_t busy = std::clock();
        shell = make_shell(lattice, binned, cells, ShellKind::exact, silent);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        const double cpu = static_cast<double>(std::clock() - busy) / CLOCKS_PER_SEC;
        const double points = static_cast<double>(shell.points.size());
        fmt::print("{{\"what\":\"voxshell pointshell\",\"cells\":{},\"triangles\":{},\"seconds\":{:.4f},"
                   "\"cpu_seconds\":{:.4f},\"points\":{},\"points_per_second\":{:.0f},\"peak_mib\":{}}}\n",
                   cells_long, mesh.triangles.size(), seconds, cpu, shell.points.size(), points / seconds,
                   peak_memory() >> 20);
    }
    std::vector<double> radius;
    for (const Cluster &c : shell.clusters) radius.push_back(static_cast<double>(c.radius) / lattice.voxel);
    std::sort(radius.begin(), radius.end());
    double sum = 0, volume = 0;
    for (const double r : radius) sum += r, volume += r * r * r;
    const auto n = static_cast<double>(radius.size());
    const auto at = [&](double share) { return radius[static_cast<std::size_t>(share * (n - 1))]; };
    fmt::print(
        "{{\"what\":\"cluster radii\",\"clusters\":{},\"mean_h\":{:.3f},\"rms3_h\":{:.3f},\"p10_h\":{:.3f},"
        "\"p50_h\":{:.3f},\"p90_h\":{:.3f},\"p99_h\":{:.3f},\"max_h\":{:.3f}}}\n",
        radius.size(), sum / n, std::cbrt(volume / n), at(0.1), at(0.5), at(0.9), at(0.99), radius.back());
}
