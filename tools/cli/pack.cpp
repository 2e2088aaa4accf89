// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell pack: the .vdb that people edit to the .voxmap that the runtime maps.
#include "cli/asset_kind.hpp"
#include "cli/options.hpp"
#include "cli/verb.hpp"
#include "pipeline/output.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <memory>

namespace voxshell {
namespace {

struct PackOptions : SharedOptions {
    std::string input, output;
};

ExitCode pack(const PackOptions &o)
{
    const std::filesystem::path input(o.input);
    const std::filesystem::path output = o.output.empty() ? std::filesystem::path(input).replace_extension(".voxmap")
                                                          : std::filesystem::path(o.output);
    if (output.extension() != ".voxmap")
        throw Failure(ExitCode::usage, output.string(), "pack writes .voxmap; for other endings use voxshell export");
    if (asset_kind(input) != AssetKind::vdb) throw Failure(ExitCode::usage, input.string(), "pack reads a .vdb");
    const VoxmapFile file = read_cells(input, AssetKind::vdb);
    const std::vector<std::uint8_t> bytes = voxmap_bytes(file);
    Outputs outputs(o.force);
    outputs.add(output, bytes);
    outputs.commit();
    if (!o.quiet)
        fmt::print("{}: {} surface, {} interior cells of {}, {}\n", output.string(), format_count(file.cells.surface_cells),
                   format_count(file.cells.interior_cells), format_length(file.cells.voxel), format_size(bytes.size()));
    return ExitCode::ok;
}

} // namespace

VerbAction add_pack(CLI::App &verb)
{
    auto o = std::make_shared<PackOptions>();
    verb.add_option("FILE", o->input, "a .vdb with grid `state`, as convert and export write it")->required();
    verb.add_option("-o,--output", o->output, "the .voxmap (default: beside the .vdb, same name)")->type_name("OUT");
    add_shared(verb, *o, {Shared::jobs, Shared::force, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        return pack(*o);
    };
}

} // namespace voxshell
