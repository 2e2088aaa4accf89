// SPDX-License-Identifier: GPL-3.0-or-later
// Cells <-> .voxmap bytes (formats/voxmap.md).
#pragma once

#include "cli/progress.hpp"
#include "container/container.hpp"
#include "voxmap/channels.hpp"

#include <filesystem>
#include <string>

namespace voxshell {

struct VoxmapFile {
    Cells cells;
    Channels channels; ///< none by default; else one element per brick of `cells`
    Sha256 source_hash{};
    std::string meta = "{}"; ///< the META section's JSON text
    bool clearance = true;   ///< with what lets the servo loop pass over points far from any surface
};

/// The same bytes for the same cells: a brick without surface that a voxmap without channels may not hold
/// (all free, all interior) becomes a uniform entry, and the box is the smallest. Trusts the counts and the
/// box of `cells` (recount()). The distance band becomes 32767 steps exactly (M210, M402). Throws
/// Failure(requirement) for cells beyond the limits of the format or without surface. `progress`, if given,
/// is asked whether to go on. A file that is moved in costs less memory: each part goes once it is written.
std::vector<std::uint8_t> voxmap_bytes(VoxmapFile file, Progress *progress = nullptr);

/// Reads and checks every rule through the runtime's own reader. Throws Failure(invalid) with rule id,
/// section and offset; Failure(system) if the file cannot be read; Failure(unsupported) for a newer major
/// version.
VoxmapFile read_voxmap(const std::filesystem::path &path);

} // namespace voxshell
