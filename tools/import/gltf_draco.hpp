// SPDX-License-Identifier: GPL-3.0-or-later
// Inside the reader of Draco payloads: what both of its processes agree on. Others include import/gltf.hpp.
#pragma once

#include "import/gltf.hpp"

namespace voxshell {

class Answers;

/// What the child says first.
struct DracoAnswer {
    std::uint64_t text; ///< [bytes] why not; none: two lists follow
    std::uint64_t points, positions, faces;
};

/// Decodes with Draco's own reader, in the calling process: a damaged payload can keep it busy for minutes or
/// take all memory. Throws Failure or std::exception.
DracoMesh parse_draco(std::span<const std::uint8_t> payload, std::optional<std::uint32_t> position,
                      std::uint64_t max_points);

/// What the child answers, or Failure: nothing of it is believed, and no more than the two limits is taken.
DracoMesh receive_draco(Answers &answers, bool has_position, std::uint64_t max_faces,
                        std::uint64_t max_points);

} // namespace voxshell
