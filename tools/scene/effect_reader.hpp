// SPDX-License-Identifier: GPL-3.0-or-later
// The guards and effects of a scene, read by the runtime's own table of constants: a new effect needs no line
// here.
#pragma once

#include "scene/json_place.hpp"

#include "voxshell/effect.h"

#include <optional>
#include <string>
#include <vector>

namespace voxshell {

/// What the tick is asked for besides contact and coupling.
struct SceneEffect {
    vxs_effect effect{}; ///< what the scene does not say is as by default
    std::uint32_t said =
        0; ///< bit n: the scene says constant n; what it leaves open a plan may take from elsewhere
    std::string place; ///< JSON pointer
    bool says(std::uint32_t constant) const { return said >> constant & 1; }
};

/// Both lists of a scene, guards first. An item is {"kind": NAME} and the constants of vxs_effect_constants()
/// by name: with its unit in quotes, a plain number where it has none; NAME_x, NAME_y and NAME_z are one list
/// "NAME" of three. Without the list of guards those of vxs_servo_config_default() guard. Refuses by place:
/// unknown kinds and keys, wrong units, what is out of range, a kind that is there twice or in the other
/// list.
std::vector<SceneEffect> read_effects(const std::optional<JsonPlace> &guards,
                                      const std::optional<JsonPlace> &effects);

} // namespace voxshell
