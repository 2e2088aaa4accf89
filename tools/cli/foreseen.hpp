// SPDX-License-Identifier: GPL-3.0-or-later
// How --dry-run tells what a conversion would take.
#pragma once

#include "pipeline/foresee.hpp"

#include <nlohmann/json.hpp>

namespace voxshell {

/// An item of voxshell-estimate/1.
nlohmann::ordered_json foreseen_json(const std::string &name, const Foreseen &foreseen);

/// A line, or two if the voxel was chosen.
void tell_foreseen(const std::string &label, const Foreseen &foreseen);

} // namespace voxshell
