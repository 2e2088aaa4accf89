// SPDX-License-Identifier: GPL-3.0-or-later
// --voxel auto: the voxel that the walls of a part ask for.
#pragma once

#include "import/scene.hpp"
#include "mesh/thickness.hpp"
#include "pipeline/estimate.hpp"

#include <cstdint>
#include <string>

namespace voxshell {

struct VoxelChoice {
    double voxel = 0; ///< [m], 1, 2 or 5 times a power of ten
    std::string why;  ///< "99 % of the walls are at least 3 mm, three voxels each"
};

/// Three voxels for the wall that 99 % of the area has (voxel_for_wall()), but not below 1/2000 of the part's
/// longest side and not more cells than `budget` [bytes] holds. Without walls (a sheet, a part full of
/// holes): 1/256 of the longest side. `mesh` is not empty.
VoxelChoice choose_voxel(const Mesh &mesh, const Thickness &thickness, std::uint64_t budget,
                         const ChannelRequest &channels = {});

/// Longest side of the box of the mesh's triangles [m].
double longest_side(const Mesh &mesh);

/// The smallest voxel that choose_voxel() gives a part of this size, memory apart [m].
double smallest_chosen(double longest_side);

} // namespace voxshell
