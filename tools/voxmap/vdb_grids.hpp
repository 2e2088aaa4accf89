// SPDX-License-Identifier: GPL-3.0-or-later
// Cells as OpenVDB's trees: what both writers, .vdb and .nvdb, begin with. Includes OpenVDB: for their
// sources only.
#pragma once

#include "voxmap/channels.hpp"

#include <functional>
#include <openvdb/Grid.h>

namespace voxshell {

/// Grid `state` (Int32), then, where the channels are there, `layer` (Int32) and `distance` (Float, in
/// `unit_metres`). Solid runs are tiles. The transform is left to the caller. Throws Failure(requirement)
/// beyond 32-bit indices. One after another, so that only one has to be there: a tree is larger than its
/// cells and channels. `progress`, if given, is asked whether to go on.
void each_vdb_grid(const Cells &cells, const Channels &channels, double unit_metres,
                   const std::function<void(openvdb::GridBase::Ptr)> &take, Progress *progress = nullptr);

} // namespace voxshell
