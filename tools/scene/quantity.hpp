// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers with their unit, as people write them: "2mm", "5Hz", "500 N/m".
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace voxshell {

enum class Dimension {
    length,
    time,
    frequency,
    angle,
    stiffness,
    foundation,
    mass,
    speed,
    damping,
    force_rate,
    torque_rate,
    force,
    torque,
    acceleration,
    angular_speed,
    angular_damping,
    angular_stiffness,
    inertia,
    density,
    energy,
    per_speed
};

/// The SI value of "NUMBER UNIT" (a space between them is optional), or nothing if it is not a finite number
/// with a unit of that dimension. SI: the unit of the table that is neither a multiple nor a part.
std::optional<double> parse_quantity(std::string_view text, Dimension dimension);

/// The dimension of an SI unit as the runtime's tables write it ("Ns/m"), or nothing for none such.
std::optional<Dimension> dimension_of(std::string_view si_unit);

/// The units of a dimension for a message: "m, mm, cm, um or in".
std::string units_of(Dimension dimension);

} // namespace voxshell
