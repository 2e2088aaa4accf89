// SPDX-License-Identifier: GPL-3.0-or-later
// For each brick a plane with all cells around that are not free behind it: what lets the servo loop pass
// over points that are next to a surface but do not touch it.
#pragma once

#include "cli/progress.hpp"
#include "voxshell/voxmap.h"

#include <array>
#include <vector>

namespace voxshell {

using ChunkPlanes = std::array<vxs_voxmap_plane, VXS_VOXMAP_CHUNK_ENTRIES>;

/// The section CLRP of formats/voxmap.md: per chunk. A pure function of the cell states in the map's box.
/// `progress`, if given, is asked whether to go on.
std::vector<ChunkPlanes> planes(const vxs_voxmap &map, Progress *progress = nullptr);

} // namespace voxshell
