// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell pack: the .vdb that people edit, or that another program made, to the .voxmap that the runtime
// maps.
#include "cli/asset_kind.hpp"
#include "cli/options.hpp"
#include "cli/verb.hpp"
#include "pipeline/convert_part.hpp"
#include "pipeline/output.hpp"
#include "voxmap/vdb.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <memory>

namespace voxshell {
namespace {

struct PackOptions : SharedOptions {
    std::string input, output;
    ForeignGrid foreign;
};

/// META of a map that another program's grid became.
std::string meta(const ForeignTaken &taken, const PackOptions &o)
{
    nlohmann::ordered_json effective = {{"grid", taken.grid},
                                        {"kind", taken.kind},
                                        {"unit_m", taken.unit},
                                        {"origin_m", taken.origin},
                                        {"moved_m", taken.moved}};
    if (taken.kind == "mask" || taken.kind == "bool grid")
        effective["as"] = o.foreign.as == ForeignGrid::As::surface ? "surface" : "solid";
    return nlohmann::ordered_json{
        {"tool", "voxshell"}, {"version", tool_version()}, {"name", taken.grid}, {"options", effective}}
        .dump();
}

void tell(const ForeignTaken &taken, const std::string &input)
{
    if (taken.moved != std::array<double, 3>{})
        tell_warning("pack", input,
                     {"moved", fmt::format("grid `{}` was moved by ({}, {}, {})", taken.grid,
                                           format_length(taken.moved[0]), format_length(taken.moved[1]),
                                           format_length(taken.moved[2]))});
    if (taken.distance_left_out)
        tell_warning(
            "pack", input,
            {"no-distance",
             fmt::format("the distances of level set `{}` are not at the centres of cells: only cells "
                         "were made of it (--snap moves it by up to half a cell and keeps them)",
                         taken.grid)});
}

ExitCode pack(const PackOptions &o)
{
    const std::filesystem::path input(o.input);
    const std::filesystem::path output = o.output.empty()
                                             ? std::filesystem::path(input).replace_extension(".voxmap")
                                             : std::filesystem::path(o.output);
    if (output.extension() != ".voxmap")
        throw Failure(ExitCode::usage, output.string(),
                      "pack writes .voxmap; for other endings use voxshell export");
    if (asset_kind(input) != AssetKind::vdb)
        throw Failure(ExitCode::usage, input.string(), "pack reads a .vdb");
    const std::unique_ptr<Progress> progress = make_progress(o.progress, o.quiet);
    progress->stage("read", 0);
    VdbFile vdb = read_vdb(input, &o.foreign, progress.get());
    if (vdb.foreign) {
        vdb.meta = meta(*vdb.foreign, o);
        if (!o.quiet) tell(*vdb.foreign, o.input);
    }
    VoxmapFile file;
    file.cells = std::move(vdb.cells);
    file.channels = std::move(vdb.channels);
    file.source_hash = vdb.source_hash;
    file.meta = std::move(vdb.meta);
    const std::uint64_t surface = file.cells.surface_cells, interior = file.cells.interior_cells;
    const double voxel = file.cells.voxel;
    const std::vector<std::uint8_t> bytes = voxmap_bytes(std::move(file), progress.get());
    Outputs outputs(o.force);
    outputs.add(output, bytes, progress.get());
    outputs.commit();
    if (!o.quiet)
        fmt::print("{}: {} surface, {} interior cells of {}, {}\n", output.string(), format_count(surface),
                   format_count(interior), format_length(voxel), format_size(bytes.size()));
    return ExitCode::ok;
}

} // namespace

VerbAction add_pack(CLI::App &verb)
{
    auto o = std::make_shared<PackOptions>();
    verb.add_option("FILE", o->input,
                    "a .vdb: with grid `state`, as convert and export write it, or another program's level "
                    "set, mask or bool grid")
        ->required();
    verb.add_option("-o,--output", o->output, "the .voxmap (default: beside the .vdb, same name)")
        ->type_name("OUT");
    verb.add_option_function<std::string>(
            "--grid", [o](const std::string &name) { o->foreign.name = name; },
            "which grid of another program's file (default: its only one); a float grid without a class must "
            "be named: < 0 is inside")
        ->type_name("NAME");
    verb.add_option_function<std::string>(
            "--as",
            [o](const std::string &as) {
                o->foreign.as = as == "surface" ? ForeignGrid::As::surface : ForeignGrid::As::solid;
            },
            "what a mask or bool grid has on: solid, whose outer cells become surface, or surface, nothing "
            "being interior (default solid)")
        ->check(CLI::IsMember({"solid", "surface"}))
        ->type_name("WHAT");
    verb.add_flag("--snap", o->foreign.snap,
                  "move another program's grid by up to half a cell, so that its samples are at the centres "
                  "of cells; the file records it");
    verb.add_option_function<std::string>(
            "--unit", [o](const std::string &unit) { o->foreign.unit = parse_unit(unit); },
            "world unit of another program's file: mm, cm, m or in (default m)")
        ->check(CLI::IsMember({"mm", "cm", "m", "in"}))
        ->type_name("UNIT");
    add_shared(verb, *o, {Shared::jobs, Shared::force, Shared::progress, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        return pack(*o);
    };
}

} // namespace voxshell
