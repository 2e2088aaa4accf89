// SPDX-License-Identifier: GPL-3.0-or-later
// What both kinds of scene file say alike: one reader for .scene.json and for the extras of a glTF.
#pragma once

#include "scene/json_place.hpp"
#include "scene/scene_file.hpp"

namespace voxshell {

/// All but "static" and "dynamic", which in a glTF are nodes.
inline constexpr std::string_view scene_keys[] = {"scene",   "voxel",  "contact", "coupling", "guards",
                                                  "effects", "device", "arm",     "rate",     "hand"};

/// The values of scene_keys; "hand" only where it is there.
void read_keys(const JsonObject &object, SceneFile &scene);

double read_density(const JsonPlace &at);

/// A path is what asks for the effect motion; the list of effects may say more of it.
void ask_for_motion(const JsonPlace &statics, SceneFile &scene);

/// scene_gltf.cpp
SceneFile read_gltf_scene(const std::filesystem::path &path);

} // namespace voxshell
