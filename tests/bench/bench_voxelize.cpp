// SPDX-License-Identifier: GPL-3.0-or-later
// How long the voxmap of the cup takes: bench_voxelize MODE CELLS [RUNS], MODE surface | solid | distance.
// One line of JSON per run, so that a script can put it beside a peer's (voxelize.py).
#include "cup.hpp"

#include "voxmap/channels.hpp"
#include "voxmap/classify.hpp"

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fmt/core.h>
#include <sys/resource.h>

using namespace voxshell;

int main(int argc, char **argv)
{
    const char *mode = argc > 1 ? argv[1] : "solid";
    const int cells_long = argc > 2 ? std::atoi(argv[2]) : 1024, runs = argc > 3 ? std::atoi(argv[3]) : 3;
    const Mesh mesh = bench_cup();
    Progress silent;
    for (int run = 0; run < runs; ++run) {
        const auto start = std::chrono::steady_clock::now();
        const LatticeMesh lattice = snap(mesh, 0.090 / cells_long);
        const BrickTriangles binned = bin_triangles(lattice, silent);
        Cells cells = voxelize(lattice, binned, silent);
        if (std::strcmp(mode, "surface") != 0) {
            const WindingNumber winding(mesh);
            classify(cells, winding, silent);
            if (std::strcmp(mode, "distance") == 0)
                make_channels(cells, lattice, binned, winding, true, {0, 3}, silent);
        }
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        rusage used{};
        getrusage(RUSAGE_SELF, &used);
        fmt::print("{{\"what\":\"voxshell "
                   "{}\",\"cells\":{},\"triangles\":{},\"seconds\":{:.4f},\"surface\":{},\"interior\":{},"
                   "\"peak_mib\":{}}}\n",
                   mode, cells_long, mesh.triangles.size(), seconds, cells.surface_cells,
                   cells.interior_cells, used.ru_maxrss / 1024);
    }
}
