// SPDX-License-Identifier: GPL-3.0-or-later
// A plan for people: all that it says, so that two plans with the same facts are the same.
#pragma once

#include "plan/plan_file.hpp"

#include <string>
#include <vector>

namespace voxshell {

struct PlanFact {
    std::string what, value; ///< "coupling", "pt2, omega0 32 rad/s, ..."; each `what` once
};

std::vector<PlanFact> plan_facts(const PlanFile &plan);

/// Names of the numbers in vxs_plan_info, as the scene file writes them.
const char *law_name(std::uint32_t law);
const char *field_name(std::uint32_t field);
const char *weighting_name(std::uint32_t weighting);

} // namespace voxshell
