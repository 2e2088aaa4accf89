// SPDX-License-Identifier: GPL-3.0-or-later
// Cells <-> OpenVDB. The only header through which the tools know that OpenVDB exists.
#pragma once

#include "container/container.hpp"
#include "voxmap/channels.hpp"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace voxshell {

/// A reproducible .vdb: Int32 grid `state` (1 surface, 2 interior, background 0), index (i,j,k) = cell, transform
/// with index (0,0,0) at world (h/2, h/2, h/2) in metres (a voxel below 20 micrometres: in the `unit` that the metadata
/// name), file metadata (`voxel` in metres, `unit`, `source_sha256`, `options`, `closed`), the file's UUID
/// derived from the content instead of OpenVDB's random one. Solid runs become tiles, not voxels. Throws
/// Failure(requirement) if a cell's index does not fit 32 bits. Channels become grids `layer` (Int32) and `distance`
/// (Float, in the transform's unit; a level set if it is signed): active where they speak, else "beyond".
std::vector<std::uint8_t> vdb_bytes(const Cells &cells, const Sha256 &source_hash, const std::string &meta,
                                    const Channels &channels = {});

struct VdbFile {
    Cells cells;
    Channels channels; ///< none by default
    Sha256 source_hash{}; ///< zero if the file names none
    std::string meta;     ///< JSON; "{}" if the file has none
};

/// Reads a `state` grid written by vdb_bytes(), or by another program that kept its meaning (any compression, tiles or
/// voxels). Throws Failure(invalid) for anything that is not one, Failure(system) if the file cannot be read.
/// OpenVDB's reader crashes on damaged files, so it runs in a child process with limited time and memory.
VdbFile read_vdb(const std::filesystem::path &path);

/// Whether the UUID at bytes 21..56 is the one that vdb_bytes() derives from the other bytes: false for a file
/// that is damaged or that another program saved.
bool vdb_uuid_matches(std::span<const std::uint8_t> bytes);

} // namespace voxshell
