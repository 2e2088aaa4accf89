// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/foreseen.hpp"

#include "cli/options.hpp"

#include <fmt/format.h>

#include <cmath>

namespace voxshell {

nlohmann::ordered_json foreseen_json(const std::string &name, const Foreseen &foreseen)
{
    const Estimate &e = foreseen.estimate;
    return {{"name", name},
            {"triangles", foreseen.triangles},
            {"surface_cells", std::llround(e.surface_cells)},
            {"memory_bytes", std::llround(e.memory_bytes)},
            {"file_bytes", std::llround(e.file_bytes)},
            {"voxel_m", foreseen.voxel},
            {"seconds", e.seconds}};
}

void tell_foreseen(const std::string &label, const Foreseen &foreseen)
{
    const Estimate &e = foreseen.estimate;
    if (!foreseen.voxel_why.empty())
        fmt::print("{}: voxel {}: {}\n", label, format_length(foreseen.voxel), foreseen.voxel_why);
    fmt::print("{}: {} triangles, about {:.2g} surface cells, {} of memory, {} of files, {:.2g} s\n", label,
               format_count(foreseen.triangles), e.surface_cells,
               format_size(static_cast<std::uint64_t>(e.memory_bytes)),
               format_size(static_cast<std::uint64_t>(e.file_bytes)), e.seconds);
}

} // namespace voxshell
