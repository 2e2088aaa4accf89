// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/asset_facts.hpp"

#include "cli/asset_kind.hpp"
#include "cli/options.hpp"
#include "container/asset_file.hpp"
#include "plan/plan_facts.hpp"
#include "pointshell/pointshell_file.hpp"

#include "voxshell/coupling.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

std::string format_box(const std::array<double, 3> &size)
{
    const double largest = *std::max_element(size.begin(), size.end());
    const bool small = largest < 1, tiny = largest < 1e-3;
    const double scale = tiny ? 1e6 : small ? 1e3 : 1;
    return fmt::format("{:.6g} x {:.6g} x {:.6g} {}", size[0] * scale, size[1] * scale, size[2] * scale,
                       tiny    ? "um"
                       : small ? "mm"
                               : "m");
}

std::string format_cell(const Cell &cell)
{
    return fmt::format("({}, {}, {})", cell[0], cell[1], cell[2]);
}

/// What the frame of a .voxmap or .pointshell says.
void tell_container(const fs::path &path, AssetFacts &told)
{
    const AssetFile file(path);
    const vxs_container_header &header = file.header();
    told.as_json["format"] = fmt::format("{}.{}", header.version_major, header.version_minor);
    told.as_json["bytes"] = header.file_size;
    told.as_json["source_sha256"] = hex(file.source_hash());
    told.as_json["content_hash"] = hex(file.content_hash());
}

/// A .vdb has neither header nor hashes of ours: the version is OpenVDB's file version, the content hash that
/// of its bytes.
void tell_vdb(const fs::path &path, const Sha256 &source, AssetFacts &told)
{
    std::ifstream file(path, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    if (file.bad() || bytes.size() < 12) throw Failure(ExitCode::system, path.string(), "cannot be read");
    std::uint32_t version = 0;
    std::copy_n(bytes.data() + 8, 4, reinterpret_cast<char *>(&version));
    told.as_json["format"] = std::to_string(version);
    told.as_json["bytes"] = bytes.size();
    told.as_json["source_sha256"] = hex(source);
    told.as_json["content_hash"] =
        hex(sha256({reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size()}));
}

std::string first_line(const fs::path &path, const json &j, const std::array<double, 3> &size,
                       const std::string &counts)
{
    return fmt::format(
        "{}: {} {}, {}, voxel {}, {}, {}, source {}", path.filename().string(), j["kind"].get<std::string>(),
        j["format"].get<std::string>(), format_box(size), format_length(j["voxel_m"].get<double>()), counts,
        format_size(j["bytes"].get<std::uint64_t>()), j["source_sha256"].get<std::string>().substr(0, 12));
}

void tell_hashes(AssetFacts &told, const std::string &meta)
{
    told.rows.push_back({"source", told.as_json["source_sha256"].get<std::string>()});
    told.rows.push_back({"content", told.as_json["content_hash"].get<std::string>()});
    told.rows.push_back({"meta", meta});
}

AssetFacts inspect_cells(const fs::path &path, AssetKind kind)
{
    const VoxmapFile file = read_cells(path, kind);
    const Cells &cells = file.cells;
    AssetFacts told;
    told.as_json["kind"] = name_of(kind);
    if (kind == AssetKind::voxmap)
        tell_container(path, told);
    else
        tell_vdb(path, file.source_hash, told);
    told.as_json["voxel_m"] = cells.voxel;
    told.as_json["bbox_cells"] = {{"min", cells.min}, {"max", cells.max}};
    told.as_json["surface_cells"] = cells.surface_cells;
    told.as_json["interior_cells"] = cells.interior_cells;
    const std::vector<std::string> channels = channel_names(file.channels);
    told.as_json["channels"] = channels;

    std::array<double, 3> size{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        size[axis] = static_cast<double>(cells.max[axis] - cells.min[axis] + 1) * cells.voxel;
    told.first = first_line(path, told.as_json, size,
                            fmt::format("{} surface and {} interior cells", format_count(cells.surface_cells),
                                        format_count(cells.interior_cells)));
    told.rows = {
        {"unit", "metres, +Y up"},
        {"cells", format_cell(cells.min) + " to " + format_cell(cells.max)},
        {"mesh", cells.closed ? "closed" : "open"},
        {"bricks", fmt::format("{} of 8 x 8 x 8 cells, {} solid runs", format_count(cells.bricks.size()),
                               format_count(cells.solid.size()))}};
    told.rows.push_back(
        {"channels", channels.empty() ? "none" : fmt::format("{}", fmt::join(channels, ", "))});
    tell_hashes(told, file.meta);
    return told;
}

AssetFacts inspect_shell(const fs::path &path)
{
    const PointshellFile file = read_pointshell(path);
    const Shell &shell = file.shell;
    AssetFacts told;
    told.as_json["kind"] = "pointshell";
    tell_container(path, told);
    const char *kind = shell.kind == ShellKind::exact ? "exact" : "naive";
    told.as_json["voxel_m"] = shell.voxel;
    told.as_json["kind_of_shell"] = kind;
    told.as_json["points"] = shell.points.size();
    told.as_json["area_m2"] = shell.area;
    told.as_json["areas"] = file.areas;
    told.as_json["gap_max_m"] = shell.gap_max;
    told.as_json["surface_error_max_m"] = shell.surface_error;
    told.as_json["clusters"] = shell.clusters.size();

    std::array<double, 3> low{}, high{}, size{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = high[axis] = shell.points.empty() ? 0 : double{shell.points[0].position[axis]};
        for (const ShellPoint &point : shell.points) {
            low[axis] = std::min(low[axis], double{point.position[axis]});
            high[axis] = std::max(high[axis], double{point.position[axis]});
        }
        size[axis] = high[axis] - low[axis];
    }
    told.first = first_line(path, told.as_json, size,
                            fmt::format("{} {} points", format_count(shell.points.size()), kind));
    told.rows = {
        {"unit", "metres, +Y up"},
        {"box", fmt::format("({:.9g}, {:.9g}, {:.9g}) to ({:.9g}, {:.9g}, {:.9g}) m", low[0], low[1], low[2],
                            high[0], high[1], high[2])},
        {"cells", format_count(shell.surface_cells) + " with at least one point"},
        {"area", fmt::format("{:.9g} m2{}", shell.area,
                             file.areas ? "" : ", which share is whose is not stored: no weighting area")},
        {"gap",
         fmt::format("{} at most, {:.3f} voxels", format_length(shell.gap_max), shell.gap_max / shell.voxel)},
        {"error", format_length(shell.surface_error) + " off the surface at most"},
        {"clusters", format_count(shell.clusters.size())}};
    tell_hashes(told, file.meta);
    return told;
}

AssetFacts inspect_plan(const fs::path &path)
{
    const PlanFile plan = read_plan(path);
    const vxs_plan_info &info = plan.info;
    AssetFacts told;
    told.as_json["kind"] = "plan";
    tell_container(path, told);
    told.as_json["rate_hz"] = info.rate;
    told.as_json["device"] = text_of(info.device);
    told.as_json["arm"] = text_of(info.arm);
    told.as_json["law"] = law_name(info.law);
    told.as_json["field"] = field_name(info.field);
    told.as_json["weighting"] = weighting_name(info.weighting);
    json coupling = {{"kind", vxs_coupling_kind_name(info.coupling)},
                     {"designed", (info.flags & VXS_PLAN_FLAG_DESIGNED) != 0}};
    for (const auto &[name, value] : {std::pair{"omega0", info.omega0},
                                      {"damping", info.damping},
                                      {"gain", info.gain},
                                      {"stiffness", info.coupling_stiffness},
                                      {"radius", info.radius},
                                      {"mass", info.mass}}) {
        if (value > 0) coupling[name] = value;
    }
    told.as_json["coupling"] = coupling;
    told.as_json["max_force_n"] = info.max_force;
    told.as_json["assets"] = json::array();
    for (const vxs_plan_asset &asset : plan.assets) {
        Sha256 hash;
        std::ranges::copy(asset.content_hash, hash.begin());
        told.as_json["assets"].push_back(
            {{"role", asset.role == VXS_PLAN_ROLE_DYNAMIC ? "dynamic" : "static"},
             {"name", text_of(asset.name)},
             {"content_hash", hex(hash)}});
    }
    told.as_json["effects"] = json::array();
    for (const vxs_plan_effect &effect : plan.effects) {
        told.as_json["effects"].push_back(
            {{"kind", text_of(effect.kind)},
             {"constants", std::vector<double>(effect.constants, effect.constants + effect.constant_count)}});
    }
    told.as_json["hand_keyframes"] = plan.hand.size();
    told.as_json["motion_keyframes"] = plan.moves.size();
    told.first = fmt::format("{}: plan {}, {} at {} Hz, {} effects, {}, source {}", path.filename().string(),
                             told.as_json["format"].get<std::string>(), text_of(info.device), info.rate,
                             plan.effects.size(), format_size(told.as_json["bytes"].get<std::uint64_t>()),
                             told.as_json["source_sha256"].get<std::string>().substr(0, 12));
    for (const PlanFact &fact : plan_facts(plan)) told.rows.push_back({fact.what, fact.value});
    tell_hashes(told, plan.meta);
    return told;
}

} // namespace

AssetFacts asset_facts(const fs::path &path)
{
    const AssetKind kind = asset_kind(path);
    return kind == AssetKind::plan         ? inspect_plan(path)
           : kind == AssetKind::pointshell ? inspect_shell(path)
                                           : inspect_cells(path, kind);
}

} // namespace voxshell
