// SPDX-License-Identifier: GPL-3.0-or-later
// The peer in the same run: OpenVDB on the same cup. bench_voxelize_openvdb MODE CELLS [RUNS] [THREADS],
// MODE level-set (band +-3, as `bench_voxelize distance`) | solid (filled interior, as `bench_voxelize
// solid`).
#include "cup.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fmt/core.h>
#include <sys/resource.h>
#include <tbb/global_control.h>

int main(int argc, char **argv)
{
    const char *mode = argc > 1 ? argv[1] : "solid";
    const int cells_long = argc > 2 ? std::atoi(argv[2]) : 1024, runs = argc > 3 ? std::atoi(argv[3]) : 3,
              threads = argc > 4 ? std::atoi(argv[4]) : 2;
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    openvdb::initialize();
    const voxshell::Mesh mesh = bench_cup();
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    for (const auto &v : mesh.vertices)
        points.emplace_back(static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]));
    for (const auto &t : mesh.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    const auto transform = openvdb::math::Transform::createLinearTransform(0.090 / cells_long);
    for (int run = 0; run < runs; ++run) {
        const auto start = std::chrono::steady_clock::now();
        openvdb::FloatGrid::Ptr grid;
        if (std::strcmp(mode, "solid") == 0)
            grid = openvdb::tools::meshToSignedDistanceField<openvdb::FloatGrid>(
                *transform, points, triangles, {}, 1.0f, std::numeric_limits<float>::max());
        else
            grid = openvdb::tools::meshToLevelSet<openvdb::FloatGrid>(*transform, points, triangles, 3.0f);
        const double seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        rusage used{};
        getrusage(RUSAGE_SELF, &used);
        fmt::print("{{\"what\":\"OpenVDB "
                   "{}\",\"cells\":{},\"triangles\":{},\"seconds\":{:.4f},\"active\":{},\"peak_mib\":{}}}\n",
                   mode, cells_long, mesh.triangles.size(), seconds, grid->activeVoxelCount(),
                   used.ru_maxrss / 1024);
    }
}
