// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/convert_extra.hpp"

#include "cli/failure.hpp"
#include "cli/options.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <charconv>
#include <numbers>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;

double degrees(double angle)
{
    return angle * 180 / std::numbers::pi;
}

template<class Number>
Number parse_number(std::string_view text, std::string_view what, Number low, Number high)
{
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
        throw Failure(ExitCode::usage, "",
                      fmt::format("--channels: '{}' is not a number of cells from {} to {}, as {}:3 needs",
                                  text, low, high, what));
    return value;
}

} // namespace

ChannelRequest parse_channels(std::string_view text)
{
    ChannelRequest request;
    for (bool more = true; more;) {
        const std::size_t comma = text.find(',');
        more = comma != std::string_view::npos;
        const std::string_view item = text.substr(0, comma), name = item.substr(0, item.find(':'));
        const std::string_view value =
            name.size() < item.size() ? item.substr(name.size() + 1) : std::string_view();
        if (more) text.remove_prefix(comma + 1);
        const bool twice =
            (name == "layers" && request.layers > 0) || (name == "distance" && request.distance_cells > 0);
        if (twice) throw Failure(ExitCode::usage, "", fmt::format("--channels: {} occurs twice", name));
        if (name == "layers")
            request.layers = parse_number<int>(value, name, 1, most_layers);
        else if (name == "distance")
            request.distance_cells = parse_number<double>(value, name, 1, most_distance_cells);
        else
            throw Failure(
                ExitCode::usage, "",
                fmt::format(
                    "--channels: '{}' is neither layers:N nor distance:CELLS, as in layers:3,distance:3",
                    item));
    }
    return request;
}

void add_extra(CLI::App &verb, ExtraOptions &o)
{
    add_length(verb, "--shell-spacing", o.shell_spacing,
               "make the points with cells of this edge, coarser or finer than the map's (default: the "
               "voxel); points "
               "are at most three of these apart");
    verb.add_option(
            "--thin-shell", o.thin_shell,
            "fewer points where the surface is flat: one stands for a block of 2 x 2 x 2 cells where normals "
            "differ by at most DEGREES; adjacent points stay within three voxels, area weights add up as "
            "before; contact with edges and pins is found later (default: none; 0.1 to 30)")
        ->check(CLI::Range(0.1, 30.0))
        ->type_name("DEGREES");
    verb.add_option_function<std::string>(
            "--channels", [&o](const std::string &value) { o.channels = parse_channels(value); },
            "channels of the map, as layers:3,distance:3: rings around the surface (1 to 8), distance from "
            "it (1 to 64 "
            "cells) (default: none)")
        ->type_name("LIST");
}

json extra_json(const ExtraOptions &o)
{
    json out = json::object();
    if (o.shell_spacing > 0) out["shell_spacing_m"] = o.shell_spacing;
    if (o.thin_shell > 0) out["thin_shell_deg"] = o.thin_shell;
    if (o.channels.layers > 0) out["layers"] = o.channels.layers;
    if (o.channels.distance_cells > 0) out["distance_cells"] = o.channels.distance_cells;
    return out;
}

json extra_json(const Part &part)
{
    json out = json::object();
    if (part.shell_voxel != part.voxel) out["shell_voxel_m"] = part.shell_voxel;
    const Thinning &t = part.thinning;
    if (t.angle > 0)
        out["thinning"] = {{"points_before", t.points_before},
                           {"points", part.points},
                           {"gap_before_h", t.gap_before / part.shell_voxel},
                           {"gap_max_h", part.gap_max / part.shell_voxel},
                           {"distance_max_m", t.distance_max},
                           {"normal_max_deg", degrees(t.normal_max)}};
    if (part.distance_error > 0) out["distance_error_max_m"] = part.distance_error;
    return out;
}

void tell_points(const Part &part)
{
    const std::string cells =
        part.shell_voxel != part.voxel ? fmt::format(" (of {})", format_length(part.shell_voxel)) : "";
    fmt::print("  points  {}, gap at most {:.3f} voxels{}, at most {} off the surface\n",
               format_count(part.points), part.gap_max / part.shell_voxel, cells,
               format_length(part.surface_error));
    const Thinning &t = part.thinning;
    if (t.angle > 0)
        fmt::print("  thinned from {} points, gap at most {:.3f} voxels before; a point left out is at most "
                   "{} from the "
                   "one that stands for it, normals differ by at most {:.2g} degrees\n",
                   format_count(t.points_before), t.gap_before / part.shell_voxel,
                   format_length(t.distance_max), degrees(t.normal_max));
    if (part.distance_error > 0) fmt::print("  distance right to {}\n", format_length(part.distance_error));
}

} // namespace voxshell
