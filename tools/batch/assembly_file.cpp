// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/assembly_file.hpp"

#include <fmt/format.h>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;
using Sink = std::function<void(std::string_view)>;

std::string text(const json &value)
{
    return value.dump(-1, ' ', false, json::error_handler_t::replace);
}

template<typename Items, typename Each>
void list(const Sink &sink, const char *name, const Items &items, const Each &each)
{
    sink(fmt::format(",\n \"{}\": [", name));
    for (std::size_t n = 0; n < items.size(); ++n) sink((n ? ",\n  " : "\n  ") + text(each(n, items[n])));
    sink(items.empty() ? "]" : "\n ]");
}

json part_json(const AssemblyPart &part, const BatchPart &made)
{
    json files = json::object();
    for (std::size_t n = 0; n < asset_endings.size() && made.has_files; ++n)
        files[asset_endings[n]] = {{"path", part.name + "." + asset_endings[n]},
                                   {"sha256", hex(made.files[n].sha256)}};
    return {{"name", part.name},   {"geometry_sha256", hex(part.hash)},
            {"shape", part.shape}, {"instances", part.instances},
            {"files", files},      {"failed", made.failure ? json(made.failure->what()) : json(nullptr)}};
}

template<typename Index>
json or_null(const std::optional<Index> &index)
{
    return index ? json(*index) : json(nullptr);
}

} // namespace

void AssemblyFile::write(std::span<const BatchPart> made, const Sink &sink) const
{
    sink(fmt::format(
        "{{\n \"schema\": \"voxshell-assembly/1\",\n \"version\": {},\n \"name\": {},\n \"source\": "
        "{},\n \"pose_error_m\": {}",
        text(tool_version()), text(name), text({{"path", source}, {"sha256", hex(source_hash)}}),
        text(assembly.pose_error)));
    list(sink, "parts", assembly.parts,
         [&](std::size_t n, const AssemblyPart &part) { return part_json(part, made[n]); });
    list(sink, "instances", assembly.instances, [&](std::size_t, const AssemblyInstance &each) {
        return json{{"name", each.name},           {"part", each.part},
                    {"node", or_null(each.node)},  {"materials", assembly.materials_of_mesh[each.mesh]},
                    {"position_m", each.position}, {"orientation_wxyz", each.orientation}};
    });
    list(sink, "nodes", assembly.nodes, [&](std::size_t, const SceneNode &node) {
        return json{{"name", node.name}, {"parent", or_null(node.parent)}, {"pose", node.pose}};
    });
    list(sink, "materials", assembly.materials, [](std::size_t, const std::string &material) {
        return json{{"name", material}};
    });
    sink("\n}\n");
}

} // namespace voxshell
