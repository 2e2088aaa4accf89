// SPDX-License-Identifier: GPL-3.0-or-later
// Exact winding of cell centres: signed crossings of the mesh with the rows of centres along k.
#pragma once

#include "cli/progress.hpp"
#include "voxmap/cells.hpp"
#include "voxmap/dilate.hpp"

#include <cstdint>
#include <utility>
#include <vector>

namespace voxshell {

/// For a closed, consistently wound mesh the winding number of a cell's centre is the sum of the signed
/// crossings of the row of centres through it, below the centre. Which triangle a row through a shared edge
/// or vertex crosses is decided by an infinitesimal shift of the row (e along i, e^2 along j), the same for
/// all triangles: all in integers.
class Crossings {
  public:
    /// `cells`: holds every surface cell of the mesh.
    Crossings(const LatticeMesh &mesh, const Cells &cells, Progress &progress);
    /// Adds to `inside` the surface cells of a brick of `cells` whose centres' winding is not 0.
    void mark(const Brick &brick, CellMask &inside) const;

  private:
    struct Crossing {
        std::int32_t k;   ///< first cell whose centre lies above the crossing
        std::int32_t sum; ///< winding from there on
        auto operator<=>(const Crossing &) const = default;
    };
    using Column = std::pair<std::int32_t, std::int32_t>; ///< (i, j) of bricks
    template<class Visit>
    void each_rows(const LatticeMesh &mesh, std::size_t triangle, Progress &progress, Visit &&visit) const;

    Cell origin_;
    std::vector<Column> columns_;      ///< sorted
    std::vector<std::uint32_t> start_; ///< of row 64 c + 8 i + j of column c: [start_[row], start_[row + 1])
    std::vector<Crossing> crossings_;  ///< a row's in ascending order
};

} // namespace voxshell
