// SPDX-License-Identifier: GPL-3.0-or-later
// Why each byte of a scene's files is there.
#pragma once

#include "scene/scene_file.hpp"

#include <cstdint>
#include <span>
#include <string>

namespace voxshell {

/// A table of an asset's sections on stdout: bytes, and what reads them in a run of this scene.
void explain_asset(const SceneFile &scene, const std::string &name, std::span<const std::uint8_t> bytes);

} // namespace voxshell
