// SPDX-License-Identifier: GPL-3.0-or-later
// Files that the program carries: those of page/, and three.js as the build found it (libjs-three).
#pragma once

#include <array>
#include <string_view>

namespace voxshell::embedded {

extern const std::string_view style, body, library, controls, library_licence;
extern const std::array<std::string_view, 9> scripts; ///< in the order in which they stand in a page

} // namespace voxshell::embedded
