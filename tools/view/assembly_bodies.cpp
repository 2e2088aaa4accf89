// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/assembly_bodies.hpp"

#include "import/importers.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::json;

Pose pose_of(const json &instance)
{
    const auto p = instance.at("position_m").get<std::array<double, 3>>();
    const auto q = instance.at("orientation_wxyz").get<std::array<double, 4>>();
    const Pose pose{p, {q[1], q[2], q[3], q[0]}};
    double size = 0;
    for (const double x : q) size += x * x;
    for (const double x : p) size += 0 * x; // not finite if it is not
    if (!(std::abs(size - 1) < 1e-3)) throw std::runtime_error("an instance's pose is no turn and move");
    return pose;
}

} // namespace

AssemblyBodies read_assembly(const fs::path &path)
{
    const std::string name = path.string();
    const Bytes bytes = read_whole_file(path, name);
    AssemblyBodies out;
    try {
        const auto shallow = [](int depth, json::parse_event_t, json &) {
            if (depth > 16) throw std::runtime_error("is nested too deep");
            return true;
        };
        const json file = json::parse(bytes.begin(), bytes.end(), shallow);
        if (!file.is_object() || file.value("schema", "") != "voxshell-assembly/1")
            throw std::runtime_error(
                "is neither a scene (.scene.json) nor an assembly.json of voxshell batch");
        out.name = file.at("name").get<std::string>();
        for (const json &part : file.at("parts")) {
            AssemblyBodies::Part one;
            one.name = part.at("name").get<std::string>();
            for (const char *kind : {"voxmap", "pointshell"}) {
                if (!part.at("files").contains(kind)) continue;
                const fs::path asset = part["files"][kind].at("path").get<std::string>();
                if (asset.is_absolute() || asset.lexically_normal().begin()->string() == "..")
                    throw std::runtime_error("names a file outside its folder");
                one.assets.push_back(path.parent_path() / asset);
            }
            out.failed += one.assets.empty();
            out.parts.push_back(std::move(one));
        }
        for (const json &instance : file.at("instances")) {
            const auto part = instance.at("part").get<std::size_t>();
            if (part >= out.parts.size()) throw std::runtime_error("has an instance of no part");
            if (!out.parts[part].assets.empty()) out.parts[part].poses.push_back(pose_of(instance));
            ++out.instances;
        }
    } catch (const json::exception &error) {
        throw Failure(ExitCode::invalid, name, std::string("is no assembly.json: ") + error.what());
    } catch (const std::runtime_error &error) {
        throw Failure(ExitCode::invalid, name, error.what());
    }
    return out;
}

} // namespace voxshell
