// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell diff: what differs between two assets, structure first, then values.
#include "cli/asset_kind.hpp"
#include "cli/compare.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <memory>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;

struct DiffOptions : SharedOptions {
    std::string a, b;
    double tolerance = 0; ///< [m]
};

json as_json(const Comparison &c)
{
    json j = {{"schema", "voxshell-diff/1"},
              {"equal", c.equal()},
              {"structure", json::array()},
              {"values",
               {{"compared", c.compared},
                {"changed", c.changed},
                {"largest_m", c.largest},
                {"first", json::array()}}},
              {"notes", c.notes}};
    for (const Comparison::Structure &s : c.structure)
        j["structure"].push_back({{"what", s.what}, {"a", s.a}, {"b", s.b}});
    for (const Comparison::Change &change : c.first)
        j["values"]["first"].push_back({{"at_m", change.at}, {"what", change.what}});
    return j;
}

void print(const Comparison &c, const DiffOptions &o)
{
    for (const Comparison::Structure &s : c.structure) fmt::print("{}: {} / {}\n", s.what, s.a, s.b);
    if (c.compared) {
        const std::string limit = o.tolerance > 0 ? " by more than " + format_length(o.tolerance) : "";
        fmt::print("{} {} changed{}", format_count(c.changed), c.noun, limit);
        if (c.changed)
            fmt::print(", the largest change {}{}", c.largest_is_bound ? "more than " : "",
                       format_length(c.largest));
        fmt::print("\n");
        for (const Comparison::Change &change : c.first)
            fmt::print("  ({:.9g}, {:.9g}, {:.9g}) m  {}\n", change.at[0], change.at[1], change.at[2],
                       change.what);
        if (c.changed > c.first.size())
            fmt::print("  and {} more\n", format_count(c.changed - c.first.size()));
    }
    for (const std::string &note : c.notes) fmt::print("note: {}\n", note);
    fmt::print("{}\n", c.equal() ? "equal" : "differs");
}

} // namespace

VerbAction add_diff(CLI::App &verb)
{
    auto o = std::make_shared<DiffOptions>();
    verb.add_option("A", o->a, ".voxmap, .pointshell, .plan or .vdb")->required();
    verb.add_option("B", o->b, "another of the same kind; a .voxmap and a .vdb hold the same cells")
        ->required();
    add_length(verb, "--tolerance", o->tolerance,
               "ignore what moved no further, and normals and areas with it (default 0mm; 0m to 1e9m, for "
               "cells up to 16 voxels)",
               true);
    add_shared(verb, *o, {Shared::format, Shared::quiet});
    return [o] {
        const AssetKind a = asset_kind(o->a), b = asset_kind(o->b);
        const auto cells = [](AssetKind kind) { return kind == AssetKind::voxmap || kind == AssetKind::vdb; };
        if (a != b && !(cells(a) && cells(b)))
            throw Failure(
                ExitCode::usage, o->b,
                fmt::format("is a {}, {} is a {}: they cannot be compared", name_of(b), o->a, name_of(a)));
        const Comparison c = a == AssetKind::plan ? compare(read_plan(o->a), read_plan(o->b))
                             : a == AssetKind::pointshell
                                 ? compare(read_pointshell(o->a), read_pointshell(o->b), o->tolerance)
                                 : compare(read_cells(o->a, a), read_cells(o->b, b), o->tolerance);
        if (o->json)
            fmt::print("{}", json_text(as_json(c)));
        else if (!o->quiet)
            print(c, *o);
        return c.equal() ? ExitCode::ok : ExitCode::differs;
    };
}

} // namespace voxshell
