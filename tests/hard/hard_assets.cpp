// SPDX-License-Identifier: GPL-3.0-or-later
// The parts of the hard cases on the pipeline's way to assets. Heavy headers stay here.
#include "hard_case.hpp"

#include "pipeline/convert_part.hpp"

#include <cstring>
#include <map>

namespace hard {
namespace {

/// 64-byte aligned, as a mapping is.
std::byte *aligned(std::vector<std::byte> &room, const std::vector<std::uint8_t> &bytes)
{
    room.resize(bytes.size() + 64);
    const std::size_t off = (64 - reinterpret_cast<std::uintptr_t>(room.data()) % 64) % 64;
    std::memcpy(room.data() + off, bytes.data(), bytes.size());
    return room.data() + off;
}

void check(vxs_result result, const std::string &name)
{
    if (result != VXS_OK) throw voxshell::Failure(voxshell::ExitCode::bug, name, vxs_result_text(result));
}

} // namespace

const Asset &asset(const std::string &name, double voxel, const std::function<Mesh()> &mesh)
{
    static std::map<std::string, std::unique_ptr<Asset>> made;
    std::unique_ptr<Asset> &found = made[name];
    if (found) return *found;
    voxshell::Scene scene;
    scene.name = name;
    scene.meshes = {mesh()};
    scene.instances = {{"/" + name, 0}};
    voxshell::PartOptions options;
    options.voxel = voxel;
    options.channels.layers = 4;
    options.channels.distance_cells = 4;
    voxshell::Progress silent;
    const voxshell::Part part = voxshell::convert_part(scene, options, silent);
    found = std::make_unique<Asset>();
    check(vxs_asset_from_memory(aligned(found->map_bytes, part.voxmap), part.voxmap.size(), nullptr,
                                &found->map_file, nullptr),
          name);
    check(vxs_asset_from_memory(aligned(found->shell_bytes, part.pointshell), part.pointshell.size(), nullptr,
                                &found->shell_file, nullptr),
          name);
    check(vxs_voxmap_open(&found->map_file, &found->map), name);
    check(vxs_pointshell_open(&found->shell_file, &found->shell), name);
    found->area = part.mesh.area;
    return *found;
}

} // namespace hard
