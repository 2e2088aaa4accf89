// SPDX-License-Identifier: GPL-3.0-or-later
// The colours of all pictures, told apart by people who see few colours and in grey (Okabe and Ito 2008).
#pragma once

namespace voxshell::palette {

inline constexpr const char *vermilion = "#d55e00"; ///< the paper's starting point: original
inline constexpr const char *blue = "#0072b2";      ///< what the paper makes of it
inline constexpr const char *green = "#009e73";     ///< ours
inline constexpr const char *amber = "#e69f00";
inline constexpr const char *purple = "#cc79a7";
inline constexpr const char *black = "#000000";
inline constexpr const char *grey = "#707070";
inline constexpr const char *faint = "#d8d8d8"; ///< grids and frames

} // namespace voxshell::palette
