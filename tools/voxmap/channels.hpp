// SPDX-License-Identifier: GPL-3.0-or-later
// Optional channels of a voxmap: how far a cell is from the surface. Built only when something reads them.
#pragma once

#include "cli/progress.hpp"
#include "mesh/winding.hpp"
#include "voxmap/voxelize.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

/// One element per brick of Cells::bricks, in vxs_voxmap_brick_cell order. Signs: positive outside, negative
/// inside.
struct Channels {
    int layer_count = 0; ///< L; 0: no layers
    /// Ring number around the surface in the Chebyshev metric: 0 surface, +-1..L, +-(L + 1) beyond.
    std::vector<std::array<std::int8_t, 512>> layer;

    double distance_band = 0;       ///< [m]; 0: no distance
    double distance_step = 0;       ///< [m] per unit
    double distance_error = 0;      ///< [m] bound: half a step and the lattice snap
    bool unsigned_distance = false; ///< an open part: no inside
    /// Distance of the cell's centre from the mesh in steps, clamped to the band.
    std::vector<std::array<std::int16_t, 512>> distance;
};

inline constexpr int most_layers = 8, most_distance_cells = 64;

struct ChannelRequest {
    int layers = 0;            ///< L in 0..most_layers
    double distance_cells = 0; ///< band in cells, 0..most_distance_cells
};

/// Adds to `cells` (already classified) the bricks that the channels speak in and computes them. The sign of
/// a surface cell's centre is that of its winding: by exact signed crossings along the cells' rows where the
/// mesh is closed and consistently wound, by the winding number otherwise; a map without interior gets
/// unsigned distance. What this keeps grows with the band; while it works it has, besides, 200 bytes for each
/// brick of a band in the Chebyshev metric. Deterministic for any thread count. Throws Failure(usage) for a
/// reach beyond the most.
Channels make_channels(Cells &cells, const LatticeMesh &mesh, const BrickTriangles &binned,
                       const WindingNumber &winding, bool closed_and_oriented, const ChannelRequest &request,
                       Progress &progress);

} // namespace voxshell
