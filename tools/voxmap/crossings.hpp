// SPDX-License-Identifier: GPL-3.0-or-later
// Exact winding of cell centres: signed crossings of the mesh with the rows of centres along k.
#pragma once

#include "cli/progress.hpp"
#include "voxmap/cells.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

/// For a closed, consistently wound mesh the winding number of a cell's centre is the sum of the signed
/// crossings of the row of centres through it, below the centre. Which triangle a row through a shared edge
/// or vertex crosses is decided by an infinitesimal shift of the row (e along i, e^2 along j), the same for
/// all triangles: all in integers.
class Crossings {
  public:
    Crossings() = default;
    Crossings(const LatticeMesh &mesh, const Cells &cells, Progress &progress);
    /// Winding of the centre of cell `local` (0..7 per axis) of brick `at` (relative to the cells' origin).
    int winding(const BrickAt &at, const int local[3]) const;

  private:
    struct Crossing {
        std::uint64_t row; ///< i << 32 | j, cells relative to the origin
        std::int32_t k;    ///< first cell whose centre lies above the crossing
        std::int32_t sum;  ///< winding from there on
    };
    std::vector<Crossing> crossings_; ///< sorted by row, then k
};

} // namespace voxshell
