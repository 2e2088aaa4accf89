// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of a coupling's design: Bode, Nyquist and impedance, each with the numbers that it shows as CSV.
#pragma once

#include "plan/design.hpp"
#include "study/gnuplot.hpp"

#include <string>
#include <vector>

namespace voxshell {

struct DesignPlot {
    std::string name;   ///< "bode", "nyquist", "impedance"
    std::string csv;    ///< first column hz, then so many of each arm, named NAME_ARM_UNIT
    std::string script; ///< of gnuplot, but for the sheet
    int width, height;
    std::vector<std::uint8_t> draw(Picture picture) const;
};

/// command: what makes the pictures again; stands under each.
///   bode       loop gain and phase of each arm over frequency
///   nyquist    the same in the plane, near the point -1
///   impedance  what the hand feels: size, and the real part (with all that sampling adds, Colgate) that says
///   where the
///              loop gives energy away
std::vector<DesignPlot> plot_design(const Design &design, const std::string &command);

} // namespace voxshell
