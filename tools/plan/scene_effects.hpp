// SPDX-License-Identifier: GPL-3.0-or-later
// The effects of a scene on a device: what the scene leaves open is as the device or the part has it, else as by default.
#pragma once

#include "scene/scene_file.hpp"

#include "voxshell/device.h"

#include <vector>

namespace voxshell {

/// In order of execution, each with all its constants. Throws Failure(invalid) with the place for constants that the runtime
/// refuses on this device.
std::vector<vxs_effect> scene_effects(const SceneFile &scene, const vxs_device_caps &caps);

} // namespace voxshell
