// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/verify_asset.hpp"

#include "cli/failure.hpp"
#include "cli/options.hpp"
#include "container/asset_file.hpp"
#include "plan/plan_file.hpp"
#include "pointshell/pointshell_file.hpp"
#include "voxmap/clearance.hpp"
#include "voxmap/planes.hpp"
#include "voxmap/vdb.hpp"
#include "voxmap/voxmap_file.hpp"

#include "voxshell/effect.h"

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <iterator>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

std::string cells_text(const Cells &cells)
{
    return fmt::format("{} surface, {} interior cells of {}", format_count(cells.surface_cells),
                       format_count(cells.interior_cells), format_length(cells.voxel));
}

bool begins_like_vdb(const fs::path &path)
{
    std::ifstream file(path, std::ios::binary);
    char magic[4] = {};
    return file.read(magic, sizeof magic) && std::string_view(magic, sizeof magic) == " BDV";
}

void verify_clearance(const fs::path &path, const AssetFile &file)
{
    vxs_voxmap map;
    if (vxs_voxmap_open(&file.asset(), &map) != VXS_OK)
        throw Failure(ExitCode::bug, path.string(), "a checked voxmap has no view");
    if (!map.clearance_index) return;
    const Clearance right = clearance(map);
    if (!std::equal(right.index.begin(), right.index.end(), map.clearance_index) ||
        right.values.size() != map.clearance_count ||
        !std::equal(right.values.begin(), right.values.end(),
                    reinterpret_cast<const Clearance::Values *>(map.clearance)) ||
        !std::equal(right.chunks.begin(), right.chunks.end(), map.clearance_chunks))
        throw Failure(ExitCode::invalid, path.string(),
                      "CLRX, CLRV, CLRC: the clearance is not that of the cells; convert the part again");
    if (!map.planes) return;
    const std::vector<ChunkPlanes> right_planes = planes(map);
    if (std::memcmp(right_planes.data(), map.planes, right_planes.size() * sizeof(ChunkPlanes)) != 0)
        throw Failure(ExitCode::invalid, path.string(),
                      "CLRP: the planes are not those of the cells; convert the part again");
}

VerifiedAsset verify_plan(const fs::path &path, const AssetFile &file)
{
    const PlanFile plan = read_plan(path);
    for (const vxs_plan_effect &each : plan.effects) {
        const std::string name = text_of(each.kind);
        vxs_effect effect;
        std::uint32_t known = 0;
        vxs_effect_constants(vxs_effect_kind_named(name.c_str()), &known);
        if (vxs_effect_default(vxs_effect_kind_named(name.c_str()), &effect) != VXS_OK ||
            each.constant_count > known)
            throw Failure(ExitCode::unsupported, path.string(),
                          "this build does not know its effect " + name);
        std::copy_n(each.constants, each.constant_count, effect.as.constants);
        const vxs_effect_keyframe somewhere{0, vxs_pose_identity(), 0, 0};
        if (effect.kind == VXS_EFFECT_MOTION) { // its keyframes passed the rules of MOVE
            effect.keyframes = &somewhere;
            effect.keyframe_count = 1;
        }
        if (vxs_effect_check(&effect) != VXS_OK)
            throw Failure(ExitCode::invalid, path.string(),
                          "a constant of its effect " + name + " is out of range");
    }
    std::size_t beside = 0;
    for (const vxs_plan_asset &each : plan.assets) {
        const fs::path asset = path.parent_path() / text_of(each.name);
        if (!fs::exists(asset)) continue;
        Sha256 wanted;
        std::ranges::copy(each.content_hash, wanted.begin());
        const Sha256 found = AssetFile(asset).content_hash();
        if (found != wanted)
            throw Failure(ExitCode::invalid, path.string(),
                          fmt::format("was made for {} with content {}, beside it is one with {}",
                                      asset.filename().string(), hex(wanted), hex(found)));
        ++beside;
    }
    return {"plan",
            fmt::format("1.{}, {} effects, {} of {} assets beside it", file.header().version_minor,
                        plan.effects.size(), beside, plan.assets.size()),
            file.header().file_size};
}

VerifiedAsset verify_vdb(const fs::path &path)
{
    const VdbFile vdb = read_vdb(path);
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    if (file.bad()) throw Failure(ExitCode::system, path.string(), "cannot be read");
    if (!vdb_uuid_matches({reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size()}))
        throw Failure(ExitCode::invalid, path.string(),
                      "its UUID is not that of its content: damaged, or saved by another program (then "
                      "voxshell pack reads it)");
    return {"vdb", cells_text(vdb.cells), bytes.size()};
}

} // namespace

VerifiedAsset verify_asset(const fs::path &path)
{
    if (begins_like_vdb(path) || path.extension() == ".vdb") return verify_vdb(path);
    const AssetFile file(path);
    const vxs_container_header &header = file.header();
    const std::string version = fmt::format("{}.{}", header.version_major, header.version_minor);
    if (file.asset().kind == VXS_ASSET_PLAN) return verify_plan(path, file);
    if (file.asset().kind == VXS_ASSET_VOXMAP) verify_clearance(path, file);
    if (file.asset().kind == VXS_ASSET_VOXMAP)
        return {"voxmap", version + ", " + cells_text(read_voxmap(path).cells), header.file_size};
    const Shell shell = read_pointshell(path).shell;
    return {"pointshell",
            fmt::format("{}, {} {} points in {} clusters, voxel {}, gap at most {:.3f} voxels", version,
                        format_count(shell.points.size()), shell.kind == ShellKind::exact ? "exact" : "naive",
                        format_count(shell.clusters.size()), format_length(shell.voxel),
                        shell.gap_max / shell.voxel),
            header.file_size};
}

std::vector<fs::path> assets_in(const fs::path &folder)
{
    std::vector<fs::path> found;
    for (const fs::directory_entry &entry : fs::recursive_directory_iterator(folder)) {
        const std::string ending = entry.path().extension().string();
        if ((ending == ".vdb" || ending == ".voxmap" || ending == ".pointshell" || ending == ".plan") &&
            !entry.is_directory())
            found.push_back(entry.path());
    }
    if (found.empty())
        throw Failure(ExitCode::invalid, folder.string(), "holds no .vdb, .voxmap, .pointshell or .plan");
    std::sort(found.begin(), found.end());
    return found;
}

void verify_twins(const fs::path &vdb, const fs::path &voxmap)
{
    const VdbFile a = read_vdb(vdb);
    VoxmapFile b = read_voxmap(voxmap);
    const auto differ = [&](const std::string &what) {
        throw Failure(
            ExitCode::invalid, vdb.string(),
            fmt::format("{} than {} beside it: make one from the other with voxshell pack or export", what,
                        voxmap.filename().string()));
    };
    if (a.source_hash != b.source_hash) differ("comes from another source");
    VoxmapFile c{a.cells, a.channels, b.source_hash, b.meta, b.clearance};
    if (c.channels.layer.empty() || b.channels.layer.empty()) c.channels.layer = b.channels.layer = {};
    if (c.channels.distance.empty() || b.channels.distance.empty())
        c.channels.distance = b.channels.distance = {};
    if (voxmap_bytes(std::move(b)) != voxmap_bytes(std::move(c))) differ("holds other cells or channels");
}

} // namespace voxshell
