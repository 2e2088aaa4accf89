// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/batch_report.hpp"

#include "cli/foreseen.hpp"
#include "cli/options.hpp"
#include "pipeline/estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

constexpr PartState states[] = {PartState::built,  PartState::cached,    PartState::up_to_date,
                                PartState::failed, PartState::not_begun, PartState::wanted};

std::string text(const json &value)
{
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

template<typename Each>
void list(const Outputs::Sink &sink, const char *name, const Each &each)
{
    sink(fmt::format(",\n  \"{}\": [", name));
    bool first = true;
    each([&](const json &item) {
        sink((first ? "\n    " : ",\n    ") + text(item));
        first = false;
    });
    sink(first ? "]" : "\n  ]");
}

json counts_json(const BatchResult &result, bool dry_run)
{
    json counts;
    for (const PartState state : states) {
        if (state == (dry_run ? PartState::built : PartState::wanted)) continue;
        std::string key = name_of(state);
        std::replace(key.begin(), key.end(), ' ', '_');
        counts[key] = result.count(state);
    }
    return counts;
}

} // namespace

std::string tally(const BatchResult &result)
{
    std::string said;
    const bool dry_run = result.count(PartState::wanted) > 0;
    for (const PartState state : {PartState::wanted, PartState::built, PartState::cached,
                                  PartState::up_to_date, PartState::failed, PartState::not_begun})
        if (const std::size_t n = result.count(state);
            n || (state == PartState::built && !dry_run) || state == PartState::failed)
            said += fmt::format("{}{} {}", said.empty() ? "" : ", ", format_count(n), name_of(state));
    return said;
}

void BatchReport::write(const Outputs::Sink &sink) const
{
    const auto shown = [&](const fs::path &path) {
        return reproducible ? path.filename().string() : path.string();
    };
    sink(fmt::format("{{\n  \"schema\": \"voxshell-report/1\",\n  \"version\": {},\n  \"options\": {}",
                     text(tool_version()), text(options)));
    list(sink, "inputs", [&](const auto &item) {
        for (std::size_t n = 0; n < inputs.size() && n < result.inputs.size(); ++n)
            item({{"path", shown(inputs[n].path)}, {"sha256", hex(result.inputs[n])}});
    });
    list(sink, "parts", [&](const auto &item) {
        for (const BatchPart &part : result.parts) {
            const json about = part.failure ? json() : result.about(part);
            if (about.is_null()) continue;
            json described = {{"name", part.name}};
            for (const auto &[key, value] : about.items())
                if (key != "warnings") described[key] = value;
            item(described);
        }
    });
    list(sink, "outputs", [&](const auto &item) {
        for (const BatchPart &part : result.parts)
            for (std::size_t n = 0; n < part.files.size() && part.has_files; ++n)
                item({{"path", shown(folder / part.file_name(n))},
                      {"bytes", part.files[n].bytes},
                      {"sha256", hex(part.files[n].sha256)}});
        for (const BatchAssembly &each : result.assemblies)
            item({{"path", shown(each.file)}, {"bytes", each.bytes}, {"sha256", hex(each.sha256)}});
    });
    list(sink, "warnings", [&](const auto &item) {
        for (const BatchPart &part : result.parts) {
            const json about = result.about(part);
            if (about.is_null()) continue;
            for (const json &warning : about["warnings"])
                item({{"code", warning["code"]},
                      {"message", part.name + ": " + warning["message"].template get<std::string>()}});
        }
        if (!result.unstored.empty()) item({{"code", "cache-takes-nothing"}, {"message", result.unstored}});
    });
    list(sink, "failed", [&](const auto &item) {
        for (const BatchPart &part : result.parts)
            if (part.failure)
                item({{"path", part.name},
                      {"code", static_cast<int>(part.failure->code)},
                      {"message", part.failure->what()}});
    });
    sink(",\n  \"counts\": " + text(counts_json(result, false)));
    if (!reproducible)
        sink(",\n  \"cost\": " + text({{"seconds", seconds}, {"peak_rss_bytes", peak_memory()}}));
    sink("\n}\n");
}

void tell_dry_run(const BatchResult &result, unsigned threads, bool as_json)
{
    double memory = 0, files = 0, work = 0;
    for (const auto &[index, foreseen] : result.foreseen) {
        memory = std::max(memory, foreseen.estimate.memory_bytes);
        files += foreseen.estimate.file_bytes;
        work += 2 * foreseen.estimate.seconds; // it is told for two cores
    }
    if (as_json) {
        const auto print = [](std::string_view piece) { fmt::print("{}", piece); };
        print(fmt::format("{{\n  \"schema\": \"voxshell-estimate/1\",\n  \"version\": {}",
                          text(tool_version())));
        list(print, "estimates", [&](const auto &item) {
            for (const auto &[index, foreseen] : result.foreseen)
                item(foreseen_json(result.parts[index].name, foreseen));
        });
        print(fmt::format(",\n  \"counts\": {}\n}}\n", text(counts_json(result, true))));
        return;
    }
    for (const auto &[index, foreseen] : result.foreseen) tell_foreseen(result.parts[index].name, foreseen);
    fmt::print("{}", tally(result));
    if (!result.foreseen.empty())
        fmt::print(": up to {} of memory for a part, {} of files, about {:.2g} s on {} threads",
                   format_size(static_cast<std::uint64_t>(memory)),
                   format_size(static_cast<std::uint64_t>(files)), work / threads, threads);
    fmt::print("\n");
}

} // namespace voxshell
