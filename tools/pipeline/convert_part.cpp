// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/convert_part.hpp"

#include "cli/options.hpp"
#include "mesh/intersections.hpp"
#include "pipeline/choose_voxel.hpp"
#include "pipeline/estimate.hpp"
#include "pointshell/pointshell_file.hpp"
#include "voxmap/vdb.hpp"
#include "voxmap/voxmap_file.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>
#include <numbers>

namespace voxshell {
namespace {

/// META: what the file was made with, and nothing of when, where, by whom or under which name: the same
/// geometry gives the same bytes.
std::string meta(const PartOptions &options, bool shell)
{
    nlohmann::ordered_json effective = {
        {"voxel_m", options.voxel},
        {"unit_m", options.import.unit ? nlohmann::ordered_json(*options.import.unit) : nullptr},
        {"up", options.import.z_up ? "z" : "y"},
        {"close_gap_m", options.close_gap}};
    if (options.weld > 0) effective["weld_m"] = options.weld;
    if (shell) {
        effective["shell"] = options.shell == ShellKind::exact ? "exact" : "naive";
        if (options.shell_spacing > 0) effective["shell_spacing_m"] = options.shell_spacing;
        if (options.thin_shell > 0) effective["thin_shell_deg"] = options.thin_shell;
    } else {
        if (options.channels.layers > 0) effective["layers"] = options.channels.layers;
        if (options.channels.distance_cells > 0)
            effective["distance_cells"] = options.channels.distance_cells;
    }
    return nlohmann::ordered_json{{"tool", "voxshell"}, {"version", tool_version()}, {"options", effective}}
        .dump();
}

/// Facts about the mesh that a user wants to hear; with --strict, those that call for a guess end the work.
class Judge {
  public:
    Judge(bool strict, std::vector<Warning> &warnings) : strict_(strict), warnings_(warnings) {}

    void tell(const char *code, const std::string &message) { warnings_.push_back({code, message}); }

    void guess(const char *code, const std::string &message)
    {
        if (strict_) throw Failure(ExitCode::requirement, "", message + " (--strict)");
        tell(code, message);
    }

  private:
    bool strict_;
    std::vector<Warning> &warnings_;
};

void judge_mesh(const Part &part, Judge &judge)
{
    const MeshReport &mesh = part.mesh;
    if (mesh.degenerate) judge.tell("degenerate", fmt::format("{} triangles without area", mesh.degenerate));
    if (mesh.duplicate) judge.tell("duplicate", fmt::format("{} triangles occur again", mesh.duplicate));
    if (mesh.non_manifold_edges)
        judge.tell("non-manifold",
                   fmt::format("{} edges are shared by three or more triangles", mesh.non_manifold_edges));
    if (part.self_intersections.value_or(0))
        judge.tell("self-intersecting",
                   fmt::format("{} triangles cut or touch others beside their common edges",
                               *part.self_intersections));
}

void judge_openness(const Part &part, Judge &judge)
{
    if (part.mesh.closed) return;
    if (part.open_on_lattice == 0)
        judge.tell("cracks",
                   fmt::format("cracks: {} boundary edges; all are narrower than voxel/65536 and close there",
                               part.mesh.boundary_edges));
    else
        judge.guess("open-mesh",
                    fmt::format("open mesh: {} boundary edges; where it does not enclose cells there is "
                                "surface only, no interior",
                                part.mesh.boundary_edges));
}

void judge_walls(const Part &part, double size, Judge &judge)
{
    const Thickness &walls = part.thickness;
    const double thin = walls.share_below(wall_of(3, part.voxel));
    if (!walls.meaningful() || thin <= 0.01) return;
    const double wall = walls.quantile(0.01), suits = wall > size * 1e-9 ? voxel_for_wall(wall) : 0;
    judge.guess("thin-walls",
                fmt::format("{:.0f} % of the walls are thinner than three voxels, the thinnest {} at "
                            "({:.6g}, {:.6g}, {:.6g}) m; {}",
                            thin * 100, format_length(walls.thinnest), walls.thinnest_at[0],
                            walls.thinnest_at[1], walls.thinnest_at[2],
                            suits >= smallest_chosen(size)
                                ? fmt::format("--voxel {}mm would do", suits * 1e3)
                                : fmt::format("they run out to nothing, a voxel of {} does not do either",
                                              format_length(smallest_chosen(size)))));
}

void judge_orientation(const OrientReport &orient, Judge &judge)
{
    if (orient.shells_flipped)
        judge.guess("flipped-shells",
                    fmt::format("{} inside-out shells were turned outwards", orient.shells_flipped));
    else if (orient.flipped)
        judge.guess("flipped-triangles",
                    fmt::format("{} wrongly wound triangles were turned outwards", orient.flipped));
}

void judge_shell(const Part &part, Judge &judge)
{
    if (part.gap_max > 3 * part.shell_voxel * (1 + 1e-6))
        judge.tell("gap", fmt::format("points of adjacent cells are up to {:.3f} voxels apart (bound: 3)",
                                      part.gap_max / part.shell_voxel));
    if (part.shell_voxel > part.voxel && part.gap_max > 3 * part.voxel)
        judge.guess(
            "shell-too-coarse",
            fmt::format(
                "points are up to {} apart, more than three voxels of the map ({}): walls thinner than "
                "that could pass between them; use --shell-spacing {} or less",
                format_length(part.gap_max), format_length(part.voxel), format_length(part.voxel)));
}

Shell make_shell(const LatticeMesh &mesh, const PartOptions &options, Progress &progress)
{
    const BrickTriangles binned = bin_triangles(mesh, progress);
    const Cells cells = voxelize(mesh, binned, progress);
    return make_shell(mesh, binned, cells, options.shell, progress,
                      options.thin_shell * std::numbers::pi / 180);
}

// What is looked for without being asked must not be felt; what was asked for must end (minutes).
constexpr std::size_t quick_triangles = 20000;
constexpr std::size_t most_at_once = std::size_t{1} << 27; // flatten() refuses more
constexpr std::uint64_t quick_pairs = 1'000'000, thorough_pairs = 2'000'000'000;

} // namespace

StitchReport stitch_within(Mesh &mesh, double weld)
{
    const double largest = longest_side(mesh) / 100;
    if (weld > largest)
        throw Failure(
            ExitCode::usage, "",
            fmt::format(
                "--weld: {} would change the part itself; at most a hundredth of its longest side, {}",
                format_length(weld), format_length(largest)));
    return stitch(mesh, weld);
}

namespace {

/// `mesh`: all of the scene, of which it needs no more than names, hash and warnings besides.
Part convert(Mesh mesh, const Scene &scene, const PartOptions &wanted, Progress &progress)
{
    PartOptions options = wanted;
    const std::uint64_t budget = options.max_memory ? options.max_memory : machine_memory();
    Part part;
    part.name = scene.name;
    part.warnings = scene.warnings;
    Judge judge(options.strict, part.warnings);

    if (options.voxel > 0) check_budget(mesh, options.voxel, budget, options.channels);
    if (options.shell_spacing > 0) check_budget(mesh, options.shell_spacing, budget, {}, "shell spacing");
    if (options.weld > 0) part.stitch = stitch_within(mesh, options.weld);
    part.mesh = report(mesh);
    if (options.inspect || mesh.triangles.size() <= quick_triangles)
        part.self_intersections =
            self_intersections(mesh, options.inspect ? thorough_pairs : quick_pairs, progress);
    judge_mesh(part, judge);
    progress.check();
    part.orient = orient(mesh);
    judge_orientation(part.orient, judge);
    if (part.orient.flipped || part.orient.shells_flipped) part.mesh.volume = report(mesh).volume;
    progress.check();
    part.thickness = thickness(mesh, progress);
    if (!(options.voxel > 0)) {
        const VoxelChoice choice = choose_voxel(mesh, part.thickness, budget, options.channels);
        options.voxel = choice.voxel;
        part.voxel_why = choice.why;
        check_budget(mesh, options.voxel, budget, options.channels);
    }
    part.voxel = options.voxel;
    part.shell_voxel = options.shell_spacing > 0 ? options.shell_spacing : options.voxel;

    if (options.admit)
        options.admit(estimate(mesh, options.voxel, options.channels, options.shell_spacing).memory_bytes);

    const LatticeMesh lattice = snap(mesh, options.voxel);
    if (!part.mesh.closed) part.open_on_lattice = open_edges(lattice.vertices, lattice.triangles);
    judge_openness(part, judge);
    if (options.stands) judge_walls(part, longest_side(mesh), judge);
    const BrickTriangles binned = bin_triangles(lattice, progress);
    Cells cells = voxelize(lattice, binned, progress);
    std::optional<LatticeMesh> of_shell;
    if (part.shell_voxel != part.voxel) of_shell = snap(mesh, part.shell_voxel);
    const bool channels = options.channels.layers > 0 || options.channels.distance_cells > 0;
    const bool oriented = channels && part.mesh.closed && report(mesh).oriented;
    auto winding = std::make_unique<const WindingNumber>(mesh);
    progress.check();
    part.cells = options.close_gap > 0 ? classify_closing(cells, *winding, options.close_gap, progress)
                                       : classify(cells, *winding, progress);
    if (!channels) winding.reset();
    mesh = {};
    cells.closed = part.mesh.closed;
    if (part.cells.leak) {
        const Leak &leak = *part.cells.leak;
        judge.guess(
            "leak",
            fmt::format(
                "the part leaks: outside cells lie within it (winding number {:.2f}), one at "
                "({:.6g}, {:.6g}, {:.6g}) m; close the hole there, use a larger voxel or --close-gaps",
                leak.winding, leak.at[0], leak.at[1], leak.at[2]));
    }
    Shell shell = of_shell ? make_shell(*of_shell, options, progress)
                           : make_shell(lattice, binned, cells, options.shell, progress,
                                        options.thin_shell * std::numbers::pi / 180);
    of_shell.reset();
    part.surface_cells = cells.surface_cells;
    part.interior_cells = cells.interior_cells;
    part.points = shell.points.size();
    part.gap_max = shell.gap_max;
    part.surface_error = shell.surface_error;
    part.thinning = shell.thinning;
    judge_shell(part, judge);

    VoxmapFile map;
    if (channels) {
        map.channels = make_channels(cells, lattice, binned, *winding, oriented, options.channels, progress);
        winding.reset();
        part.distance_error = map.channels.distance_error;
    }

    progress.stage("write", 3);
    part.pointshell = pointshell_bytes(
        {std::move(shell), scene.source_hash, meta(options, true), options.areas}, &progress);
    shell = {};
    progress.advance(1);
    progress.check();
    const std::string map_meta = meta(options, false);
    part.vdb = vdb_bytes(cells, scene.source_hash, map_meta, map.channels, &progress);
    progress.advance(1);
    progress.check();
    map.cells = std::move(cells);
    map.source_hash = scene.source_hash;
    map.meta = map_meta;
    part.voxmap = voxmap_bytes(std::move(map), &progress);
    progress.advance(1);
    return part;
}

} // namespace

Part convert_part(const Scene &scene, const PartOptions &options, Progress &progress)
{
    progress.stage("mesh", 0);
    return convert(flatten(scene), scene, options, progress);
}

Part convert_part(Scene &&scene, const PartOptions &options, Progress &progress)
{
    progress.stage("mesh", 0);
    Mesh mesh;
    const bool is_flat =
        scene.instances.size() == 1 && scene.meshes.size() == 1 && scene.instances[0].pose == Instance{}.pose;
    if (is_flat && scene.meshes[0].triangles.size() < most_at_once) {
        mesh = std::move(scene.meshes[0]);
        for (Point &p : mesh.vertices)
            for (double &x : p) x += 0.0; // as flatten(): no minus zero
    } else {
        mesh = flatten(scene);
    }
    scene.meshes.clear();
    return convert(std::move(mesh), scene, options, progress);
}

const char *tool_version()
{
    return VOXSHELL_VERSION;
}

} // namespace voxshell
