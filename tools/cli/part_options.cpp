// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/part_options.hpp"

#include <CLI/CLI.hpp>

namespace voxshell {

using json = nlohmann::ordered_json;

void add_part_options(CLI::App &verb, PartChoice &o)
{
    verb.add_option_function<std::string>(
            "--voxel",
            [&o](const std::string &value) {
                o.voxel_auto = value == "auto";
                if (o.voxel_auto) return;
                try {
                    o.voxel = parse_length(value);
                } catch (const Failure &failure) {
                    throw Failure(failure.code, "", std::string("--voxel: ") + failure.what());
                }
            },
            "edge of a cell: 0.5mm, 2e-4m (um, mm, cm, m, in; 1e-12m to 1e9m), or auto: three voxels for 99 "
            "% of "
            "the walls (no default: required; a scene has it)")
        ->type_name("LEN");
    verb.add_option("--up", o.up, "axis that is up in the file: y, or z, which is turned to +Y (default y)")
        ->check(CLI::IsMember({"y", "z"}))
        ->type_name("AXIS");
    add_length(verb, "--close-gaps", o.close_gap,
               "fill a leaking part as if holes narrower than this were closed; cells and points stay "
               "(default: none; up to 64 voxels)");
    add_length(verb, "--weld", o.weld,
               "stitch cracks: move border vertices that are nearer than this onto each other (default: "
               "none; up to a "
               "hundredth of the part)");
    verb.add_flag(
        "--inspect-mesh", o.inspect_mesh,
        "tell all about the mesh, and look for self-intersections in parts of more than 20 000 triangles");
    verb.add_option("--shell", o.shell,
                    "points: exact (on the surface) or naive (centres of cells) (default exact)")
        ->check(CLI::IsMember({"exact", "naive"}))
        ->type_name("KIND");
    verb.add_option("--depfile", o.depfile,
                    "also write for make, ninja or CMake which files the results were made of")
        ->type_name("FILE");
    add_extra(verb, o);
}

PartOptions part_options(const PartChoice &o, const SharedOptions &shared)
{
    if (o.thin_shell > 0 && o.shell == "naive")
        throw Failure(ExitCode::usage, "",
                      "--thin-shell: only for --shell exact, centres of cells do not lie flat");
    PartOptions options;
    options.voxel = o.voxel;
    options.shell = o.shell == "naive" ? ShellKind::naive : ShellKind::exact;
    options.shell_spacing = o.shell_spacing;
    options.thin_shell = o.thin_shell;
    options.channels = o.channels;
    options.close_gap = o.close_gap;
    options.weld = o.weld;
    options.inspect = o.inspect_mesh;
    options.strict = shared.strict;
    options.max_memory = shared.max_memory.value_or(0);
    return options;
}

json part_options_json(const PartChoice &o, const SharedOptions &shared)
{
    json out = {{"voxel_m", o.voxel != 0 ? json(o.voxel) : json(nullptr)},
                {"unit", shared.unit.empty() ? json(nullptr) : json(shared.unit)},
                {"up", o.up},
                {"shell", o.shell},
                {"close_gap_m", o.close_gap},
                {"voxel_auto", o.voxel_auto},
                {"weld_m", o.weld},
                {"inspect_mesh", o.inspect_mesh},
                {"strict", shared.strict},
                {"max_memory_bytes", shared.max_memory ? json(*shared.max_memory) : json(nullptr)}};
    out.update(extra_json(o));
    return out;
}

} // namespace voxshell
