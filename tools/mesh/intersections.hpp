// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles of a mesh that cut each other.
#pragma once

#include "cli/progress.hpp"
#include "import/scene.hpp"

#include <cstdint>
#include <optional>

namespace voxshell {

/// Number of triangles that meet another one elsewhere than at a vertex or an edge that both have (vertices
/// at the same place are one): that pierce it, touch it, or lie on it. Duplicates of a triangle are no such
/// case, nor are triangles without area (mesh/report.hpp counts both). Decided exactly on the coordinates as
/// they are. Nothing, if more than `pairs` pairs of boxes overlap: then it would take too long (some 10^7
/// pairs a second).
std::optional<std::uint64_t> self_intersections(const Mesh &mesh, std::uint64_t pairs, Progress &progress);

} // namespace voxshell
