// SPDX-License-Identifier: GPL-3.0-or-later
// What is wrong, or right, with a mesh: said before anything is made of it.
#pragma once

#include "import/scene.hpp"

#include <cstdint>

namespace voxshell {

/// Counts are after an exact-position weld (vertices with equal coordinates are one).
struct MeshReport {
    std::uint64_t triangles = 0;
    std::uint64_t degenerate = 0; ///< zero area after the weld (mesh/edges.hpp zero_area())
    std::uint64_t duplicate = 0;  ///< the same three vertices again, in any order
    std::uint64_t boundary_edges =
        0; ///< used by one triangle (degenerate ones left out, but for plugs: mesh/edges.hpp)
    std::uint64_t non_manifold_edges = 0; ///< used by three or more
    std::uint64_t badly_wound_edges = 0;  ///< used by two triangles in the same direction
    std::uint64_t shells = 0;             ///< edge-connected components
    bool closed = false;                  ///< no boundary edge: every edge is used an even number of times
    bool oriented = false;                ///< every edge is used as often in one direction as in the other
    double area = 0;                      ///< [m^2], degenerate triangles count nothing
    double volume = 0; ///< signed, by the divergence theorem about the box's middle [m^3]; 0 for an open mesh
};

MeshReport report(const Mesh &mesh);

} // namespace voxshell
