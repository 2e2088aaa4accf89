// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/asset_kind.hpp"

#include "cli/failure.hpp"
#include "voxmap/vdb.hpp"
#include "voxshell/format/container.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <memory>
#include <string>

namespace voxshell {

namespace {

constexpr const char *endings[] = {".voxmap", ".pointshell", ".plan", ".vdb"};

/// The first asset that a folder, or a name without its ending, may have meant.
std::string meant(const std::filesystem::path &path)
{
    std::error_code ignored;
    if (!std::filesystem::is_directory(path, ignored)) {
        for (const char *ending : endings)
            if (std::filesystem::exists(path.string() + ending, ignored)) return path.string() + ending;
        return "";
    }
    std::string first; // by name: folders are in no order
    for (const auto &entry : std::filesystem::directory_iterator(path, ignored)) {
        const std::string name = entry.path().string(), ending = entry.path().extension().string();
        if (std::find(std::begin(endings), std::end(endings), ending) != std::end(endings) &&
            (first.empty() || name < first))
            first = name;
    }
    return first;
}

[[noreturn]] void refuse(const std::filesystem::path &path, const std::string &fact)
{
    const std::string other = meant(path);
    throw Failure(ExitCode::system, path.string(),
                  other.empty() ? fact : fact + "; did you mean " + other + "?");
}

} // namespace

AssetKind asset_kind(const std::filesystem::path &path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored)) refuse(path, "is a folder, not an asset");
    const std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file) refuse(path, std::strerror(errno));
    char magic[VXS_CONTAINER_MAGIC_SIZE] = {};
    const std::size_t got = std::fread(magic, 1, sizeof magic, file.get());
    if (got != sizeof magic && std::ferror(file.get()))
        throw Failure(ExitCode::system, path.string(), "cannot be read");
    if (std::memcmp(magic, VXS_VOXMAP_MAGIC, sizeof magic) == 0) return AssetKind::voxmap;
    if (std::memcmp(magic, VXS_POINTSHELL_MAGIC, sizeof magic) == 0) return AssetKind::pointshell;
    if (std::memcmp(magic, VXS_PLAN_MAGIC, sizeof magic) == 0) return AssetKind::plan;
    if (std::memcmp(magic, " BDV", 4) == 0) return AssetKind::vdb;
    // A file with our ending and other bytes is a damaged asset rather than something else.
    const std::string ending = path.extension().string();
    const bool ours = std::find(std::begin(endings), std::end(endings), ending) != std::end(endings);
    throw Failure(ours ? ExitCode::invalid : ExitCode::unsupported, path.string(),
                  "is not a .voxmap, .pointshell, .plan or .vdb: its first bytes are of none of them");
}

const char *name_of(AssetKind kind)
{
    switch (kind) {
    case AssetKind::voxmap:
        return "voxmap";
    case AssetKind::pointshell:
        return "pointshell";
    case AssetKind::plan:
        return "plan";
    case AssetKind::vdb:
        break;
    }
    return "vdb";
}

std::vector<std::string> channel_names(const Channels &channels)
{
    std::vector<std::string> names;
    if (channels.layer_count > 0) names.push_back("layers");
    if (channels.distance_band > 0) names.push_back("distance");
    return names;
}

VoxmapFile read_cells(const std::filesystem::path &path, AssetKind kind)
{
    if (kind == AssetKind::voxmap) return read_voxmap(path);
    VdbFile vdb = read_vdb(path);
    VoxmapFile file;
    file.cells = std::move(vdb.cells);
    file.channels = std::move(vdb.channels);
    file.source_hash = vdb.source_hash;
    file.meta = std::move(vdb.meta);
    return file;
}

} // namespace voxshell
