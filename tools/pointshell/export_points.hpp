// SPDX-License-Identifier: GPL-3.0-or-later
// A pointshell for people and other programs.
#pragma once

#include "pointshell/pointshell_file.hpp"

#include <functional>
#include <string_view>

namespace voxshell {

/// `x,y,z,nx,ny,nz,area` [m, m^2], one line per point in the shell's order; each number reads back as the
/// same float. Here and below there is no area where the file has none.
void points_csv(const PointshellFile &file, const std::function<void(std::string_view)> &sink);

/// Binary little-endian PLY, vertex properties x y z nx ny nz area (float; m, m^2).
void points_ply(const PointshellFile &file, const std::function<void(std::string_view)> &sink);

/// glTF 2.0 binary: one primitive of points with POSITION [m], NORMAL and _AREA [m^2].
std::vector<std::uint8_t> points_glb(const PointshellFile &file);

} // namespace voxshell
