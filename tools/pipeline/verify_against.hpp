// SPDX-License-Identifier: GPL-3.0-or-later
// Cells and points measured again on the mesh that they came from, by other means than those that made them:
// distances in doubles, clipping instead of separating axes, winding numbers on both sides of a point.
#pragma once

#include "cli/progress.hpp"
#include "import/scene.hpp"
#include "pointshell/shell.hpp"
#include "voxmap/voxmap_file.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace voxshell {

/// One thing measured at many places: the worst figure, and whether it keeps its bound.
struct Measure {
    std::string what; ///< "point to mesh"
    std::string unit; ///< "m", "m^2", "1" (a share), "cells" ...
    double worst = 0;
    double bound = 0;         ///< worst <= bound is right
    std::uint64_t places = 0; ///< that were measured
    std::uint64_t beyond = 0; ///< of these, beyond the bound
    Point at{};               ///< of the worst, where beyond > 0 [m]
    bool binding = true;      ///< false: told, but no reason to fail (an open mesh has no inside)
    bool holds() const { return !binding || worst <= bound; }
};

/// What was asked for when the asset was made and widens a bound.
struct MadeWith {
    double weld = 0;      ///< corners were moved by up to this [m]
    bool thinned = false; ///< one point may stand for a block of 2 x 2 x 2 cells
    bool areas = true;    ///< of points, and not only of the shell
};

/// `mesh`: the part as imported and flattened.
///   each surface cell, widened by the lattice's snap, is met by a triangle;
///   each sample of the surface (corners, centroids, about four per h^2 on large triangles) is in a surface
///   cell; cells beside the surface are interior exactly where the winding number's magnitude is at least
///   1/2; channels: a sample of the distances, and of the rings around the surface.
std::vector<Measure> verify_cells(const VoxmapFile &file, const Mesh &mesh, const MadeWith &made,
                                  Progress &progress);

/// Distance of each point from the mesh, of each sample of the surface from a point, unit normals, normals
/// inwards by winding number, total area, distance between points of adjacent cells.
std::vector<Measure> verify_points(const Shell &shell, const Mesh &mesh, const MadeWith &made,
                                   Progress &progress);

} // namespace voxshell
