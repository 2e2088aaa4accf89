// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/choose_voxel.hpp"

#include "cli/options.hpp"
#include "voxshell/format/pointshell.h"

#include <fmt/format.h>

#include <algorithm>

namespace voxshell {

double longest_side(const Mesh &mesh)
{
    if (mesh.triangles.empty()) return 0;
    Point low = mesh.vertices[mesh.triangles[0][0]], high = low;
    for (const Triangle &t : mesh.triangles)
        for (const std::uint32_t v : t)
            for (std::size_t axis = 0; axis < 3; ++axis) {
                low[axis] = std::min(low[axis], mesh.vertices[v][axis]);
                high[axis] = std::max(high[axis], mesh.vertices[v][axis]);
            }
    return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
}

double smallest_chosen(double size)
{
    return round_up_125(size / 2000);
}

VoxelChoice choose_voxel(const Mesh &mesh, const Thickness &thickness, std::uint64_t budget,
                         const ChannelRequest &channels)
{
    const double size = longest_side(mesh);
    if (!(size > 0))
        throw Failure(ExitCode::requirement, "", "no voxel suits a part without size; say --voxel LEN");
    VoxelChoice out;
    if (thickness.meaningful()) {
        const double wall = thickness.quantile(0.01);
        const std::string walls = fmt::format("99 % of the walls are at least {}", format_length(wall));
        const double suits = wall > size * 1e-9 ? voxel_for_wall(wall) : 0, smallest = smallest_chosen(size);
        if (suits >= smallest)
            out = {suits, walls + ", three voxels each"};
        else
            out = {smallest, walls + ", less than three voxels; but the longest side is 2000 voxels at most"};
    } else {
        out = {round_down_125(size / 256),
               "no interior that could be measured; the longest side is at least 256 voxels"};
    }
    const auto fits = [&](double voxel) {
        const Estimate e = estimate(mesh, voxel, channels);
        return e.memory_bytes <= static_cast<double>(budget) &&
               e.surface_cells <= double{VXS_POINTSHELL_MAX_POINTS};
    };
    const double wanted = out.voxel;
    while (!fits(out.voxel) && out.voxel < size) out.voxel = round_up_125(out.voxel * 1.5);
    if (out.voxel != wanted)
        out.why +=
            fmt::format("; {} would need more memory than {}", format_length(wanted), format_size(budget));
    return out;
}

} // namespace voxshell
