// SPDX-License-Identifier: GPL-3.0-or-later
// The folder of a batch as one file to carry away: tar, or tar in zstd.
#pragma once

#include "cli/progress.hpp"

#include <filesystem>

namespace voxshell {

/// Writes manifest.json of `folder` and all files in it to `archive` (.tar or .tar.zst), below a folder named
/// as the archive: `tar xf parts.tar.zst` makes parts/, which `voxshell verify --manifest parts` checks.
/// Names are sorted, owners and times left out: the same files make the same bytes (in zstd: with the same
/// libzstd). Each file is hashed on its way. Throws Failure: usage (another ending), system, invalid (a file
/// that is not what the manifest says), interrupted.
void write_archive(const std::filesystem::path &folder, const std::filesystem::path &archive, bool force,
                   Progress &progress);

/// Throws Failure(usage) unless it ends in .tar or .tar.zst, after a name.
void check_archive_name(const std::filesystem::path &archive);

} // namespace voxshell
