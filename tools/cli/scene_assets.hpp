// SPDX-License-Identifier: GPL-3.0-or-later
// A scene's two assets, open: those of a folder if they are this scene's, else made for this run. And those
// that a plan names.
#pragma once

#include "cli/progress.hpp"
#include "container/asset_file.hpp"
#include "plan/scene_plan.hpp"
#include "scene/scene_file.hpp"
#include "study/temporary_folder.hpp"

#include "voxshell/pointshell.h"
#include "voxshell/voxmap.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace voxshell {

class SceneAssets {
  public:
    /// folder: with the scene's NAME.voxmap and NAME.pointshell, as convert makes them; empty: made now, with
    /// at most max_memory bytes (0: as convert decides). Throws Failure(invalid) for assets of another scene.
    SceneAssets(const SceneFile &scene, const std::string &folder, std::uint64_t max_memory,
                Progress &progress);

    vxs_voxmap map{};
    vxs_pointshell shell{};
    std::optional<MassProperties> mass;        ///< scene_mass()
    std::vector<PlannedAsset> statics() const; ///< as scene_plan() takes them
    PlannedAsset dynamic() const;
    std::vector<vxs_asset> all() const; ///< statics, then the dynamic: a plan's order
    std::vector<std::filesystem::path> paths() const; ///< in the same order, while this lives

  private:
    std::unique_ptr<TemporaryFolder> made_; // outlives the open files
    std::filesystem::path folder_;
    std::string name_;
    std::vector<std::unique_ptr<AssetFile>> voxmaps_; ///< of what stands, then of each part with a path
    std::unique_ptr<AssetFile> pointshell_;
};

/// The files that a plan names, in its order.
class PlanAssets {
  public:
    /// Throws as AssetFile.
    PlanAssets(const PlanFile &plan, const std::filesystem::path &folder);
    std::span<const vxs_asset> all() const { return open_; }

  private:
    std::vector<std::unique_ptr<AssetFile>> files_;
    std::vector<vxs_asset> open_; ///< views of files_
};

} // namespace voxshell
