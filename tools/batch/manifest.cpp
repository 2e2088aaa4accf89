// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/manifest.hpp"

#include "batch/batch.hpp"

#include <nlohmann/json.hpp>

#include <fmt/format.h>

#include <fstream>

namespace voxshell {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

constexpr const char *schema = "voxshell-manifest/1";

} // namespace

Manifest Manifest::read(const fs::path &path)
{
    Manifest manifest;
    std::ifstream file(path, std::ios::binary);
    if (!file) return manifest;
    const json stored = json::parse(file, nullptr, false);
    const auto refuse = [&](const std::string &what) {
        throw Failure(ExitCode::invalid, path.string(), what);
    };
    if (!stored.is_object() || stored.value("schema", "") != schema || !stored.contains("files") ||
        !stored["files"].is_array())
        refuse(fmt::format("is not a manifest of {}", schema));
    for (const json &each : stored["files"]) {
        try {
            const std::string name = each.at("path");
            const fs::path inside = fs::path(name).lexically_normal();
            if (name.empty() || inside.is_absolute() || *inside.begin() == "..")
                refuse(fmt::format("'{}' is not a path below its folder", name));
            manifest.files[name] = {each.at("bytes"), each.at("sha256")};
        } catch (const json::exception &) {
            refuse("files[] needs path, bytes and sha256");
        }
    }
    return manifest;
}

std::string Manifest::text() const
{
    json out = {{"schema", schema}, {"version", tool_version()}, {"files", json::array()}};
    for (const auto &[path, file] : files)
        out["files"].push_back({{"path", path}, {"bytes", file.bytes}, {"sha256", file.sha256}});
    return out.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

std::vector<ManifestCheck> check_manifest(const fs::path &path)
{
    std::error_code error;
    if (!fs::is_regular_file(path, error)) throw Failure(ExitCode::system, path.string(), "is not there");
    std::vector<ManifestCheck> checks;
    for (const auto &[name, file] : Manifest::read(path).files) {
        ManifestCheck check{name, file.bytes, ""};
        const fs::path at = path.parent_path() / name;
        const std::uintmax_t size = fs::file_size(at, error);
        if (error)
            check.fault = "is not there";
        else if (size != file.bytes)
            check.fault = fmt::format("has {} bytes, not {}", size, file.bytes);
        else if (const auto hash = hash_of_file(at); !hash)
            check.fault = "cannot be read";
        else if (hex(*hash) != file.sha256)
            check.fault = "has other content than it was made with";
        checks.push_back(std::move(check));
    }
    return checks;
}

} // namespace voxshell
