// SPDX-License-Identifier: GPL-3.0-or-later
// The map of the hard cases, as `hard_suite --csv FILE` writes it: each case on each pair of law and field.
#pragma once

#include "study/study_report.hpp"

#include <filesystem>

namespace voxshell {

struct HardMap {
    StudyTable cases;  ///< a row a case and pair
    StudyTable totals; ///< a row a pair
    StudyFigure figure;
};

/// Throws Failure: system (cannot be read), invalid (not such a map; names the line).
HardMap read_hard_map(const std::filesystem::path &file);

} // namespace voxshell
