// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/scene_assets.hpp"

#include "cli/options.hpp"
#include "pipeline/convert_scene.hpp"
#include "pipeline/output.hpp"

#include <fmt/format.h>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

fs::path path_of(const fs::path &folder, const SceneFile &scene, const std::string &ending)
{
    return folder / (scene_name(scene.path) + ending);
}

std::string remedy(const SceneFile &scene, const fs::path &folder)
{
    return fmt::format("; run voxshell convert {} -o {} --force", scene.path.string(), folder.string());
}

std::unique_ptr<AssetFile> open(const fs::path &folder, const SceneFile &scene, const std::string &ending,
                                std::uint32_t kind, const Scene &geometry)
{
    const fs::path path = path_of(folder, scene, ending);
    auto file = std::make_unique<AssetFile>(path, kind);
    if (file->source_hash() != geometry.source_hash) {
        throw Failure(ExitCode::invalid, path.string(),
                      "was made from other files or poses than the scene has now" + remedy(scene, folder));
    }
    return file;
}

void check_voxel(const SceneFile &scene, const fs::path &folder, const std::string &ending, double voxel)
{
    if (voxel != scene.voxel) {
        throw Failure(ExitCode::invalid, path_of(folder, scene, ending).string(),
                      fmt::format("has a voxel of {}, the scene says {}", format_length(voxel),
                                  format_length(scene.voxel)) +
                          remedy(scene, folder));
    }
}

} // namespace

SceneAssets::SceneAssets(const SceneFile &scene, const std::string &given, std::uint64_t max_memory,
                         Progress &progress)
{
    const SceneGeometry geometry = read_geometry(scene);
    fs::path folder = given;
    if (folder.empty()) {
        made_ = std::make_unique<TemporaryFolder>();
        folder = made_->path;
        PartOptions options;
        options.max_memory = max_memory;
        const SceneParts parts = convert_scene(scene, geometry, options, progress);
        Outputs outputs(false);
        outputs.add(folder / (scene_name(scene.path) + ".voxmap"), parts.statics.voxmap);
        outputs.add(folder / (scene_name(scene.path) + ".pointshell"), parts.dynamic.pointshell);
        for (std::size_t n = 0; n < parts.moving.size(); ++n)
            outputs.add(folder / (scene_name(scene.path) + moving_ending(n)), parts.moving[n].voxmap);
        outputs.commit();
    }
    folder_ = folder;
    mass = scene_mass(scene, geometry.dynamic);
    name_ = scene_name(scene.path);
    voxmaps_.push_back(open(folder, scene, ".voxmap", VXS_ASSET_VOXMAP, geometry.statics));
    for (std::size_t n = 0; n < geometry.moving.size(); ++n)
        voxmaps_.push_back(open(folder, scene, moving_ending(n), VXS_ASSET_VOXMAP, geometry.moving[n]));
    pointshell_ = open(folder, scene, ".pointshell", VXS_ASSET_POINTSHELL, geometry.dynamic);
    vxs_voxmap_open(&voxmaps_[0]->asset(), &map);
    vxs_pointshell_open(&pointshell_->asset(), &shell);
    check_voxel(scene, folder, ".voxmap", map.voxel);
    check_voxel(scene, folder, ".pointshell", shell.voxel);
}

std::vector<PlannedAsset> SceneAssets::statics() const
{
    std::vector<PlannedAsset> named;
    for (const auto &file : voxmaps_) {
        named.push_back(
            {name_ + (named.empty() ? ".voxmap" : moving_ending(named.size() - 1)), file->content_hash()});
    }
    return named;
}

PlannedAsset SceneAssets::dynamic() const
{
    return {name_ + ".pointshell", pointshell_->content_hash()};
}

std::vector<vxs_asset> SceneAssets::all() const
{
    std::vector<vxs_asset> open;
    for (const auto &file : voxmaps_) open.push_back(file->asset());
    open.push_back(pointshell_->asset());
    return open;
}

std::vector<fs::path> SceneAssets::paths() const
{
    std::vector<fs::path> paths;
    for (const PlannedAsset &asset : statics()) paths.push_back(folder_ / asset.name);
    paths.push_back(folder_ / dynamic().name);
    return paths;
}

PlanAssets::PlanAssets(const PlanFile &plan, const fs::path &folder)
{
    for (const vxs_plan_asset &asset : plan.assets) {
        const std::uint32_t kind =
            asset.role == VXS_PLAN_ROLE_STATIC ? VXS_ASSET_VOXMAP : VXS_ASSET_POINTSHELL;
        files_.push_back(std::make_unique<AssetFile>(folder / text_of(asset.name), kind));
        open_.push_back(files_.back()->asset());
    }
}

} // namespace voxshell
