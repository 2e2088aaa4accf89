// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "container/container.hpp"

#include <filesystem>
#include <optional>
#include <string_view>

namespace voxshell {

/// SHA-256 of a file, read in pieces; nothing if it cannot be read to its end.
std::optional<Sha256> hash_of_file(const std::filesystem::path &path);

/// The hash of 64 lower-case digits, as hex() writes them; nothing for other text.
std::optional<Sha256> sha256_of_hex(std::string_view digits);

} // namespace voxshell
