// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "container/container.hpp"

#include <filesystem>
#include <optional>

namespace voxshell {

/// SHA-256 of a file, read in pieces; nothing if it cannot be read to its end.
std::optional<Sha256> hash_of_file(const std::filesystem::path &path);

} // namespace voxshell
