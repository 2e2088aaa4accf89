// SPDX-License-Identifier: GPL-3.0-or-later
// A scene compiled for a device: all that its servo needs (formats/plan.md).
#pragma once

#include "mesh/mass.hpp"
#include "plan/plan_file.hpp"
#include "plan/scene_coupling.hpp"
#include "scene/scene_file.hpp"

#include <optional>
#include <span>
#include <string>

namespace voxshell {

struct PlannedAsset {
    std::string name; ///< file name
    Sha256 content_hash{};
};

/// device: "sim:NAME". statics: the map of all that stands, then one for each part with a path, in their
/// order. contact: asked where the coupling is to be designed. source_hash and meta are the caller's. Throws
/// Failure: usage (no such device), invalid (with the place in the scene), requirement (a design that is
/// unstable with an arm that counts).
PlanFile scene_plan(const SceneFile &scene, const std::string &device, std::span<const PlannedAsset> statics,
                    const PlannedAsset &dynamic, const SceneContact &contact,
                    const std::optional<MassProperties> &mass);

/// What the object of a scene weighs, if an effect asks: of what moves, in the frame of its shell. Throws as
/// mass_properties().
std::optional<MassProperties> scene_mass(const SceneFile &scene, const Scene &dynamic);

/// All of scene_plan() that no asset is needed for. Throws as it does.
void check_scene(const SceneFile &scene);

/// The hand's path that a plan holds; no keyframe if it holds none.
HandPath hand_of(std::span<const vxs_plan_keyframe> keyframes);

} // namespace voxshell
