// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's experiments and ours beside them, as a study: tables, figures, claims.
#pragma once

#include "study/paper_run.hpp"
#include "study/study_report.hpp"

namespace voxshell {

/// Tables of all runs and of their means over the seeds. Percentages are of the mean normal force; a run
/// without force, or without any force across, is degenerate: it counts in no mean.
std::vector<StudyTable> paper_tables(const PaperRuns &runs);
/// How long a tick took: not the same on every run.
std::vector<StudyTable> paper_timings(const PaperRuns &runs);
/// How the error of the force spreads over time and frequency.
StudyFigure figure_spectrum(const PaperRuns &runs);
std::vector<StudyFigure> paper_figures(const PaperRuns &runs, const Study &study);
/// `study` has its tables.
std::vector<StudyClaim> paper_claims(const Study &study);

/// Runs it all. command: what stands under the pictures.
Study paper_study(const PaperOptions &options, const std::string &command, Progress &progress);

} // namespace voxshell
