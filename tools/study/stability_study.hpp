// SPDX-License-Identifier: GPL-3.0-or-later
// Where the loop begins to oscillate, as a study: tables, figures, claims.
#pragma once

#include "study/hard_map.hpp"
#include "study/stability_run.hpp"
#include "study/study_report.hpp"

#include <filesystem>

namespace voxshell {

struct StabilityOptions {
    bool quick = false;
    std::filesystem::path hard_map; ///< what hard_suite --csv wrote; empty: the page goes without
};

std::vector<StudyTable> stability_tables(const StabilityRuns &runs);
std::vector<StudyFigure> stability_figures(const StabilityRuns &runs);
/// `study` has its tables.
std::vector<StudyClaim> stability_claims(const Study &study);

/// Runs it all. command: what stands under the pictures. Throws Failure(invalid) for a map of hard cases that
/// is none.
Study stability_study(const StabilityOptions &options, const std::string &command, Progress &progress);

} // namespace voxshell
