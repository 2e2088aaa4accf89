// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell study: whole studies with the shipped runtime, as CSV, pictures and one page.
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "container/container.hpp"
#include "scene/quantity.hpp"
#include "study/accuracy_study.hpp"
#include "study/gnuplot.hpp"
#include "study/paper_study.hpp"
#include "study/stability_study.hpp"
#include "study/study_index.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <memory>
#include <span>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

struct StudyOptions : SharedOptions {
    std::string kind, scene, out, hard_map;
    std::string budget, error;       ///< accuracy
    std::vector<std::string> voxels; ///< accuracy; none: by the scene's
    unsigned seeds = 0;              ///< 0: as many as the study says
    bool quick = false;
};

constexpr unsigned paper_seeds = 10, quick_seeds = 2;

/// The sentence with its numbers.
std::string told(const StudyClaim &claim)
{
    std::string text;
    std::size_t next = 0;
    for (const char c : claim.measured) {
        if (c == '@' && next < claim.numbers.size()) {
            const StudyNumber &n = claim.numbers[next++];
            text += fmt::format(fmt::runtime(n.format), n.value);
        } else {
            text += c;
        }
    }
    return text;
}

/// Its files, and which claims hold.
ExitCode finish(const Study &study, const StudyOptions &o, Progress &progress)
{
    Outputs outputs(o.force);
    write_study(study, o.out, outputs, progress);
    progress.check();
    outputs.commit();
    if (o.json) {
        fmt::print("{}", study_json(study));
        return ExitCode::ok;
    }
    for (const Verdict verdict : {Verdict::fails, Verdict::partly, Verdict::holds}) {
        for (const StudyClaim &claim : study.claims) {
            if (claim.verdict == verdict) fmt::print("{:<14} {}\n", verdict_text(verdict), claim.claim);
        }
    }
    for (const StudyClaim &answer : study.answers) fmt::print("{}: {}\n", answer.claim, told(answer));
    fmt::print("{}\n", (fs::path(o.out) / "index.html").string());
    return ExitCode::ok;
}

ExitCode paper(const StudyOptions &o, Progress &progress)
{
    const PaperOptions options{o.seeds ? o.seeds : o.quick ? quick_seeds : paper_seeds, o.quick};
    const std::string command =
        fmt::format("voxshell study paper -o DIR{} --seeds {}", o.quick ? " --quick" : "", options.seeds);
    return finish(paper_study(options, command, progress), o, progress);
}

ExitCode stability(const StudyOptions &o, Progress &progress)
{
    const std::string command =
        fmt::format("voxshell study stability -o DIR{}{}", o.quick ? " --quick" : "",
                    o.hard_map.empty() ? "" : " --hard-map " + fs::path(o.hard_map).filename().string());
    return finish(stability_study({o.quick, o.hard_map}, command, progress), o, progress);
}

ExitCode index(const StudyOptions &o, Progress &progress)
{
    Outputs outputs(o.force);
    write_study_index(o.out, outputs);
    progress.check();
    outputs.commit();
    fmt::print("{}\n", (fs::path(o.out) / "index.html").string());
    return ExitCode::ok;
}

double parse_percent(const std::string &text)
{
    double value = 0;
    const char *end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data(), end, value);
    if (error != std::errc() || at + 1 != end || *at != '%' || !(value > 0 && value <= 100))
        throw Failure(ExitCode::usage, "",
                      "--error: \"" + text + "\" is no share between 0% and 100%, as 1%");
    return value / 100;
}

/// What is done so far stays in the folder until all is: interrupted, the same command goes on.
ExitCode accuracy(const StudyOptions &o, Progress &progress)
{
    AccuracyQuestion question;
    if (!o.budget.empty()) {
        question.budget = parse_quantity(o.budget, Dimension::time);
        if (!question.budget || !(*question.budget > 0))
            throw Failure(ExitCode::usage, "", "--budget: \"" + o.budget + "\" is no time above 0, as 0.2ms");
    }
    if (!o.error.empty()) question.error = parse_percent(o.error);
    AccuracyOptions options;
    options.quick = o.quick;
    for (const std::string &voxel : o.voxels) options.voxels.push_back(parse_length(voxel));
    std::sort(options.voxels.begin(), options.voxels.end(), std::greater<>());
    options.voxels.erase(std::unique(options.voxels.begin(), options.voxels.end()), options.voxels.end());
    const fs::path folder(o.out), page = folder / "index.html";
    if (!o.force && fs::exists(page))
        throw Failure(ExitCode::system, page.string(),
                      "exists, and times would be others; --force overwrites");
    const AccuracyScene scene = accuracy_scene(o.scene);
    std::string command = fmt::format("voxshell study accuracy {} -o DIR{}", scene.given,
                                      o.quick ? " --quick" : ""),
                inputs = fmt::format("{} {} {}", tool_version(), scene.hash, o.quick);
    for (const double voxel : options.voxels) {
        command += fmt::format(" --voxel {:g}mm", 1e3 * voxel);
        inputs += fmt::format(" {}", voxel);
    }
    if (question.budget) command += " --budget " + o.budget;
    if (question.error) command += " --error " + o.error;
    const auto bytes = std::span(reinterpret_cast<const std::uint8_t *>(inputs.data()), inputs.size());
    FinishedWork work(folder / "accuracy.state", hex(sha256(bytes)));
    const AccuracyResult result = [&] {
        try {
            return run_accuracy_study(scene, options, work, progress);
        } catch (const Failure &failure) {
            if (failure.code == ExitCode::interrupted) {
                fmt::print(stderr,
                           "voxshell study: {} rows are kept in {}; the same command goes on from there\n",
                           work.size(), (folder / "accuracy.state").string());
            } else if (work.size() == 0) {
                work.remove();
            }
            throw;
        }
    }();
    const Study study = accuracy_study(result, options, question, command);
    finish(study, o, progress);
    work.remove();
    const Advice advice = advise(result, question);
    if (!advice.taken)
        throw Failure(
            ExitCode::requirement, o.scene,
            fmt::format(
                "no configuration that was tried holds that: the fastest takes {:.3g} us at p99.9, the "
                "most accurate errs by {:.3g} %",
                1e6 * tick_seconds(result, advice.fastest), 100 * result.rows[advice.best].error));
    return ExitCode::ok;
}

} // namespace

VerbAction add_study(CLI::App &verb)
{
    auto o = std::make_shared<StudyOptions>();
    verb.add_option("KIND", o->kind,
                    "paper: the paper's experiments again, and which of its claims hold; accuracy: what "
                    "accuracy costs in time, for a scene; stability: where the loop of device, arm, filter "
                    "and contact begins to oscillate, foretold and found; index: a front page of the studies "
                    "in DIR's folders")
        ->required()
        ->check(CLI::IsMember({"paper", "accuracy", "stability", "index"}));
    verb.add_option(
        "SCENE", o->scene,
        "accuracy: a scene, .scene.json, or one of ball-on-plane, ball-on-cylinder, ball-in-bowl");
    verb.add_option("-o", o->out,
                    "folder for index.html, summary.json, and a CSV, SVG and PNG of each figure")
        ->required()
        ->type_name("DIR");
    verb.add_option(
            "--seeds", o->seeds,
            "paper: turns of the shell and places of the path to take the mean over (default 10, with "
            "--quick 2; 1 to 1000)")
        ->check(CLI::Range(1u, 1000u))
        ->type_name("N");
    verb.add_option("--hard-map", o->hard_map,
                    "stability: map of the hard cases, as tests/hard/map.csv, to be shown as well")
        ->type_name("FILE.csv");
    verb.add_option("--budget", o->budget,
                    "accuracy: advise the most accurate configuration whose tick takes no longer (default: "
                    "the scene's "
                    "period)")
        ->type_name("TIME");
    verb.add_option("--error", o->error,
                    "accuracy: advise the fastest configuration that errs no more, as 1%")
        ->type_name("SHARE");
    verb.add_option("--voxel", o->voxels,
                    "accuracy: voxel edge to try; may be repeated (default: the scene's, twice, half and a "
                    "quarter of "
                    "it; --quick: the scene's and half of it)")
        ->type_name("LEN")
        ->expected(1)
        ->take_all();
    verb.add_flag(
        "--quick", o->quick,
        "paper: fewer seeds, and fewer depths and walls where methods are only compared; "
        "stability: two devices, fewer filters and stiffnesses; accuracy: two voxel edges, fewer poses");
    add_shared(verb, *o, {Shared::jobs, Shared::force, Shared::format, Shared::progress, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        const auto progress = make_progress(o->progress, o->quiet);
        if (o->kind == "index") return index(*o, *progress);
        gnuplot(gnuplot_sheet(Picture::svg, 100, 100) + "plot [0:1] x\n"); // told now, not after all runs
        if (o->kind == "paper") return paper(*o, *progress);
        if (o->kind == "stability") return stability(*o, *progress);
        if (o->scene.empty()) throw Failure(ExitCode::usage, "", "accuracy needs a SCENE");
        return accuracy(*o, *progress);
    };
}

} // namespace voxshell
