// SPDX-License-Identifier: GPL-3.0-or-later
// Cells <-> .voxmap bytes (formats/voxmap.md).
#pragma once

#include "container/container.hpp"
#include "voxmap/cells.hpp"

#include <filesystem>
#include <string>

namespace voxshell {

struct VoxmapFile {
    Cells cells;
    Sha256 source_hash{};
    std::string meta = "{}"; ///< the META section's JSON text
};

std::vector<std::uint8_t> voxmap_bytes(const VoxmapFile &file);

/// Reads and checks every rule through the runtime's own reader. Throws Failure(invalid) with rule id,
/// section and offset; Failure(system) if the file cannot be read; Failure(unsupported) for a newer major
/// version.
VoxmapFile read_voxmap(const std::filesystem::path &path);

} // namespace voxshell
