// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures by gnuplot, run as a program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

enum class Picture { svg, png };

/// By the ending of the file; throws Failure(usage) for any other.
Picture picture_of(const std::filesystem::path &file);

/// The script's first lines: a white sheet of width x height points, with letters of 15 points and grey axes.
std::string gnuplot_sheet(Picture picture, int width, int height);

/// Several panels on a sheet of this height, down row by row: room for titles, tics, the axis' name and the
/// command is the same number of points on every sheet. `left` and `across` are shares of the width.
std::string gnuplot_panels(int height, int rows, int columns, double across = 0.09, double title_lines = 1,
                           double left = 0.095);

/// The command that makes a sheet again, at its foot; and after the first of several panels: once is enough.
std::string gnuplot_command(const std::string &command, int height);
inline constexpr const char *gnuplot_said_once = "unset label 100\n";

/// A string of the script, whatever is in the text.
std::string gnuplot_text(const std::string &text);

/// What the script draws. Thread-safe. Throws Failure: system (gnuplot is not installed or fails),
/// interrupted (it was ended by SIGINT or SIGTERM).
std::vector<std::uint8_t> gnuplot(const std::string &script);

} // namespace voxshell
