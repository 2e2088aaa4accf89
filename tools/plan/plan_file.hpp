// SPDX-License-Identifier: GPL-3.0-or-later
// Plan <-> .plan bytes (formats/plan.md).
#pragma once

#include "container/container.hpp"

#include "voxshell/format/plan.h"

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell {

struct PlanFile {
    vxs_plan_info info{};
    std::vector<vxs_plan_asset> assets;   ///< statics, then the dynamic
    std::vector<vxs_plan_effect> effects; ///< in order of execution
    std::vector<vxs_plan_keyframe> hand;
    std::vector<vxs_plan_motion> moves; ///< of statics; with an effect `motion`
    Sha256 source_hash{};
    std::string meta = "{}"; ///< the META section's JSON text
};

/// Throws Failure(invalid) with the rule for a plan that breaks one.
std::vector<std::uint8_t> plan_bytes(const PlanFile &file);

/// Throws as AssetFile does.
PlanFile read_plan(const std::filesystem::path &path);

/// A text into a field that zeros fill. Throws Failure(invalid) if it is too long.
void put_text(std::span<std::uint8_t> field, std::string_view text);
std::string text_of(std::span<const std::uint8_t> field);

} // namespace voxshell
