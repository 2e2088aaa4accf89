// SPDX-License-Identifier: GPL-3.0-or-later
// Cells as OpenVDB's trees: what both writers, .vdb and .nvdb, begin with. Includes OpenVDB: for their
// sources only.
#pragma once

#include "voxmap/channels.hpp"

#include <openvdb/Grid.h>
#include <vector>

namespace voxshell {

/// Grid `state` (Int32), then, where the channels are there, `layer` (Int32) and `distance` (Float, in
/// `unit_metres`). Solid runs are tiles. The transform is left to the caller. Throws Failure(requirement)
/// beyond 32-bit indices. `progress`, if given, is asked whether to go on.
std::vector<openvdb::GridBase::Ptr> vdb_grids(const Cells &cells, const Channels &channels,
                                              double unit_metres, Progress *progress = nullptr);

} // namespace voxshell
