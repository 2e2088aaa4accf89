// SPDX-License-Identifier: GPL-3.0-or-later
// A scene file's way to assets: everything that stands as one collective map, what moves as one shell.
#pragma once

#include "pipeline/convert_part.hpp"
#include "scene/scene_file.hpp"

namespace voxshell {

/// The triangles that a scene file names, posed. Each half is a Scene whose name is the scene's and whose
/// source_hash is the SHA-256 of, for each part in order: the hash of its bytes, its unit [m, 0 for glTF],
/// its up axis (0 y, 1 z), position and rotation, as little-endian doubles, and the name of its node. So
/// assets fit a scene exactly if these do.
struct SceneGeometry {
    Scene statics, dynamic;
    std::vector<Scene> moving; ///< parts with a path, each in its own frame
};

/// Ending of the map of moving part n: ".moving1.voxmap" for 0.
std::string moving_ending(std::size_t n);

SceneGeometry read_geometry(const SceneFile &scene);

struct SceneParts {
    Part statics;             ///< vdb and voxmap are the scene's
    Part dynamic;             ///< pointshell is the scene's
    std::vector<Part> moving; ///< voxmap: of a part with a path
};

/// convert_part() for both halves, with the scene's voxel and the channels that its field and its effects
/// read; named NAME/static and NAME/dynamic. `options` says the rest.
SceneParts convert_scene(const SceneFile &scene, const SceneGeometry &geometry, const PartOptions &options,
                         Progress &progress);

/// The scene's plan for its device and these parts: NAME.plan, for NAME.voxmap and NAME.pointshell beside it.
/// Throws as scene_plan().
std::vector<std::uint8_t> plan_of(const SceneFile &scene, const SceneGeometry &geometry,
                                  const SceneParts &parts);

} // namespace voxshell
