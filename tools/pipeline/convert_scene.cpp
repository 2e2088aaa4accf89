// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/convert_scene.hpp"

#include "container/container.hpp"
#include "plan/memory.hpp"
#include "plan/scene_contact.hpp"
#include "plan/scene_effects.hpp"
#include "plan/scene_plan.hpp"

#include "voxshell/pointshell.h"
#include "voxshell/voxmap.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

namespace voxshell {
namespace {

/// Scene from part, 3 x 4 row-major.
std::array<double, 12> matrix(const Pose &pose)
{
    std::array<double, 12> m{};
    for (std::size_t column = 0; column < 3; ++column) {
        Point axis{};
        axis[column] = 1;
        const Point turned = rotate(pose.rotation, axis);
        for (std::size_t row = 0; row < 3; ++row) {
            m[4 * row + column] = turned[row];
        }
    }
    for (std::size_t row = 0; row < 3; ++row) {
        m[4 * row + 3] = pose.position[row];
    }
    return m;
}

std::array<double, 12> product(const std::array<double, 12> &a, const std::array<double, 12> &b)
{
    std::array<double, 12> m{};
    for (std::size_t row = 0; row < 3; ++row) {
        for (std::size_t column = 0; column < 4; ++column) {
            double sum = column == 3 ? a[4 * row + 3] : 0;
            for (std::size_t n = 0; n < 3; ++n) {
                sum += a[4 * row + n] * b[4 * n + column];
            }
            m[4 * row + column] = sum;
        }
    }
    return m;
}

void update(Sha256Stream &hash, double value)
{
    const auto bits = std::bit_cast<std::uint64_t>(value);
    std::array<std::uint8_t, 8> bytes;
    for (std::size_t n = 0; n < bytes.size(); ++n) {
        bytes[n] = static_cast<std::uint8_t>(bits >> 8 * n);
    }
    hash.update(bytes);
}

/// All parts of one half of a scene as one.
Scene gather(const SceneFile &of, const std::vector<ScenePart> &parts)
{
    Scene all;
    all.name = scene_name(of.path);
    Sha256Stream hash;
    for (const ScenePart &part : parts) {
        Scene scene = import_scene(part.file, part.import);
        hash.update(scene.source_hash);
        update(hash, part.import.unit.value_or(0));
        update(hash, part.import.z_up);
        for (const double x : part.pose.position) {
            update(hash, x);
        }
        for (const double x : part.pose.rotation) {
            update(hash, x);
        }
        const std::string &node = part.import.node;
        hash.update({reinterpret_cast<const std::uint8_t *>(node.data()), node.size()});
        const auto pose = part.stands_as_stored ? scene.stand : matrix(part.pose);
        const auto first = static_cast<std::uint32_t>(all.meshes.size());
        const std::string prefix = fmt::format("/{}:{}", &part - parts.data(), scene.name);
        for (Instance &instance : scene.instances) {
            all.instances.push_back(
                {prefix + instance.name, first + instance.mesh, product(pose, instance.pose), {}});
        }
        std::move(scene.files.begin(), scene.files.end(), std::back_inserter(all.files));
        std::move(scene.meshes.begin(), scene.meshes.end(), std::back_inserter(all.meshes));
        for (const Warning &warning : scene.warnings) {
            if (part.file == of.path && warning.code == "gltf-animations") continue; // they are its paths
            all.warnings.push_back({warning.code, part.file.filename().string() + ": " + warning.message});
        }
    }
    all.source_hash = hash.digest();
    return all;
}

/// An asset that was just made, open in memory of its own.
class Made {
  public:
    explicit Made(const std::vector<std::uint8_t> &bytes) : memory_(bytes.size())
    {
        std::memcpy(memory_.get(), bytes.data(), bytes.size());
        if (vxs_asset_from_memory(memory_.get(), bytes.size(), nullptr, &asset, nullptr) != VXS_OK) {
            throw Failure(ExitCode::bug, "", "an asset that was just made is refused");
        }
    }
    vxs_asset asset{};

  private:
    Memory memory_;
};

/// As its header has it.
PlannedAsset planned(const std::string &name, const std::vector<std::uint8_t> &bytes)
{
    PlannedAsset asset{name, {}};
    std::copy_n(bytes.begin() + offsetof(vxs_container_header, content_hash), asset.content_hash.size(),
                asset.content_hash.begin());
    return asset;
}

} // namespace

std::string moving_ending(std::size_t n)
{
    return fmt::format(".moving{}.voxmap", n + 1);
}

SceneGeometry read_geometry(const SceneFile &scene)
{
    SceneGeometry geometry;
    std::vector<ScenePart> still;
    for (const ScenePart &part : scene.statics) {
        if (part.path.empty())
            still.push_back(part);
        else
            geometry.moving.push_back(gather(scene, {part}));
    }
    geometry.statics = gather(scene, still);
    geometry.dynamic = gather(scene, {scene.dynamic});
    return geometry;
}

SceneParts convert_scene(const SceneFile &scene, const SceneGeometry &geometry, const PartOptions &options,
                         Progress &progress)
{
    PartOptions with_voxel = options;
    with_voxel.voxel = scene.voxel;
    constexpr int reach = 3; // [cells]: deeper than that a hand has lost the wall
    ChannelRequest &channels = with_voxel.channels;
    if (channels.distance_cells == 0) {
        const double looked_at =
            std::ceil(distance_reach(scene) / scene.voxel * (1 + 1e-9)); // never a bit short of it
        if (looked_at > most_distance_cells) {
            throw Failure(ExitCode::invalid, scene.path.string(),
                          fmt::format("/effects: one looks {:g} m far into the distances around a surface, "
                                      "and they reach {} voxels: {:g} m",
                                      distance_reach(scene), most_distance_cells,
                                      most_distance_cells * scene.voxel));
        }
        channels.distance_cells =
            std::max(looked_at, scene.field == ContactField::distance ? double{reach} : 0.0);
    }
    if (scene.field == ContactField::layers && channels.layers == 0) channels.layers = reach;
    PartOptions moving = with_voxel;
    moving.areas = scene.weighting == Weighting::area;
    moving.stands = false;
    moving.channels = {}; // its map is not written, nor is the shell of what stands
    with_voxel.shell_spacing = with_voxel.thin_shell = 0;
    SceneParts parts{convert_part(geometry.statics, with_voxel, progress),
                     convert_part(geometry.dynamic, moving, progress),
                     {}};
    for (const Scene &goes : geometry.moving) {
        parts.moving.push_back(convert_part(goes, with_voxel, progress));
        parts.moving.back().name += fmt::format("/moving{}", parts.moving.size());
    }
    parts.statics.name += "/static";
    parts.dynamic.name += "/dynamic";
    return parts;
}

std::vector<std::uint8_t> plan_of(const SceneFile &scene, const SceneGeometry &geometry,
                                  const SceneParts &parts)
{
    const std::string name = scene_name(scene.path);
    std::optional<Made> voxmap, pointshell; // only where a design feels its way
    vxs_voxmap map{};
    vxs_pointshell shell{};
    const auto open = [&] {
        if (voxmap) return;
        voxmap.emplace(parts.statics.voxmap);
        pointshell.emplace(parts.dynamic.pointshell);
        vxs_voxmap_open(&voxmap->asset, &map);
        vxs_pointshell_open(&pointshell->asset, &shell);
    };
    const SceneContact contact{[&] { return open(), contact_stiffness(scene, map, shell); },
                               [&] { return open(), pushes(scene, map, shell); }};
    std::vector<PlannedAsset> statics{planned(name + ".voxmap", parts.statics.voxmap)};
    for (std::size_t n = 0; n < parts.moving.size(); ++n)
        statics.push_back(planned(name + moving_ending(n), parts.moving[n].voxmap));
    PlanFile plan =
        scene_plan(scene, scene.device, statics, planned(name + ".pointshell", parts.dynamic.pointshell),
                   contact, scene_mass(scene, geometry.dynamic));
    plan.source_hash = scene.source_hash;
    plan.meta =
        nlohmann::ordered_json{{"tool", "voxshell"}, {"version", tool_version()}, {"name", name}}.dump();
    return plan_bytes(plan);
}

} // namespace voxshell
