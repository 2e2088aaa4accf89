// SPDX-License-Identifier: GPL-3.0-or-later
// How far it is from each block of 4 x 4 x 4 cells to a cell of another kind: what lets the servo loop pass
// over most points of a shell without a look-up.
#pragma once

#include "cli/progress.hpp"
#include "voxshell/voxmap.h"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

/// The sections CLRX, CLRV and CLRC of formats/voxmap.md.
struct Clearance {
    using Values =
        std::array<std::int8_t, VXS_VOXMAP_CLEARANCE_BLOCKS>; ///< of a chunk, half cells, k fastest
    std::vector<std::uint32_t> index;                         ///< per root entry
    std::vector<Values> values;
    std::vector<std::int32_t> chunks; ///< per root entry, cells
};

/// A pure function of the cell states in the map's box. `progress`, if given, is asked whether to go on.
Clearance clearance(const vxs_voxmap &map, Progress *progress = nullptr);

} // namespace voxshell
