// SPDX-License-Identifier: GPL-3.0-or-later
// Whether an asset file is what it says it is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

struct VerifiedAsset {
    std::string kind;    ///< "voxmap", "pointshell", "plan", "vdb"
    std::string summary; ///< one line: version, voxel, counts
    std::uint64_t bytes = 0;
};

/// .voxmap, .pointshell, .plan: every rule of the format, checksums and the content hash. A plan: also that
/// this build knows its effects and that the assets beside it, where there are any, are those that it was
/// made for. .vdb: the UUID against the content, grid `state` and the metadata. Throws Failure: system
/// (cannot be read), invalid, unsupported (a newer version; no asset at all).
VerifiedAsset verify_asset(const std::filesystem::path &path);

/// Files below `folder` with the ending of an asset, sorted. Throws Failure(invalid) if there is none.
std::vector<std::filesystem::path> assets_in(const std::filesystem::path &folder);

/// Throws Failure(invalid) unless both hold the same cells of the same source.
void verify_twins(const std::filesystem::path &vdb, const std::filesystem::path &voxmap);

} // namespace voxshell
