// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/pointshell_file.hpp"

#include "cli/failure.hpp"
#include "container/asset_file.hpp"

#include "voxshell/pointshell.h"

#include <fmt/format.h>

#include <algorithm>

namespace voxshell {
namespace {

constexpr std::size_t round_up(std::size_t count, std::size_t step)
{
    return (count + step - 1) / step * step;
}

/// One coordinate of all points, padded with the last one.
template<typename Get>
Section column(std::uint32_t id, const std::vector<ShellPoint> &points, Get get)
{
    std::vector<float> values(round_up(points.size(), VXS_POINTSHELL_LANES), get(points.back()));
    std::ranges::transform(points, values.begin(), get);
    return make_section(id, sizeof(float), std::span<const float>(values));
}

/// The areas, padded with 0: a point of the padding weighs nothing.
Section area_column(const std::vector<ShellPoint> &points)
{
    std::vector<float> values(round_up(points.size(), VXS_POINTSHELL_LANES), 0.0f);
    std::ranges::transform(points, values.begin(), &ShellPoint::area);
    return make_section(VXS_POINTSHELL_SECTION_AREA, sizeof(float), std::span<const float>(values));
}

std::vector<vxs_pointshell_cluster> cluster_table(const Shell &shell)
{
    std::vector<vxs_pointshell_cluster> table;
    std::size_t first = 0;
    for (const Cluster &c : shell.clusters) {
        const std::size_t count =
            std::min<std::size_t>(VXS_POINTSHELL_CLUSTER_POINTS, shell.points.size() - first);
        if (c.first != first || c.count != count || count == 0)
            throw Failure(ExitCode::bug, "", "the shell's clusters are not runs of 64 points");
        table.push_back({{c.center[0], c.center[1], c.center[2]}, c.radius, c.first, c.count, {0, 0}});
        first += count;
    }
    if (first != shell.points.size())
        throw Failure(ExitCode::bug, "", "the shell's clusters leave points out");
    return table;
}

} // namespace

std::vector<std::uint8_t> pointshell_bytes(const PointshellFile &file, Progress *progress)
{
    const Shell &shell = file.shell;
    const auto &points = shell.points;
    if (points.empty())
        throw Failure(ExitCode::requirement, "", "no point: an empty pointshell is not written");
    if (points.size() > VXS_POINTSHELL_MAX_POINTS)
        throw Failure(ExitCode::requirement, "",
                      fmt::format("{} points, a pointshell holds {}: choose a larger --voxel", points.size(),
                                  static_cast<int>(VXS_POINTSHELL_MAX_POINTS)));
    const auto clusters = cluster_table(shell);

    vxs_pointshell_info info{};
    info.voxel = shell.voxel;
    info.kind = static_cast<std::uint32_t>(shell.kind);
    info.point_count = static_cast<std::uint32_t>(points.size());
    info.padded_count = static_cast<std::uint32_t>(round_up(points.size(), VXS_POINTSHELL_LANES));
    info.cluster_count = static_cast<std::uint32_t>(clusters.size());
    info.area = shell.area;
    info.gap_max = shell.gap_max;
    info.surface_error = shell.surface_error;
    std::ranges::copy(shell.center, info.center);
    info.radius = shell.radius;
    info.surface_cells = shell.surface_cells;

    const std::uint32_t position[3] = {VXS_POINTSHELL_SECTION_POSX, VXS_POINTSHELL_SECTION_POSY,
                                       VXS_POINTSHELL_SECTION_POSZ};
    const std::uint32_t normal[3] = {VXS_POINTSHELL_SECTION_NRMX, VXS_POINTSHELL_SECTION_NRMY,
                                     VXS_POINTSHELL_SECTION_NRMZ};
    std::vector<Section> sections;
    sections.push_back(make_section(VXS_POINTSHELL_SECTION_SHEL, sizeof info,
                                    std::span<const vxs_pointshell_info>(&info, 1)));
    const auto add = [&](std::uint32_t id, auto get) {
        if (progress) progress->check();
        sections.push_back(column(id, points, get));
    };
    for (std::size_t a = 0; a < 3; ++a) add(position[a], [a](const ShellPoint &p) { return p.position[a]; });
    for (std::size_t a = 0; a < 3; ++a) add(normal[a], [a](const ShellPoint &p) { return p.normal[a]; });
    if (file.areas) sections.push_back(area_column(points));
    sections.push_back(make_section(VXS_POINTSHELL_SECTION_CLUS, sizeof(vxs_pointshell_cluster),
                                    std::span<const vxs_pointshell_cluster>(clusters)));
    sections.push_back(make_section(VXS_SECTION_META, 1, std::span<const char>(file.meta)));
    return container_bytes(VXS_POINTSHELL_MAGIC, VXS_POINTSHELL_VERSION_MAJOR, VXS_POINTSHELL_VERSION_MINOR,
                           file.source_hash, std::move(sections), progress,
                           file.areas ? 0 : VXS_POINTSHELL_FEATURE_NO_AREA);
}

PointshellFile read_pointshell(const std::filesystem::path &path)
{
    const AssetFile file(path, VXS_ASSET_POINTSHELL);
    vxs_pointshell view;
    if (vxs_pointshell_open(&file.asset(), &view) != VXS_OK)
        throw Failure(ExitCode::bug, path.string(), "a checked pointshell has no view");

    PointshellFile out;
    Shell &shell = out.shell;
    shell.kind = static_cast<ShellKind>(view.kind);
    shell.voxel = view.voxel;
    shell.points.resize(view.point_count);
    for (std::size_t p = 0; p < shell.points.size(); ++p) {
        shell.points[p] = {.position = {view.x[p], view.y[p], view.z[p]},
                           .normal = {view.nx[p], view.ny[p], view.nz[p]},
                           .area = view.area ? view.area[p] : 0,
                           .brick = 0,
                           .cell = 0};
    }
    for (const vxs_pointshell_cluster &c : std::span(view.clusters, view.cluster_count))
        shell.clusters.push_back({{c.center[0], c.center[1], c.center[2]}, c.radius, c.first, c.count});
    shell.area = view.total_area;
    shell.gap_max = view.gap_max;
    shell.surface_error = view.surface_error;
    std::ranges::copy(view.center, shell.center.begin());
    shell.radius = view.radius;
    const vxs_container_section &shel = file.sections().front();
    shell.surface_cells =
        reinterpret_cast<const vxs_pointshell_info *>(file.bytes_of(shel).data())->surface_cells;
    out.areas = view.area != nullptr;
    out.source_hash = file.source_hash();
    out.meta = file.meta();
    return out;
}

} // namespace voxshell
