// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/manifest.hpp"

#include "batch/batch.hpp"

#include <nlohmann/json.hpp>

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

namespace voxshell {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

namespace {

constexpr const char *schema = "voxshell-manifest/1";

} // namespace

void Manifest::add(std::string_view path, std::uint64_t bytes, const Sha256 &sha256)
{
    entries_.push_back({paths_.size(), bytes, static_cast<std::uint32_t>(path.size()), sha256});
    paths_ += path;
}

void Manifest::sort()
{
    std::stable_sort(entries_.begin(), entries_.end(),
                     [&](const Entry &a, const Entry &b) { return path_of(a) < path_of(b); });
    std::size_t kept = 0;
    for (std::size_t n = 0; n < entries_.size(); ++n) {
        if (n + 1 < entries_.size() && path_of(entries_[n]) == path_of(entries_[n + 1])) continue;
        entries_[kept++] = entries_[n];
    }
    entries_.resize(kept);
}

std::optional<Manifest::File> Manifest::find(std::string_view path) const
{
    const auto at =
        std::lower_bound(entries_.begin(), entries_.end(), path,
                         [&](const Entry &entry, std::string_view p) { return path_of(entry) < p; });
    if (at == entries_.end() || path_of(*at) != path) return {};
    return File{path_of(*at), at->bytes, at->sha256};
}

Manifest::File Manifest::operator[](std::size_t n) const
{
    return {path_of(entries_[n]), entries_[n].bytes, entries_[n].sha256};
}

Manifest Manifest::read(const fs::path &path)
{
    Manifest manifest;
    std::ifstream file(path, std::ios::binary);
    if (!file) return manifest;
    const auto refuse = [&](const std::string &what) {
        throw Failure(ExitCode::invalid, path.string(), what);
    };
    const auto take = [&](const json &each) {
        try {
            const std::string name = each.at("path"), digits = each.at("sha256");
            const fs::path inside = fs::path(name).lexically_normal();
            if (name.empty() || inside.is_absolute() || *inside.begin() == "..")
                refuse(fmt::format("'{}' is not a path below its folder", name));
            const std::optional<Sha256> hash = sha256_of_hex(digits);
            if (!hash) refuse(fmt::format("the hash of '{}' is not 64 digits", name));
            manifest.add(name, each.at("bytes").get<std::uint64_t>(), *hash);
        } catch (const json::exception &) {
            refuse("files[] needs path, bytes and sha256");
        }
    };
    // Each file is taken as it is read and then forgotten by the parser.
    bool in_files = false;
    const json stored = json::parse(
        file,
        [&](int depth, json::parse_event_t event, json &value) {
            if (event == json::parse_event_t::key && depth == 1) in_files = value == "files";
            if (!in_files || depth != 2 || event != json::parse_event_t::object_end) return true;
            take(value);
            return false;
        },
        false);
    if (!stored.is_object() || stored.value("schema", json()) != schema || !stored.contains("files") ||
        !stored["files"].is_array() || !stored["files"].empty())
        refuse(fmt::format("is not a manifest of {}", schema));
    manifest.sort();
    return manifest;
}

void Manifest::write(const std::function<void(std::string_view)> &sink) const
{
    const auto text = [](const json &value) {
        return value.dump(-1, ' ', false, json::error_handler_t::replace);
    };
    sink(fmt::format("{{\n \"schema\": \"{}\",\n \"version\": {},\n \"files\": [", schema,
                     text(tool_version())));
    for (std::size_t n = 0; n < size(); ++n) {
        const File file = (*this)[n];
        sink((n ? ",\n  " : "\n  ") +
             text({{"path", std::string(file.path)}, {"bytes", file.bytes}, {"sha256", hex(file.sha256)}}));
    }
    sink("\n ]\n}\n");
}

std::vector<ManifestCheck> check_manifest(const fs::path &path)
{
    std::error_code error;
    if (!fs::is_regular_file(path, error)) throw Failure(ExitCode::system, path.string(), "is not there");
    std::vector<ManifestCheck> checks;
    const Manifest manifest = Manifest::read(path);
    for (std::size_t n = 0; n < manifest.size(); ++n) {
        const Manifest::File file = manifest[n];
        ManifestCheck check{std::string(file.path), file.bytes, ""};
        const fs::path at = path.parent_path() / check.path;
        const std::uintmax_t size = fs::file_size(at, error);
        if (error)
            check.fault = "is not there";
        else if (size != file.bytes)
            check.fault = fmt::format("has {} bytes, not {}", size, file.bytes);
        else if (const auto hash = hash_of_file(at); !hash)
            check.fault = "cannot be read";
        else if (*hash != file.sha256)
            check.fault = "has other content than it was made with";
        checks.push_back(std::move(check));
    }
    return checks;
}

} // namespace voxshell
