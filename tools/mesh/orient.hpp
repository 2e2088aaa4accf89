// SPDX-License-Identifier: GPL-3.0-or-later
// Turns the winding of triangles so that normals point out of the solid. Every step is reported, none is
// silent.
#pragma once

#include "import/scene.hpp"
#include "mesh/winding.hpp"

#include <cstdint>

namespace voxshell {

struct OrientReport {
    std::uint64_t flipped = 0;        ///< triangles whose winding was turned round
    std::uint64_t shells_flipped = 0; ///< shells turned round as a whole (inside-out parts)
};

/// Makes the winding consistent across manifold edges and outward for each edge-connected shell, judged by
/// the winding number on both sides of its faces: the side with the smaller magnitude is outside, so a
/// cavity's wall keeps facing the cavity and an inside-out part is turned. Shells without a clear side (open
/// sheets) keep the orientation of most of their area. Vertices and triangle order stay. Deterministic.
OrientReport orient(Mesh &mesh);

} // namespace voxshell
