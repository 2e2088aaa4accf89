// SPDX-License-Identifier: GPL-3.0-or-later
// The pointshell offline: what projection makes and the writer takes (method section 2).
#pragma once

#include "cli/progress.hpp"
#include "voxmap/voxelize.hpp"
#include "voxshell/format/pointshell.h"

#include <cstdint>
#include <vector>

namespace voxshell {

enum class ShellKind : std::uint32_t { exact = VXS_POINTSHELL_EXACT, naive = VXS_POINTSHELL_NAIVE };

struct ShellPoint {
    std::array<float, 3> position; ///< [m], part frame
    std::array<float, 3> normal;   ///< unit, inwards
    float area;                    ///< [m^2]
    std::uint32_t brick;           ///< index into Cells::bricks of the cell the point belongs to
    std::uint16_t cell;            ///< within the brick, vxs_voxmap_brick_cell order
};

struct Cluster {
    std::array<float, 3> center;
    float radius;
    std::uint32_t first, count;
};

struct Shell {
    ShellKind kind = ShellKind::exact;
    double voxel = 0;
    std::vector<ShellPoint> points; ///< in cluster order: a pure function of the input
    std::vector<Cluster> clusters;
    double area = 0;          ///< sum of weights [m^2]
    double gap_max = 0;       ///< largest distance between points of face- or edge-adjacent surface cells [m]
    double surface_error = 0; ///< largest distance of a stored (rounded) point from the mesh [m]
    std::array<double, 3> center{};
    double radius = 0;
    std::uint64_t surface_cells = 0;
};

/// The shell of the cells that `mesh` marked.
///   exact  per surface cell the point of the mesh inside the cell that is nearest to the cell's centre;
///          where the area-weighted mean normal nearly cancels, one point per side (method section 2).
///   naive  the cell's centre (McNeely 1999), same normals and weights.
/// The winding is taken as it is (counter-clockwise seen from outside): orient the mesh first (mesh/orient.hpp).
/// Deterministic for any thread count.
Shell make_shell(const LatticeMesh &mesh, const BrickTriangles &binned, const Cells &cells, ShellKind kind,
                 Progress &progress);

} // namespace voxshell
