// SPDX-License-Identifier: GPL-3.0-or-later
// Cells for people and other programs: a table and pictures.
#pragma once

#include "voxmap/voxmap_file.hpp"

#include <functional>
#include <string_view>

namespace voxshell {

/// Takes a file piece by piece.
using TextSink = std::function<void(std::string_view)>;

/// `i,j,k,state[,layer][,distance_m]`, one line per surface (1) or interior (2) cell, sorted by i, j, k.
void cells_csv(const VoxmapFile &file, const TextSink &sink);

/// The skin of the surface cells: one quad between a surface cell and each free cell beside it,
/// counter-clockwise seen from the free cell. Corners are shared and sorted by (i, j, k).
struct CellSkin {
    std::vector<Cell> corners;                       ///< absolute: corner (i,j,k) is at h (i, j, k)
    std::vector<std::array<std::uint32_t, 4>> quads; ///< indices of corners, in brick order
};

/// Throws Failure(requirement) for more than 2^31 corners.
CellSkin skin(const Cells &cells);

/// Binary little-endian PLY: vertices x y z (double, [m]), faces of four vertex_indices.
void cells_ply(const Cells &cells, const TextSink &sink);

/// glTF 2.0 binary: the skin as triangles [m], its node moved to the map's corner so that floats stay exact.
/// Throws Failure(requirement) beyond the format's 4 GiB.
std::vector<std::uint8_t> cells_glb(const Cells &cells);

} // namespace voxshell
