// SPDX-License-Identifier: GPL-3.0-or-later
// Shell <-> .pointshell bytes (formats/pointshell.md).
#pragma once

#include "container/container.hpp"
#include "pointshell/shell.hpp"

#include <filesystem>
#include <string>

namespace voxshell {

struct PointshellFile {
    Shell shell; ///< ShellPoint::brick and ::cell are not stored: 0 after reading
    Sha256 source_hash{};
    std::string meta = "{}"; ///< the META section's JSON text
    bool areas = true;       ///< the points' areas are stored; without, ShellPoint::area is 0 after reading
};

/// `progress`, if given, is asked whether to go on.
std::vector<std::uint8_t> pointshell_bytes(const PointshellFile &file, Progress *progress = nullptr);

/// As read_voxmap().
PointshellFile read_pointshell(const std::filesystem::path &path);

} // namespace voxshell
