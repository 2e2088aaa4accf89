// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell diff: what differs between two assets, structure first, then values.
#include "cli/asset_kind.hpp"
#include "cli/compare.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "pipeline/verify_asset.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <memory>
#include <set>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
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

Comparison compare(const std::string &path_a, const std::string &path_b, double tolerance)
{
    const AssetKind a = asset_kind(path_a), b = asset_kind(path_b);
    const auto cells = [](AssetKind kind) { return kind == AssetKind::voxmap || kind == AssetKind::vdb; };
    if (a != b && !(cells(a) && cells(b)))
        throw Failure(
            ExitCode::usage, path_b,
            fmt::format("is a {}, {} is a {}: they cannot be compared", name_of(b), path_a, name_of(a)));
    if (a == AssetKind::plan) return compare(read_plan(path_a), read_plan(path_b));
    if (a == AssetKind::pointshell)
        return compare(read_pointshell(path_a), read_pointshell(path_b), tolerance);
    return compare(read_cells(path_a, a), read_cells(path_b, b), tolerance);
}

ExitCode compare_files(const DiffOptions &o)
{
    const Comparison c = compare(o.a, o.b, o.tolerance);
    if (o.json)
        fmt::print("{}", json_text(as_json(c)));
    else if (!o.quiet)
        print(c, o);
    return c.equal() ? ExitCode::ok : ExitCode::differs;
}

/// Assets below a folder, by their path in it.
std::set<std::string> assets_below(const std::string &folder)
{
    std::set<std::string> names;
    for (const fs::path &path : assets_in(folder))
        names.insert(path.lexically_relative(folder).generic_string());
    return names;
}

/// Every asset of either folder. A file that cannot be read is told, and the others are compared.
ExitCode compare_folders(const DiffOptions &o)
{
    const std::set<std::string> in_a = assets_below(o.a), in_b = assets_below(o.b);
    std::set<std::string> all = in_a;
    all.insert(in_b.begin(), in_b.end());
    std::map<std::string, std::size_t> counts;
    ExitCode worst = ExitCode::ok;
    json files = json::array();
    for (const std::string &name : all) {
        json entry = {{"path", name}, {"state", "equal"}};
        try {
            if (!in_b.count(name)) {
                entry["state"] = "only in a";
            } else if (!in_a.count(name)) {
                entry["state"] = "only in b";
            } else {
                const Comparison c =
                    compare((fs::path(o.a) / name).string(), (fs::path(o.b) / name).string(), o.tolerance);
                if (!c.equal()) {
                    entry["state"] = "differs";
                    entry["comparison"] = as_json(c);
                    if (!o.json && !o.quiet) {
                        fmt::print("{}\n", name);
                        print(c, o);
                    }
                }
            }
        } catch (...) {
            const Failure failure = current_failure();
            entry["state"] = "failed";
            entry["message"] = failure.what();
            worst = std::max(worst, failure.code);
            tell_failure("diff", failure);
        }
        const std::string state = entry["state"];
        ++counts[state];
        if (state.starts_with("only") && !o.json && !o.quiet) fmt::print("{}: {}\n", name, state);
        files.push_back(std::move(entry));
    }
    const bool equal = counts["equal"] == all.size();
    if (o.json)
        fmt::print("{}",
                   json_text({{"schema", "voxshell-diff-folders/1"}, {"equal", equal}, {"files", files}}));
    else if (!o.quiet)
        fmt::print("{} equal, {} differ, {} only in {}, {} only in {}\n", counts["equal"], counts["differs"],
                   counts["only in a"], o.a, counts["only in b"], o.b);
    if (worst != ExitCode::ok) return worst;
    return equal ? ExitCode::ok : ExitCode::differs;
}

} // namespace

VerbAction add_diff(CLI::App &verb)
{
    auto o = std::make_shared<DiffOptions>();
    verb.add_option("A", o->a, ".voxmap, .pointshell, .plan or .vdb")->required();
    verb.add_option("B", o->b,
                    "another of the same kind; a .voxmap and a .vdb hold the same cells; two folders: all "
                    "assets below them, by name")
        ->required();
    add_length(verb, "--tolerance", o->tolerance,
               "ignore what moved no further, and normals and areas with it (default 0mm; 0m to 1e9m, for "
               "cells up to 16 voxels)",
               true);
    add_shared(verb, *o, {Shared::format, Shared::quiet});
    return [o] {
        const bool a = fs::is_directory(o->a), b = fs::is_directory(o->b);
        if (a != b) throw Failure(ExitCode::usage, o->b, "a folder and a file: they cannot be compared");
        return a ? compare_folders(*o) : compare_files(*o);
    };
}

} // namespace voxshell
