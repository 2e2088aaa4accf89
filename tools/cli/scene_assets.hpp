// SPDX-License-Identifier: GPL-3.0-or-later
// A scene's two assets, open: those of a folder if they are this scene's, else made for this run.
#pragma once

#include "cli/progress.hpp"
#include "container/asset_file.hpp"
#include "scene/scene_file.hpp"
#include "study/temporary_folder.hpp"

#include "voxshell/pointshell.h"
#include "voxshell/voxmap.h"

#include <cstdint>
#include <memory>
#include <string>

namespace voxshell {

class SceneAssets {
  public:
    /// folder: with the scene's NAME.voxmap and NAME.pointshell, as convert makes them; empty: made now, with
    /// at most max_memory bytes (0: as convert decides). Throws Failure(invalid) for assets of another scene.
    SceneAssets(const SceneFile &scene, const std::string &folder, std::uint64_t max_memory,
                Progress &progress);

    vxs_voxmap map{};
    vxs_pointshell shell{};

  private:
    std::unique_ptr<TemporaryFolder> made_; // outlives the open files
    std::unique_ptr<AssetFile> voxmap_, pointshell_;
};

} // namespace voxshell
