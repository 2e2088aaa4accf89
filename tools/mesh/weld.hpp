// SPDX-License-Identifier: GPL-3.0-or-later
// Vertices at the same place are one: what makes a mesh out of a triangle soup.
#pragma once

#include "import/scene.hpp"

#include <cstdint>
#include <vector>

namespace voxshell {

struct Weld {
    std::vector<std::uint32_t> of; ///< per vertex of the mesh: its number after the weld
    std::uint32_t count = 0;       ///< vertices after the weld, numbered by first appearance
};

/// Joins vertices whose coordinates are equal to the last bit (-0 equals 0). No tolerance: a tolerance
/// would decide what the maker of the file meant. Linear time.
Weld weld(const Mesh &mesh);

} // namespace voxshell
