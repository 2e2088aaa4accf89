// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell export: an asset for other programs. The endings of input and output say what is made of what.
#include "cli/asset_kind.hpp"
#include "cli/options.hpp"
#include "cli/verb.hpp"
#include "pipeline/output.hpp"
#include "pointshell/export_points.hpp"
#include "voxmap/export_cells.hpp"
#include "voxmap/nvdb.hpp"
#include "voxmap/vdb.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <memory>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

struct ExportOptions : SharedOptions {
    std::string input, output;
};

using Write = std::function<void(const Outputs::Sink &)>;

Write whole(std::vector<std::uint8_t> bytes)
{
    return [bytes = std::move(bytes)](const Outputs::Sink &sink) {
        sink({reinterpret_cast<const char *>(bytes.data()), bytes.size()});
    };
}

Write write_cells(const std::shared_ptr<const VoxmapFile> &file, const std::string &ending)
{
    if (ending == ".vdb") return whole(vdb_bytes(file->cells, file->source_hash, file->meta, file->channels));
    if (ending == ".nvdb") return whole(nvdb_bytes(file->cells, file->channels));
    if (ending == ".voxmap") return whole(voxmap_bytes(*file));
    if (ending == ".glb") return whole(cells_glb(file->cells));
    if (ending == ".ply") return [file](const Outputs::Sink &sink) { cells_ply(file->cells, sink); };
    return [file](const Outputs::Sink &sink) { cells_csv(*file, sink); };
}

Write write_points(const std::shared_ptr<const PointshellFile> &file, const std::string &ending)
{
    if (ending == ".glb") return whole(points_glb(*file));
    if (ending == ".ply") return [file](const Outputs::Sink &sink) { points_ply(*file, sink); };
    return [file](const Outputs::Sink &sink) { points_csv(*file, sink); };
}

std::vector<std::string> endings(AssetKind kind)
{
    if (kind == AssetKind::pointshell) return {".ply", ".glb", ".csv"};
    return {kind == AssetKind::vdb ? ".voxmap" : ".vdb", ".nvdb", ".ply", ".glb", ".csv"};
}

ExitCode run(const ExportOptions &o)
{
    const fs::path input(o.input), output(o.output);
    const AssetKind kind = asset_kind(input);
    if (kind == AssetKind::plan)
        throw Failure(ExitCode::unsupported, input.string(),
                      "a plan has no cells and no points; voxshell inspect tells what it says");
    const std::vector<std::string> known = endings(kind);
    const std::string ending = output.extension().string();
    if (std::find(known.begin(), known.end(), ending) == known.end())
        throw Failure(ExitCode::usage, output.string(),
                      fmt::format("a {} is exported as {}: the ending says which", name_of(kind),
                                  fmt::join(known, ", ")));
    const Write write = kind == AssetKind::pointshell
                            ? write_points(std::make_shared<PointshellFile>(read_pointshell(input)), ending)
                            : write_cells(std::make_shared<VoxmapFile>(read_cells(input, kind)), ending);
    const std::unique_ptr<Progress> progress = make_progress(o.progress, o.quiet);
    Outputs outputs(o.force);
    std::uint64_t size = 0;
    progress->stage("export", 0);
    outputs.add_stream(output, [&](const Outputs::Sink &sink) {
        write([&](std::string_view piece) {
            progress->check();
            sink(piece);
            size += piece.size();
            progress->advance(piece.size());
        });
    });
    outputs.commit();
    if (!o.quiet) fmt::print("{}: {}\n", output.string(), format_size(size));
    return ExitCode::ok;
}

} // namespace

VerbAction add_export(CLI::App &verb)
{
    auto o = std::make_shared<ExportOptions>();
    verb.add_option("FILE", o->input, ".voxmap, .vdb or .pointshell")->required();
    verb.add_option("-o,--output", o->output,
                    "cells: .vdb or .voxmap (without loss), .nvdb (NanoVDB, for GPUs), .csv (i,j,k,state), "
                    ".ply or .glb (the skin of the surface cells); "
                    "points: .ply (x y z nx ny nz area), .csv, .glb")
        ->required()
        ->type_name("OUT");
    add_shared(verb, *o, {Shared::jobs, Shared::force, Shared::progress, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        return run(*o);
    };
}

} // namespace voxshell
