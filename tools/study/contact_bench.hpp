// SPDX-License-Identifier: GPL-3.0-or-later
// How long contact takes with given assets on this machine.
#pragma once

#include "cli/progress.hpp"
#include "study/durations.hpp"

#include "voxshell/pointshell.h"
#include "voxshell/voxmap.h"

#include <cstdint>
#include <string>
#include <vector>

namespace voxshell {

struct ContactBench {
    std::string motion; ///< free, grazing, sliding, deep
    std::string field;  ///< states (law average), distance (law gradient)
    std::string mode;   ///< scalar brute, brute, culled, coherent
    std::uint64_t ticks = 0;
    Durations ns;
    double touched = 0; ///< points looked at in a tick, mean
    double hits = 0;    ///< points in contact, mean
};

/// Moves the shell along the map's surface: to random places of it, a random point of the shell against it,
/// and 5 cells along it from there, a tenth of a cell a tick. grazing: half a cell off, sliding: half a cell
/// deep, deep: three cells, free: 20 cells off, where nothing else touches. Field distance only where the map
/// has the channel. Each motion, field and mode: `ticks` of vxs_contact_evaluate(), fewer (100 at least) if
/// they take more than 2 s; a clock's own 20 to 40 ns are in each. The poses are the same on every run.
std::vector<ContactBench> bench_contact(const vxs_voxmap &map, const vxs_pointshell &shell,
                                        std::uint64_t ticks, Progress &progress);

/// What a point costs if all are in contact [s].
double contact_point_cost(const vxs_pointshell &shell);

/// The processor's name, "unknown processor" where the system does not say.
std::string processor_name();

} // namespace voxshell
