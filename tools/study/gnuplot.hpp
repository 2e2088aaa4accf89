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

/// A string of the script, whatever is in the text.
std::string gnuplot_text(const std::string &text);

/// What the script draws. Throws Failure(system) if gnuplot is not installed or fails.
std::vector<std::uint8_t> gnuplot(const std::string &script);

} // namespace voxshell
