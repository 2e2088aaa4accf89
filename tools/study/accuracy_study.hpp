// SPDX-License-Identifier: GPL-3.0-or-later
// What accuracy costs in time: for a scene, over voxel edge, shell, law, field and weighting, error beside
// time, bytes and conversion; what each step costs and buys; and which configuration to take.
#pragma once

#include "study/accuracy_run.hpp"
#include "study/accuracy_steps.hpp"
#include "study/study_report.hpp"

#include <optional>

namespace voxshell {

/// What is asked: the most accurate configuration within a budget, or the fastest within an error. By the
/// tick's p99.9, times the evaluations that the scene's coupling makes of it: a servo's deadline is missed by
/// rare ticks, and the largest of all is one of the system's interruptions.
struct AccuracyQuestion {
    std::optional<double> budget; ///< [s]; nothing, and no error either: a tick of the scene's rate
    std::optional<double> error;  ///< a share
};

/// How the formulas' own scenes agree with the mesh's distance.
struct ReferenceRow {
    std::string scene;
    double poses, deepest, spacing, halving, apart; ///< apart: NaN without a formula
};

struct AccuracyResult {
    AccuracyScene scene;
    AccuracyPath path;
    std::vector<ReferenceRow> references; ///< the scene's first
    std::vector<AccuracyRow> rows;
    std::vector<CullingRow> culling;
    std::vector<RoundingRow> rounding;
    std::vector<FilterRow> filter;
    std::vector<ScaleRow> scale;
};

struct Advice {
    std::optional<std::size_t> taken, better; ///< rows; better: the cheapest that is more accurate
    std::size_t fastest, best;                ///< of all
};
/// [s] that a tick takes by p99.9.
double tick_seconds(const AccuracyResult &result, std::size_t row);
Advice advise(const AccuracyResult &result, const AccuracyQuestion &question);

/// Runs it all; `state`: file that keeps what is done, gone at the end only by FinishedWork::remove().
AccuracyResult run_accuracy_study(const AccuracyScene &scene, const AccuracyOptions &options,
                                  FinishedWork &work, Progress &progress);

std::vector<StudyTable> accuracy_tables(const AccuracyResult &result, const Advice &advice);
std::vector<StudyFigure> accuracy_figures(const AccuracyResult &result, const Advice &advice,
                                          const Study &study);
std::vector<StudyClaim> accuracy_claims(const AccuracyResult &result, const Study &study);
StudyClaim accuracy_answer(const AccuracyResult &result, const AccuracyQuestion &question,
                           const Advice &advice, const Study &study);

/// `study` of it. Nothing holds the question: Study::answers says so, and so does answer_holds().
Study accuracy_study(const AccuracyResult &result, const AccuracyOptions &options,
                     const AccuracyQuestion &question, const std::string &command);

/// Configurations that no other one beats in both: rows of `cost` ascending.
std::vector<std::size_t> front(const AccuracyResult &result, double (*cost)(const AccuracyRow &));

/// The configurations that steps are counted from: McNeely's, and one whose field is deep enough for the
/// path.
std::vector<AccuracyConfig> step_bases(const AccuracyScene &scene);

} // namespace voxshell
