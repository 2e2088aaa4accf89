// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/asset_kind.hpp"

#include "cli/failure.hpp"
#include "voxmap/vdb.hpp"
#include "voxshell/format/container.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

namespace voxshell {

AssetKind asset_kind(const std::filesystem::path &path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        throw Failure(ExitCode::system, path.string(), "is a folder");
    const std::unique_ptr<std::FILE, int (*)(std::FILE *)> file(std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file) throw Failure(ExitCode::system, path.string(), std::strerror(errno));
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
    const bool ours = ending == ".voxmap" || ending == ".pointshell" || ending == ".plan" || ending == ".vdb";
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
