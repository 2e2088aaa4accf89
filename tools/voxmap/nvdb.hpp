// SPDX-License-Identifier: GPL-3.0-or-later
// Cells -> NanoVDB, for programs on a GPU and for whoever reads cells with PNanoVDB.h alone.
#pragma once

#include "voxmap/channels.hpp"

#include <cstdint>
#include <vector>

namespace voxshell {

/// A .nvdb file, uncompressed: grid `state` (Int32: 0 free, 1 surface, 2 interior, active unless free) and,
/// where the channels are there, `layer` (Int32) and `distance` (Float, [m], a level set if it is signed),
/// with the tiles of the .vdb. Index (i, j, k) is the centre of cell (i, j, k), at h (i + 1/2, j + 1/2, k +
/// 1/2) in metres whatever the voxel. Nodes tell least and greatest value and box; the checksum is over all.
/// The same bytes each time. Throws Failure(requirement) if a cell's index does not fit 32 bits.
std::vector<std::uint8_t> nvdb_bytes(const Cells &cells, const Channels &channels);

} // namespace voxshell
