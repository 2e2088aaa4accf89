// SPDX-License-Identifier: GPL-3.0-or-later
// Which kind of asset a file is, by its first bytes: names lie.
#pragma once

#include "voxmap/voxmap_file.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

enum class AssetKind { voxmap, pointshell, vdb, plan };

/// Throws Failure(system) if the file cannot be read, Failure(unsupported) if it is none of them.
AssetKind asset_kind(const std::filesystem::path &path);

const char *name_of(AssetKind kind); ///< "voxmap"

/// The optional channels that a map has: "layers", "distance".
std::vector<std::string> channel_names(const Channels &channels);

/// The cells of a .voxmap or a .vdb.
VoxmapFile read_cells(const std::filesystem::path &path, AssetKind kind);

} // namespace voxshell
