// SPDX-License-Identifier: GPL-3.0-or-later
// Mending a mesh. What moves a vertex happens only on request and is counted; the rest is found and told:
// exact weld (mesh/weld.hpp), orientation (mesh/orient.hpp), duplicates and triangles without area
// (mesh/report.hpp) leave every position as it came.
#pragma once

#include "import/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

struct StitchReport {
    std::uint64_t vertices = 0;     ///< border vertices that were moved onto another one
    double farthest = 0;            ///< move [m], at most the tolerance
    std::uint64_t closed_edges = 0; ///< open edges before that are none after
};

/// Closes cracks: each vertex of a border (an edge used an odd number of times) moves onto the nearest
/// earlier border vertex within `tolerance` [m]. Vertices that move keep to the place of the first of them,
/// so nothing creeps; the two ends of an edge are never joined, so no triangle collapses. A vertex in the
/// middle of another's edge (a T-junction with a gap) stays. Triangles stay, positions alone change.
/// Deterministic.
StitchReport stitch(Mesh &mesh, double tolerance);

/// Edges used an odd number of times by a mesh with integer vertices: cracks narrower than a lattice unit are
/// no cracks any more once the mesh is snapped. Coordinates may differ by less than 2^53.
std::uint64_t open_edges(const std::vector<std::array<std::int64_t, 3>> &vertices,
                         const std::vector<Triangle> &triangles);

} // namespace voxshell
