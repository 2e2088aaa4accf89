// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/estimate.hpp"

#include "cli/options.hpp"
#include "pipeline/pieces.hpp"
#include "voxshell/format/pointshell.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include <sys/resource.h>
#include <unistd.h>

namespace voxshell {
namespace {

/// What of the mesh the estimate depends on, so that many voxel sizes can be tried.
struct Extent {
    double area = 0; ///< sum of |x| + |y| + |z| of the triangles' area vectors [m^2]
    double edge = 0; ///< sum over triangles of half the 1-norm of their edges [m]
    double span = 0; ///< largest extent of the box [m]
    double triangles = 0, vertices = 0;
    Point size{}; ///< of the box [m]
    Pieces pieces;
};

Extent extent(const Mesh &mesh)
{
    Extent out{.pieces = Pieces(mesh)};
    Point low = mesh.vertices.empty() ? Point{} : mesh.vertices[0], high = low;
    for (const Point &p : mesh.vertices)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        out.size[axis] = high[axis] - low[axis];
        out.span = std::max(out.span, out.size[axis]);
    }
    for (const Triangle &t : mesh.triangles) {
        const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        double u[3], v[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            u[axis] = b[axis] - a[axis];
            v[axis] = c[axis] - a[axis];
            out.edge += (std::abs(u[axis]) + std::abs(v[axis]) + std::abs(c[axis] - b[axis])) / 2;
        }
        out.area += (std::abs(u[1] * v[2] - u[2] * v[1]) + std::abs(u[2] * v[0] - u[0] * v[2]) +
                     std::abs(u[0] * v[1] - u[1] * v[0])) /
                    2;
    }
    out.triangles = static_cast<double>(mesh.triangles.size());
    out.vertices = static_cast<double>(mesh.vertices.size());
    return out;
}

Estimate estimate(const Extent &e, double voxel, const ChannelRequest &channels)
{
    const double brick = 8 * voxel;
    Estimate out;
    const double faces = std::max(e.area / (voxel * voxel), e.span / voxel) + 1; // cells
    out.surface_cells = faces + e.pieces.cubes(voxel);
    out.pairs = e.area / (brick * brick) + e.edge / brick + e.triangles;
    const double bricks = std::min(out.pairs, faces / 32 + 1 + e.pieces.cubes(brick));
    // Chunks of 64 cells, and those around them, which have a clearance too. Those of faces are in the figure
    // a cell.
    const double chunk = 64 * voxel, chunks = e.pieces.cubes(chunk);
    const double around =
        std::min(27 * chunks, (e.size[0] / chunk + 2) * (e.size[1] / chunk + 2) * (e.size[2] / chunk + 2));
    // Measured on parts of 10 to 10^6 triangles and 10^3 to 10^7 cells, where the peak was 110 to 155 bytes a
    // cell with its share of a brick, rounded up. The program itself, its libraries and two threads take 46
    // MiB.
    out.memory_bytes = 60e6 + 400 * e.triangles + 150 * e.vertices + 64 * out.pairs +
                       125 * out.surface_cells + 2048 * bricks + 8192 * chunks + 12288 * around;
    out.file_bytes = 8192 + 34 * out.surface_cells + 400 * bricks;
    out.seconds = 0.03 + 6e-6 * e.triangles + 2e-6 * out.pairs + 3e-6 * out.surface_cells;
    const bool layers = channels.layers > 0, distance = channels.distance_cells > 0;
    // The bricks within a channel's reach: a wall's layer of them and what its sides reach, what is round its
    // edges and corners; and no more than there are in the widened box.
    const double reach = std::max<double>(channels.layers, channels.distance_cells);
    double speaking = (0.85 + 0.32 * reach) * bricks, box = 1;
    if (reach > 0) speaking += 8 * std::pow(reach / 8, 3) * e.pieces.cubes(reach * voxel);
    for (const double size : e.size) box *= size / brick + 2 + reach / 4;
    speaking = std::min(speaking, box);
    out.memory_bytes += speaking * 7200 * (layers + distance);
    out.file_bytes += speaking * (1000 * layers + 3000 * distance);
    out.seconds += speaking * (3e-6 * layers + (1e-4 + 2.5e-7 * reach * out.pairs / bricks) * distance);
    return out;
}

bool fits(const Estimate &e, double budget)
{
    return e.memory_bytes <= budget && e.surface_cells <= double{VXS_POINTSHELL_MAX_POINTS};
}

} // namespace

Estimate estimate(const Mesh &mesh, double voxel, const ChannelRequest &channels)
{
    return estimate(extent(mesh), voxel, channels);
}

Estimate estimate(const Mesh &mesh, double voxel, const ChannelRequest &channels, double shell_spacing)
{
    const Extent e = extent(mesh);
    Estimate out = estimate(e, voxel, channels);
    if (!(shell_spacing > 0) || shell_spacing == voxel) return out;
    const Estimate shell = estimate(e, shell_spacing, {});
    out.memory_bytes = std::max(out.memory_bytes, shell.memory_bytes);
    out.file_bytes += 29 * (shell.surface_cells - out.surface_cells); // bytes of a point
    out.seconds += shell.seconds;
    return out;
}

void check_budget(const Mesh &mesh, double voxel, std::uint64_t budget, const ChannelRequest &channels,
                  const char *length)
{
    const Extent e = extent(mesh);
    const Estimate need = estimate(e, voxel, channels);
    const double limit = static_cast<double>(budget);
    if (fits(need, limit)) return;
    double low = voxel, high = voxel; // fits at `high`
    while (!fits(estimate(e, high, channels), limit) && high < 1e9) high *= 2;
    const std::string what = fmt::format("{} {} makes about {:.2g} surface cells and needs about {:.1f} "
                                         "GiB of memory, {:.1f} GiB are allowed",
                                         length, format_length(voxel), need.surface_cells,
                                         need.memory_bytes / (1 << 30), limit / (1 << 30));
    if (high >= 1e9)
        throw Failure(ExitCode::requirement, "",
                      what + "; no " + length + " is large enough, raise --max-memory");
    for (int step = 0; step < 40; ++step) {
        const double middle = std::sqrt(low * high);
        (fits(estimate(e, middle, channels), limit) ? high : low) = middle;
    }
    const double unit = std::pow(10.0, std::floor(std::log10(high)) - 1); // two digits, rounded up
    throw Failure(ExitCode::requirement, "",
                  what + "; the smallest " + length + " that fits is " +
                      format_length(std::ceil(high / unit) * unit));
}

std::uint64_t machine_memory()
{
    std::uint64_t bytes = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES)) *
                          static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    rlimit limit = {};
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        bytes = std::min<std::uint64_t>(bytes, limit.rlim_cur);
    return bytes;
}

std::uint64_t peak_memory()
{
    // getrusage() would tell what the parent had, if that was more: it outlives exec.
    std::ifstream status("/proc/self/status");
    std::string word;
    std::uint64_t kilobytes = 0;
    while (status >> word)
        if (word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024;
    rusage usage = {};
    getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

} // namespace voxshell
