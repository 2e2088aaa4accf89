// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell inspect: what is in an asset.
#include "cli/asset_facts.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <memory>

namespace voxshell {

VerbAction add_inspect(CLI::App &verb)
{
    struct Options : SharedOptions {
        std::string file;
    };
    auto o = std::make_shared<Options>();
    verb.add_option("FILE", o->file, ".voxmap, .pointshell, .plan or .vdb")->required();
    add_shared(verb, *o, {Shared::format});
    return [o] {
        const AssetFacts facts = asset_facts(o->file);
        if (o->json) {
            fmt::print("{}", json_text(facts.as_json));
            return ExitCode::ok;
        }
        fmt::print("{}\n", facts.first);
        for (const AssetFacts::Row &row : facts.rows) fmt::print("  {:<9} {}\n", row.name, row.value);
        return ExitCode::ok;
    };
}

} // namespace voxshell
