// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/accuracy_study.hpp"

#include "cli/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace voxshell {
namespace {

constexpr PathOptions full_path{96, 12, 256, 6e6}, quick_path{32, 6, 96, 1e6};
constexpr PathOptions check_path{6, 6, 8, 1e6, 3}; ///< of the own scenes, beside another one

std::string lengths_text(const std::vector<AccuracyRow> &rows)
{
    std::string text;
    double last = 0;
    for (const AccuracyRow &row : rows) {
        if (row.config.voxel == last) continue;
        last = row.config.voxel;
        text += (text.empty() ? "" : ", ") + format_length(last);
    }
    return text;
}

} // namespace

double tick_seconds(const AccuracyResult &result, std::size_t row)
{
    return 1e-9 * result.rows[row].tick.p999 * result.scene.evaluations;
}

Advice advise(const AccuracyResult &result, const AccuracyQuestion &question)
{
    Advice advice{};
    const std::vector<AccuracyRow> &rows = result.rows;
    const auto time = [&](std::size_t n) { return tick_seconds(result, n); };
    const double budget = question.budget.value_or(question.error ? std::numeric_limits<double>::infinity()
                                                                  : 1 / result.scene.rate);
    for (std::size_t n = 0; n < rows.size(); ++n) {
        if (time(n) < time(advice.fastest)) advice.fastest = n;
        if (rows[n].error < rows[advice.best].error) advice.best = n;
        if (time(n) > budget || (question.error && rows[n].error > *question.error)) continue;
        const bool is_taken = !advice.taken || (question.error ? time(n) < time(*advice.taken)
                                                               : rows[n].error < rows[*advice.taken].error);
        if (is_taken) advice.taken = n;
    }
    if (!advice.taken) return advice;
    for (std::size_t n = 0; n < rows.size(); ++n) {
        if (rows[n].error < rows[*advice.taken].error && (!advice.better || time(n) < time(*advice.better)))
            advice.better = n;
    }
    return advice;
}

std::vector<std::size_t> front(const AccuracyResult &result, double (*cost)(const AccuracyRow &))
{
    std::vector<std::size_t> order(result.rows.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        const double x = cost(result.rows[a]), y = cost(result.rows[b]);
        return x != y ? x < y : result.rows[a].error < result.rows[b].error;
    });
    std::vector<std::size_t> kept;
    for (const std::size_t n : order) {
        if (kept.empty() || result.rows[n].error < result.rows[kept.back()].error) kept.push_back(n);
    }
    return kept;
}

std::vector<AccuracyConfig> step_bases(const AccuracyScene &scene)
{
    return {{scene.voxel, {ShellKind::naive, VXS_CONTACT_ORIGINAL, VXS_CONTACT_SURFACE, VXS_CONTACT_COUNT}},
            {scene.voxel, {ShellKind::exact, VXS_CONTACT_ORIGINAL, VXS_CONTACT_DISTANCE, VXS_CONTACT_AREA}}};
}

AccuracyResult run_accuracy_study(const AccuracyScene &scene, const AccuracyOptions &options,
                                  FinishedWork &work, Progress &progress)
{
    AccuracyResult result;
    result.scene = scene;
    progress.stage("reference", 0);
    result.path = accuracy_path(scene, options.quick ? quick_path : full_path, work, progress);
    const auto told = [](const std::string &name, const AccuracyPath &path) {
        return ReferenceRow{name,         static_cast<double>(path.times.size()),
                            path.deepest, path.spacing,
                            path.halving, path.apart};
    };
    result.references.push_back(told(scene.name, result.path));
    for (const std::string &name : own_scenes()) {
        if (name != scene.name) {
            const AccuracyScene own = accuracy_scene(name);
            result.references.push_back(told(name, accuracy_path(own, check_path, work, progress)));
        }
    }
    const std::vector<AccuracyConfig> bases = step_bases(scene);
    const std::size_t voxels = accuracy_voxels(scene, result.path, options).size();
    progress.stage("accuracy",
                   voxels * valid_methods().size() + 2 + 4 + bases.size() + scale_rows(options.quick));
    result.rows = run_accuracy(scene, result.path, options, work, progress);
    StepAssets assets(scene, result.path, progress);
    result.culling = run_culling(scene, result.path, assets, work, progress);
    result.rounding = run_rounding(scene, result.path, assets, work, progress);
    result.filter = run_filter(scene, result.path, bases, assets, work, progress);
    result.scale = run_scale(scene, result.path, options.quick, work, progress);
    return result;
}

Study accuracy_study(const AccuracyResult &result, const AccuracyOptions &options,
                     const AccuracyQuestion &question, const std::string &command)
{
    const AccuracyPath &path = result.path;
    Study study;
    study.name = "accuracy";
    study.title = fmt::format("{}: what accuracy costs in time", result.scene.name);
    study.lead = fmt::format(
        "The shipped servo goes along the hand's path of {} with {} configurations; each tick that is timed "
        "is one "
        "whose force counts. {} poses, evenly spaced along the way wherever the body touches and is not so "
        "deep that, "
        "half a voxel further, the nearest way out is another one: {:.0f} % of the path, up to {} deep. The "
        "force that ought to be there "
        "is an elastic foundation on the body's own surface in the mesh's own distance (CGAL, no cells, no "
        "points). "
        "Laws differ in what they call stiffness: one factor on all wrenches of a configuration is left "
        "free, by "
        "least squares. The error is the rms of what is left of force and torque / {}, in percent of the rms "
        "of the "
        "force that ought to be. A tick is vxs_servo_tick() with contact alone, the least of three passes.",
        result.scene.given, result.rows.size(), path.times.size(), 100 * path.usable,
        format_length(path.deepest), format_length(path.radius));
    study.command = command;
    study.options = {{"quick", options.quick ? "yes" : "no"},
                     {"scene", result.scene.given},
                     {"voxels", lengths_text(result.rows)},
                     {"poses", fmt::format("{}", path.times.size())}};
    if (question.budget) study.options.emplace_back("budget_us", fmt::format("{:g}", 1e6 * *question.budget));
    if (question.error) study.options.emplace_back("error_pct", fmt::format("{:g}", 100 * *question.error));
    const Advice advice = advise(result, question);
    study.tables = accuracy_tables(result, advice);
    study.figures = accuracy_figures(result, advice, study);
    study.claims = accuracy_claims(result, study);
    study.answers = {accuracy_answer(result, question, advice, study)};
    return study;
}

} // namespace voxshell
