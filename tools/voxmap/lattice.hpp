// SPDX-License-Identifier: GPL-3.0-or-later
// The integer lattice on which every decision about cells is made (method section 1).
#pragma once

#include "import/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

using Cell = std::array<std::int64_t, 3>;         ///< cell indices (i, j, k) in the scene frame
using LatticePoint = std::array<std::int64_t, 3>; ///< in units of voxel / 65536, scene frame

inline constexpr int lattice_bits = 16;
inline constexpr std::int64_t lattice_per_cell = std::int64_t{1} << lattice_bits;

/// A mesh whose vertices were snapped once to the lattice voxel/65536 (at most voxel/131072 away
/// per axis). Triangles that are degenerate after the snap stay: they still mark the cells they touch.
struct LatticeMesh {
    double voxel = 0; ///< edge h of a cell [m]
    std::vector<LatticePoint> vertices;
    std::vector<Triangle> triangles;
    Cell min{}, max{}; ///< cells of the bounding box, max inclusive
};

/// Snaps. Throws Failure(requirement) naming the smallest voxel that fits, if the box would exceed
/// the limits of the format (formats/voxmap.md M204, M205) or of the lattice (|cell| < 2^44).
LatticeMesh snap(const Mesh &mesh, double voxel);

} // namespace voxshell
