// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/run_report.hpp"

#include "cli/convert_extra.hpp"
#include "pipeline/estimate.hpp"

#include <fstream>

namespace voxshell {

using json = nlohmann::ordered_json;

namespace {

json mesh_json(const Part &part)
{
    const MeshReport &mesh = part.mesh;
    const auto or_null = [](const std::optional<std::uint64_t> &count) {
        return count ? json(*count) : json(nullptr);
    };
    return {{"boundary_edges", mesh.boundary_edges},
            {"open_edges_on_lattice", or_null(part.open_on_lattice)},
            {"non_manifold_edges", mesh.non_manifold_edges},
            {"badly_wound_edges", mesh.badly_wound_edges},
            {"shells", mesh.shells},
            {"duplicate", mesh.duplicate},
            {"self_intersections", or_null(part.self_intersections)},
            {"flipped", part.orient.flipped},
            {"shells_flipped", part.orient.shells_flipped},
            {"stitched", part.stitch.vertices},
            {"stitched_max_m", part.stitch.farthest},
            {"stitched_edges", part.stitch.closed_edges}};
}

json thickness_json(const Thickness &walls, double voxel)
{
    if (!walls.meaningful()) return nullptr;
    json below = json::array();
    for (const double voxels : thickness_classes)
        below.push_back({{"voxels", voxels}, {"share", walls.share_below(wall_of(voxels, voxel))}});
    return {{"samples", walls.walls.size()},
            {"q01_m", walls.quantile(0.01)},
            {"q05_m", walls.quantile(0.05)},
            {"q50_m", walls.quantile(0.5)},
            {"thinnest_m", walls.thinnest},
            {"thinnest_at_m", walls.thinnest_at},
            {"below", below}};
}

} // namespace

RunReport::RunReport(bool reproducible)
    : reproducible_(reproducible), json_({{"schema", "voxshell-report/1"},
                                          {"version", tool_version()},
                                          {"options", json::object()},
                                          {"inputs", json::array()},
                                          {"parts", json::array()},
                                          {"outputs", json::array()},
                                          {"warnings", json::array()},
                                          {"failed", json::array()}})
{
}

std::string RunReport::shown(const std::filesystem::path &path) const
{
    return reproducible_ ? path.filename().string() : path.string();
}

void RunReport::options(json effective)
{
    json_["options"] = std::move(effective);
}

void RunReport::input(const std::filesystem::path &path, const Sha256 &hash)
{
    json_["inputs"].push_back({{"path", shown(path)}, {"sha256", hex(hash)}});
}

json part_json(const Part &part, double voxel)
{
    json leak = nullptr;
    if (part.cells.leak)
        leak = {{"at_m", part.cells.leak->at},
                {"winding", part.cells.leak->winding},
                {"cells", part.cells.leak->cells}};
    json out = {{"name", part.name},
                {"triangles", part.mesh.triangles},
                {"degenerate", part.mesh.degenerate},
                {"closed", part.mesh.closed},
                {"oriented", part.mesh.oriented},
                {"area_m2", part.mesh.area},
                {"volume_m3", part.mesh.volume},
                {"surface_cells", part.surface_cells},
                {"interior_cells", part.interior_cells},
                {"points", part.points},
                {"gap_max_h", part.gap_max / part.shell_voxel},
                {"surface_error_max_m", part.surface_error},
                {"leak", leak},
                {"voxel_m", voxel},
                {"mesh", mesh_json(part)},
                {"thickness", thickness_json(part.thickness, voxel)}};
    out.update(extra_json(part));
    return out;
}

void RunReport::part(const Part &part, double voxel)
{
    json_["parts"].push_back(part_json(part, voxel));
}

void RunReport::output(const std::filesystem::path &path, std::span<const std::uint8_t> bytes)
{
    json_["outputs"].push_back(
        {{"path", shown(path)}, {"bytes", bytes.size()}, {"sha256", hex(sha256(bytes))}});
}

void RunReport::warning(const Warning &warning)
{
    json_["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
}

void RunReport::failed(const std::filesystem::path &path, const Failure &failure)
{
    json_["failed"].push_back(
        {{"path", shown(path)}, {"code", static_cast<int>(failure.code)}, {"message", failure.what()}});
}

std::string RunReport::text() const
{
    json out = json_;
    if (!reproducible_) {
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin_;
        out["cost"] = {{"seconds", spent.count()}, {"peak_rss_bytes", peak_memory()}};
    }
    return json_text(out);
}

void write_report(const std::filesystem::path &path, bool force,
                  const std::function<void(const Outputs::Sink &)> &write)
{
    std::error_code ignored;
    if (!force && std::filesystem::is_regular_file(path, ignored)) {
        std::ifstream file(path, std::ios::binary);
        std::string head(64, '\0');
        file.read(head.data(), static_cast<std::streamsize>(head.size()));
        force = head.find("\"schema\": \"voxshell-report/") != std::string::npos;
    }
    Outputs outputs(force);
    outputs.add_stream(path, write);
    outputs.commit();
}

std::string json_text(const json &value)
{
    return value.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

} // namespace voxshell
