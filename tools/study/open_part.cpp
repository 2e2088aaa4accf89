// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/open_part.hpp"

#include <cstring>

namespace voxshell {
namespace {

Part converted(const std::string &name, const Mesh &mesh, const PartOptions &options, Progress &progress)
{
    Scene scene;
    scene.name = name;
    scene.meshes = {mesh};
    scene.instances = {{"/" + name, 0}};
    return convert_part(scene, options, progress);
}

void check(vxs_result result, const std::string &name)
{
    if (result != VXS_OK) throw Failure(ExitCode::bug, name, vxs_result_text(result));
}

} // namespace

OpenPart::OpenPart(const std::string &name, const Mesh &mesh, const PartOptions &options, Progress &progress)
    : OpenPart(converted(name, mesh, options, progress))
{
}

OpenPart::OpenPart(const Part &part)
    : area(part.mesh.area), map_bytes_(part.voxmap.size()), shell_bytes_(part.pointshell.size())
{
    const auto open = [&](const std::vector<std::uint8_t> &bytes, const Memory &room, vxs_asset &asset) {
        std::memcpy(room.get(), bytes.data(), bytes.size());
        check(vxs_asset_from_memory(room.get(), bytes.size(), nullptr, &asset, nullptr), part.name);
    };
    open(part.voxmap, map_bytes_, map_file_);
    open(part.pointshell, shell_bytes_, shell_file_);
    check(vxs_voxmap_open(&map_file_, &map), part.name);
    check(vxs_pointshell_open(&shell_file_, &shell), part.name);
}

OpenPart::~OpenPart()
{
    vxs_asset_close(&map_file_);
    vxs_asset_close(&shell_file_);
}

} // namespace voxshell
