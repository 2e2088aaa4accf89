// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/work_plan.hpp"

#include "cli/failure.hpp"
#include "container/file_hash.hpp"
#include "pipeline/convert_part.hpp"
#include "pipeline/output.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

constexpr const char *schema = "voxshell-work/1";

std::string text(const json &value)
{
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

Sha256 hash_at(const json &item, const char *key)
{
    const std::optional<Sha256> hash = sha256_of_hex(item.at(key).get<std::string>());
    if (!hash) throw Failure(ExitCode::invalid, "", "a hash is not 64 digits");
    return *hash;
}

json json_of(const WorkItem &item)
{
    json out = {{"name", item.name},          {"input", item.input},
                {"source", hex(item.source)}, {"geometry", hex(item.geometry)},
                {"key", hex(item.key)},       {"part", nullptr},
                {"missing", item.missing}};
    if (item.part)
        out["part"] = {{"name", item.part->name}, {"mesh", item.part->mesh}, {"shape", item.part->shape}};
    return out;
}

WorkItem item_of(const json &stored)
{
    WorkItem item{stored.at("name"),           stored.at("input"),     hash_at(stored, "source"),
                  hash_at(stored, "geometry"), hash_at(stored, "key"), {},
                  stored.at("missing")};
    const json &part = stored.at("part");
    if (!part.is_null()) item.part = WorkItem::OfAssembly{part.at("name"), part.at("mesh"), part.at("shape")};
    return item;
}

} // namespace

fs::path WorkPlan::done(unsigned shard, unsigned of) const
{
    return folder / fmt::format("{}-of-{}.done", shard, of);
}

fs::path work_folder(const fs::path &output, const std::string &hash)
{
    return output / ".voxshell-work" / hash;
}

void write_work(const WorkPlan &plan, const std::function<WorkItem(std::size_t)> &item)
{
    Outputs outputs(true);
    outputs.add_stream(plan.file(), [&](const Outputs::Sink &sink) {
        sink(fmt::format("{{\"schema\": {}, \"version\": {}, \"parts\": [", text(schema),
                         text(tool_version())));
        for (std::size_t n = 0; n < plan.parts; ++n) sink((n ? ",\n" : "\n") + text(json_of(item(n))));
        sink("\n]}\n");
    });
    outputs.commit();
}

void read_work(const fs::path &output, const Shard &shard, const std::function<void(const WorkItem &)> &take)
{
    const fs::path path = work_folder(output, shard.hash) / "plan.json";
    std::ifstream file(path, std::ios::binary);
    if (!file)
        throw Failure(ExitCode::system, path.string(),
                      "cannot read: is this the folder that the work was planned in?");
    WorkHash hash;
    std::size_t number = 0;
    bool in_parts = false;
    try {
        const json stored = json::parse(file, [&](int depth, json::parse_event_t event, json &value) {
            if (event == json::parse_event_t::key && depth == 1) in_parts = value == "parts";
            if (!in_parts || depth != 2 || event != json::parse_event_t::object_end) return true;
            const WorkItem item = item_of(value);
            hash.add(item.key);
            if (item.missing && number++ % shard.of == shard.index) take(item);
            return false;
        });
        if (stored.at("schema") != schema || stored.at("version") != tool_version())
            throw Failure(ExitCode::system, path.string(),
                          fmt::format("was planned by version {}, this is {}",
                                      stored.at("version").get<std::string>(), tool_version()));
    } catch (const json::exception &) {
        throw Failure(ExitCode::invalid, path.string(), "is not a plan of work");
    }
    if (hash.digits() != shard.hash)
        throw Failure(ExitCode::invalid, path.string(), "is not the plan of its folder");
}

} // namespace voxshell
