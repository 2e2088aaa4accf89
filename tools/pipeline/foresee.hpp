// SPDX-License-Identifier: GPL-3.0-or-later
// What convert_part() would do, without doing it.
#pragma once

#include "pipeline/convert_part.hpp"
#include "pipeline/estimate.hpp"

namespace voxshell {

struct Foreseen {
    std::uint64_t triangles = 0;
    double voxel = 0;      ///< [m]
    std::string voxel_why; ///< if it was chosen here
    Estimate estimate;
};

/// Throws Failure as convert_part() would where the mesh alone is the reason: memory, --weld.
Foreseen foresee(const Scene &scene, const PartOptions &options, Progress &progress);

} // namespace voxshell
