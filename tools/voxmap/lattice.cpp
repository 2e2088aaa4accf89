// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/lattice.hpp"

#include "voxshell/format/voxmap.h"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>

namespace voxshell {
namespace {

constexpr double max_cells = VXS_VOXMAP_MAX_CELLS, max_root = VXS_VOXMAP_MAX_ROOT,
                 chunk_cells = VXS_VOXMAP_CHUNK_CELLS;

/// The smallest voxel, on a 1-2-5 scale, whose grid the format can hold.
double smallest_voxel(const Point &low, const Point &high, double voxel)
{
    const auto fits = [&](double h) {
        double root = 1;
        for (int a = 0; a < 3; ++a) {
            const double cells = std::floor(high[a] / h) - std::floor(low[a] / h) + 1;
            if (cells > max_cells - 2 * chunk_cells) return false;
            if (std::max(std::abs(low[a]), std::abs(high[a])) / h >= 0x1p44) return false;
            root *= std::floor(cells / chunk_cells) + 2;
        }
        return root <= max_root;
    };
    double decade = std::pow(10.0, std::floor(std::log10(voxel)));
    for (int guard = 0; guard < 400; ++guard, decade *= 10)
        for (const double step : {1.0, 2.0, 5.0})
            if (step * decade > voxel && fits(step * decade)) return step * decade;
    return INFINITY;
}

} // namespace

LatticeMesh snap(const Mesh &mesh, double voxel)
{
    if (!(voxel > 0) || !std::isfinite(voxel))
        throw Failure(ExitCode::usage, "", "the voxel must be a positive length");
    if (mesh.vertices.empty() || mesh.triangles.empty()) throw Failure(ExitCode::invalid, "", "no triangles");

    // Only vertices that a triangle uses span the box: stray ones must not blow it up.
    Point low = mesh.vertices[mesh.triangles[0][0]], high = low;
    for (const Triangle &t : mesh.triangles)
        for (const std::uint32_t v : t)
            for (int a = 0; a < 3; ++a) {
                low[a] = std::min(low[a], mesh.vertices[v][a]);
                high[a] = std::max(high[a], mesh.vertices[v][a]);
            }
    double root = 1;
    bool fits = true;
    for (int a = 0; a < 3; ++a) {
        const double first = std::floor(low[a] / voxel), last = std::floor(high[a] / voxel);
        const double chunks = std::floor(last / chunk_cells) - std::floor(first / chunk_cells) + 1;
        fits =
            fits && std::abs(first) < 0x1p44 && std::abs(last) < 0x1p44 && chunks * chunk_cells <= max_cells;
        root *= chunks;
    }
    if (!fits || !(root <= max_root)) {
        const double size = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
        throw Failure(
            ExitCode::requirement, "",
            fmt::format("a voxel of {:.6g} m makes {:.4g} cells along {:.6g} m, more than a voxmap holds; "
                        "the smallest that fits is --voxel {:.6g}m",
                        voxel, std::ceil(size / voxel), size, smallest_voxel(low, high, voxel)));
    }

    LatticeMesh out;
    out.voxel = voxel;
    out.triangles = mesh.triangles;
    out.vertices.resize(mesh.vertices.size());
    // Divide first: the quotient's error is half an ulp, the scale by 2^16 is exact, and a shift by
    // whole cells keeps ties even. An unused vertex outside the box is parked at the box's corner.
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        for (int a = 0; a < 3; ++a) {
            const double x = std::clamp(mesh.vertices[v][a], low[a], high[a]);
            out.vertices[v][a] =
                static_cast<std::int64_t>(std::nearbyint(x / voxel * static_cast<double>(lattice_per_cell)));
        }
    out.min = {INT64_MAX, INT64_MAX, INT64_MAX};
    out.max = {INT64_MIN, INT64_MIN, INT64_MIN};
    for (const Triangle &t : out.triangles)
        for (const std::uint32_t v : t)
            for (int a = 0; a < 3; ++a) {
                out.min[a] = std::min(out.min[a], out.vertices[v][a] >> lattice_bits);
                out.max[a] = std::max(out.max[a], out.vertices[v][a] >> lattice_bits);
            }
    return out;
}

} // namespace voxshell
