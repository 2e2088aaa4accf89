// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace voxshell {

/// A scene with a comment on everything that it could say, of cup.glb and sphere.glb beside it; guards and
/// effects as the runtime's table has them.
std::string example_scene();

} // namespace voxshell
