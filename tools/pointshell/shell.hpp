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

/// What thinning (thin.hpp) did, and what it cost.
struct Thinning {
    double angle = 0; ///< as asked for [rad]; 0: not thinned
    std::uint64_t points_before = 0;
    double gap_before = 0;   ///< [m]
    double distance_max = 0; ///< of a point left out from the one that stands for it [m]
    double normal_max = 0;   ///< angle between the normals of these two [rad]
};

struct Shell {
    ShellKind kind = ShellKind::exact;
    double voxel = 0;
    std::vector<ShellPoint> points; ///< in cluster order: a pure function of the input
    std::vector<Cluster> clusters;
    double area = 0; ///< sum of weights [m^2]
    /// Largest distance between points of face- or edge-adjacent surface cells [m]; where another point
    /// stands for a cell (thin.hpp), that one's.
    double gap_max = 0;
    double surface_error = 0; ///< largest distance of a stored (rounded) point from the mesh [m]
    std::array<double, 3> center{};
    double radius = 0;
    std::uint64_t surface_cells = 0; ///< that hold a point
    Thinning thinning;               ///< not stored: as made
};

/// The shell of the cells that `mesh` marked.
///   exact  per surface cell the point of the mesh inside the cell that is nearest to the cell's centre;
///          where the area-weighted mean normal nearly cancels, one point per side (method section 2).
///   naive  the cell's centre (McNeely 1999), same normals and weights.
/// The winding is taken as it is (counter-clockwise seen from outside): orient the mesh first
/// (mesh/orient.hpp). `thin_angle` [rad]: how much normals may differ for one point to stand for several
/// cells (thin.hpp); 0: a point for each. Deterministic for any thread count.
Shell make_shell(const LatticeMesh &mesh, const BrickTriangles &binned, const Cells &cells, ShellKind kind,
                 Progress &progress, double thin_angle = 0);

} // namespace voxshell
