// SPDX-License-Identifier: GPL-3.0-or-later
// How many cubes the unconnected pieces of a mesh occupy: what a dust of triangles costs, whose area says
// nothing.
#pragma once

#include "import/scene.hpp"

#include <array>

namespace voxshell {

/// Pieces are connected by common vertices (equal to the last bit).
class Pieces {
  public:
    explicit Pieces(const Mesh &mesh); ///< linear time, but for sorting the vertices
    /// Cubes of edge `size` [m] of a grid that the pieces meet, from above, beyond those of the formula for
    /// their area: on average one for a piece, and one for each `size` of its extent along each axis (the
    /// volume of the sum of a convex piece and a cube is that of its three shadows, plus that); but no more
    /// than there are where the pieces are.
    double cubes(double size) const;

  private:
    static constexpr int levels = 21;
    double count_ = 0, extent_ = 0, span_ = 0;
    std::array<double, levels + 1> boxes_{}; ///< of edge span / 2^level that hold a vertex
};

} // namespace voxshell
