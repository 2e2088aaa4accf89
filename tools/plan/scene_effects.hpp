// SPDX-License-Identifier: GPL-3.0-or-later
// The effects of a scene on a device: what the scene leaves open is as the device or the part has it, else as
// by default.
#pragma once

#include "mesh/mass.hpp"
#include "scene/scene_file.hpp"

#include "voxshell/device.h"

#include <vector>

namespace voxshell {

/// What the constants of effects can depend on besides the scene file.
struct EffectContext {
    const vxs_device_caps &caps;
    const MassProperties *mass; ///< of what moves, where the scene says its density; else null
};

/// In order of execution, each with all its constants; torque where the device renders it. Throws
/// Failure(invalid) with the place for what the device or the runtime refuses.
std::vector<vxs_effect> scene_effects(const SceneFile &scene, const EffectContext &context);

/// Whether an effect would take its mass from the object.
bool asks_for_mass(const SceneFile &scene);

/// How far from the surface effects look into the distance channel [m]; 0: none does.
double distance_reach(const SceneFile &scene);

} // namespace voxshell
