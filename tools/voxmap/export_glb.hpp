// SPDX-License-Identifier: GPL-3.0-or-later
// The frame of a binary glTF 2.0 file, for those who bring their own JSON.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace voxshell {

/// Throws Failure(requirement) if a file of this many bytes is beyond the format's 4 GiB.
void check_glb_size(std::size_t bytes);

/// Header, JSON chunk, BIN chunk; checks the size.
std::vector<std::uint8_t> glb_bytes(std::string json, std::span<const std::uint8_t> binary);

} // namespace voxshell
