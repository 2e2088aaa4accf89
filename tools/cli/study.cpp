// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell study: whole studies with the shipped runtime, as CSV, pictures and one page.
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "study/gnuplot.hpp"
#include "study/paper_study.hpp"
#include "study/stability_study.hpp"
#include "study/study_index.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <memory>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

struct StudyOptions : SharedOptions {
    std::string kind, out, hard_map;
    unsigned seeds = 0; ///< 0: as many as the study says
    bool quick = false;
};

constexpr unsigned paper_seeds = 10, quick_seeds = 2;

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

} // namespace

VerbAction add_study(CLI::App &verb)
{
    auto o = std::make_shared<StudyOptions>();
    verb.add_option(
            "KIND", o->kind,
            "paper: the paper's experiments again, and which of its claims hold; stability: where "
            "the loop of device, arm, filter and contact begins to oscillate, foretold and found; index: "
            "a front page of the studies in DIR's folders")
        ->required()
        ->check(CLI::IsMember({"paper", "stability", "index"}));
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
    verb.add_flag("--quick", o->quick,
                  "paper: fewer seeds, and fewer depths and walls where methods are only compared; "
                  "stability: two devices, fewer filters and stiffnesses");
    add_shared(verb, *o, {Shared::jobs, Shared::force, Shared::format, Shared::progress, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        const auto progress = make_progress(o->progress, o->quiet);
        if (o->kind == "index") return index(*o, *progress);
        gnuplot(gnuplot_sheet(Picture::svg, 100, 100) + "plot [0:1] x\n"); // told now, not after all runs
        return o->kind == "paper" ? paper(*o, *progress) : stability(*o, *progress);
    };
}

} // namespace voxshell
