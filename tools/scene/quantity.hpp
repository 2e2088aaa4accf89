// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers with their unit, as people write them: "2mm", "5Hz", "500 N/m".
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace voxshell {

enum class Dimension { length, time, frequency, angle, stiffness, foundation, mass, speed, damping, force_rate, torque_rate };

/// The SI value of "NUMBER UNIT" (a space between them is optional), or nothing if it is not a finite number with
/// a unit of that dimension. SI: m, s, Hz, rad, N/m, N/m^3, kg, m/s, Ns/m, N/s, Nm/s.
std::optional<double> parse_quantity(std::string_view text, Dimension dimension);

/// The units of a dimension for a message: "m, mm, cm, um or in".
std::string units_of(Dimension dimension);

} // namespace voxshell
