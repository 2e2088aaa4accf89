// SPDX-License-Identifier: GPL-3.0-or-later
// The front page of several studies.
#pragma once

#include "pipeline/output.hpp"

#include <filesystem>

namespace voxshell {

/// FOLDER/index.html: each of the folders in it that has a study's summary.json and index.html, by name, with
/// its command, what does not hold, and its first figure. Throws Failure: system (none there, or cannot be
/// read), invalid (a summary that is none; names the file).
void write_study_index(const std::filesystem::path &folder, Outputs &outputs);

} // namespace voxshell
