// SPDX-License-Identifier: GPL-3.0-or-later
// What convert and batch may be told about a part.
#pragma once

#include "cli/convert_extra.hpp"
#include "cli/options.hpp"

namespace voxshell {

struct PartChoice : ExtraOptions {
    std::string up = "y", shell = "exact";
    double voxel = 0;        ///< [m]; 0: not given, or chosen
    bool voxel_auto = false; ///< --voxel auto
    double close_gap = 0;    ///< [m]
    double weld = 0;         ///< [m]
    bool inspect_mesh = false;
    std::string depfile; ///< of no influence on a result
};

void add_part_options(CLI::App &verb, PartChoice &choice);

/// Throws Failure(usage) for what contradicts itself.
PartOptions part_options(const PartChoice &choice, const SharedOptions &shared);

/// Members of the report's `options`.
nlohmann::ordered_json part_options_json(const PartChoice &choice, const SharedOptions &shared);

} // namespace voxshell
