// SPDX-License-Identifier: GPL-3.0-or-later
// What the accuracy study says in sentences; each verdict is decided by the numbers in it.
#include "study/accuracy_study.hpp"
#include "study/contact_bench.hpp"
#include "study/study_account.hpp"

#include "cli/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr double most_halving_pct = 0.2, most_apart_pct = 0.5; ///< what is asked of the reference
constexpr double same_time = 1.25;                             ///< a tick's mean, of that of one copy

StudyClaim halving(const AccuracyResult &result, const Study &study)
{
    const StudyTable &table = study.table("reference");
    Account a(
        study, "halving", "Half the quadrature's spacing changes the reference by less than 0.2 %",
        "Triangles of what moves are cut until their edges are short enough; the last halving is measured.");
    double most = 0;
    for (std::size_t n = 0; n < result.references.size(); ++n)
        most = std::max(most, a.say(fmt::format("{}{} @ %", n ? ", " : "", result.references[n].scene), table,
                                    n, "halved_pct", "{:.3f}"));
    a.say(".");
    return a.judged(verdict_of(most < most_halving_pct, most < 2 * most_halving_pct));
}

StudyClaim formulas(const AccuracyResult &result, const Study &study)
{
    const StudyTable &table = study.table("reference");
    Account a(study, "formula", "The two references, the mesh's distance and formulas, agree within 0.5 %",
              "They share no code but the sum: a ball's patch by Gauss and Legendre on a formula's distance, "
              "against "
              "CGAL's tree on finely cut meshes, whose facets are what is left.");
    double most = 0;
    bool is_first = true;
    for (std::size_t n = 0; n < result.references.size(); ++n) {
        if (std::isnan(result.references[n].apart)) continue;
        most = std::max(most, a.say(fmt::format("{}{} @ %", is_first ? "" : ", ", result.references[n].scene),
                                    table, n, "formula_pct", "{:.3f}"));
        is_first = false;
    }
    a.say(".");
    return a.judged(verdict_of(most < most_apart_pct, most < 2 * most_apart_pct));
}

StudyClaim culled(const AccuracyResult &result, const Study &study)
{
    const StudyTable &table = study.table("culling");
    Account a(study, "culling", "Culling costs no accuracy at all: the same bits",
              "What is passed over is provably free, and sums run in point order whatever was looked at.");
    double most = 0;
    a.say("Wrenches with other bits than with every point in plain C: ");
    for (std::size_t n = 0; n < result.culling.size(); ++n)
        most = std::max(most, a.say(n ? ", @" : "@", table, n, "other_bits", "{:.0f}"));
    a.say(" of ");
    a.say("@ poses each", table, 0, "poses", "{:.0f}");
    a.say("; points looked at: @", table, 0, "looked_at");
    a.say(" without, @ with it.", table, 3, "looked_at");
    return a.judged(most == 0 ? Verdict::holds : Verdict::fails);
}

StudyClaim rounded(const AccuracyResult &result, const Study &study)
{
    const StudyTable &table = study.table("rounding");
    Account a(
        study, "rounding", "Points in floats cost less than a thousandth of the force",
        "A point in a float is a few nanometres off, and that costs next to nothing. What shows is a "
        "point in a plane between two cells: rounding alone decides on which side of it. A path that keeps "
        "a coordinate keeps whole rows of an exact shell's points there, where the shell's own grid cut "
        "the surface; moved by a part of a cell the same path has none of it. Each such point counts half "
        "a cell more or less, and where forces cancel, as around a peg in a hole, what is left of them is "
        "small beside that.");
    double most = 0;
    std::size_t worst = 0;
    for (std::size_t n = 0; n < result.rounding.size(); ++n) {
        if (result.rounding[n].poses == "moved") continue;
        if (result.rounding[n].wrench > result.rounding[worst].wrench) worst = n;
        most =
            std::max(most, 1e-6 * a.say(fmt::format("{}{} @ ppm", n ? "; " : "", result.rounding[n].config),
                                        table, n, "rms_ppm"));
        a.say(" (worst pose @)", table, n, "worst_ppm");
    }
    a.say(". Of the worst of these @ % of the points lie in planes between cells", table, worst,
          "in_planes_pct");
    a.say(" and forces cancel to one part in @; ", table, worst, "cancelled");
    a.say("with all poses moved by 0.29 cells along each axis it is @ ppm", table, worst + 1, "rms_ppm");
    a.say(" with @ % in planes.", table, worst + 1, "in_planes_pct");
    return a.judged(verdict_of(most < 1e-3, most < 1e-2));
}

/// A step over all pairs: lessens the error in all, in most.
StudyClaim step(const Study &study, const std::string &id, const std::string &claim, const std::string &why)
{
    const StudyTable &table = study.table("pairs");
    const std::size_t row = rows_of(table, {{"id", id}}).at(0);
    Account a(study, id.c_str(), claim.c_str(), why.c_str());
    const double ratio =
        a.say("The error with it is @ of that without it", table, row, "error_ratio", "{:.2f}");
    a.say(", mean of @ pairs of configurations", table, row, "pairs", "{:.4g}");
    const double least = a.say(", from @", table, row, "error_ratio_least", "{:.2f}"),
                 most = a.say(" to @; ", table, row, "error_ratio_most", "{:.2f}");
    a.say("less in @ % of them. ", table, row, "less_error_pct", "{:.3g}");
    a.say("The direction's error (p95) is @ of that without it. ", table, row, "direction_ratio", "{:.2f}");
    a.say("It takes @ of the time", table, row, "time_ratio", "{:.2f}");
    a.say(" and @ of the bytes.", table, row, "bytes_ratio", "{:.2f}");
    return a.judged(verdict_of(most < 1, ratio < 1 && least < 1));
}

StudyClaim size(const AccuracyResult &result, const Study &study)
{
    const StudyTable &table = study.table("static_size");
    Account a(study, "size", "A tick's time does not grow with what stands",
              "A look-up goes down three tables whatever their size; what grows is what the cache must hold "
              "of them.");
    double most = 0, differing = 0, first = 0;
    a.say("Mean tick with ");
    bool is_first = true;
    for (std::size_t n = 0; n < table.rows.size(); ++n) {
        if (table.word(n, "kind") != "copies") continue;
        const double mean = a.say(fmt::format("{}{:g} cop{}: @ us", is_first ? "" : ", ",
                                              table.number(n, "factor"), is_first ? "y" : "ies"),
                                  table, n, "tick_mean_us");
        if (is_first) first = mean;
        is_first = false;
        most = std::max(most, mean / first);
        differing += table.number(n, "other_force");
    }
    const std::size_t last = rows_of(table, {{"kind", "copies"}}).back();
    a.say("; the worst of its ticks: @ us; ", table, last, "tick_worst_us");
    a.say("poses with another force: @.", table, last, "other_force", "{:.0f}");
    (void)result;
    return a.judged(verdict_of(most < same_time && differing == 0, most < 2 && differing == 0));
}

/// Without what stands for a number here.
std::string machine_text()
{
    std::string name = processor_name();
    std::replace(name.begin(), name.end(), '@', ',');
    return name;
}

std::string budget_text(double seconds)
{
    return seconds < 1e-3 ? fmt::format("{:g} us", 1e6 * seconds) : fmt::format("{:g} ms", 1e3 * seconds);
}

} // namespace

std::vector<StudyClaim> accuracy_claims(const AccuracyResult &result, const Study &study)
{
    std::vector<StudyClaim> claims{halving(result, study), formulas(result, study), culled(result, study),
                                   rounded(result, study)};
    const struct {
        const char *id, *claim, *why;
    } all[] = {{"exact", "Exact points lessen the error",
                "A cell's centre is up to 0.87 cells off the surface: depths begin too early or too late, "
                "place by place. "
                "Where the field is too shallow for the path that is the larger error, and the points hardly "
                "matter."},
               {"average", "Averaged normals lessen the error",
                "They take the force across out, which the single points' normals bring in; but the mean "
                "counts points, and "
                "leans where these are spread unevenly."},
               {"distance", "A trilinear distance lessens the error",
                "One layer of cells ends where the next one begins: deeper points give no force, and depths "
                "jump by cells."},
               {"area", "Weighting by area lessens the error",
                "A cell's share of the surface hangs on how it is cut: points count the same whether they "
                "stand for much or "
                "for little."},
               {"finer", "Finer voxels lessen the error",
                "They do where the field reaches as deep as before. One layer of cells is half as deep in "
                "cells of half the "
                "edge: what was in it is then too deep."}};
    for (const auto &each : all) {
        if (!rows_of(study.table("pairs"), {{"id", each.id}}).empty())
            claims.push_back(step(study, each.id, each.claim, each.why));
    }
    claims.push_back(size(result, study));
    return claims;
}

StudyClaim accuracy_answer(const AccuracyResult &result, const AccuracyQuestion &question,
                           const Advice &advice, const Study &study)
{
    const StudyTable &table = study.table("accuracy");
    const std::string asked =
        question.error
            ? fmt::format("an error of {:g} %{}", 100 * *question.error,
                          question.budget ? " and a budget of " + budget_text(*question.budget)
                                          : std::string())
            : fmt::format("a tick of {}", budget_text(question.budget.value_or(1 / result.scene.rate)));
    Account a(study, "advice", fmt::format("For {}, on this machine", asked).c_str(),
              "By the tick's p99.9 (least of three passes): deadlines are missed by rare ticks, and the "
              "largest of all is "
              "an interruption by the system.");
    a.claim.why +=
        result.scene.evaluations > 1
            ? fmt::format(
                  " The scene's coupling may evaluate contact {} times in a tick: its p99.9 counts so "
                  "many times.",
                  result.scene.evaluations)
            : "";
    const auto cost = [&](std::size_t n) {
        a.say(" with an error of @ %", table, n, "error_pct", "{:.3g}");
        if (!std::isnan(result.rows[n].angle_p95))
            a.say(" (direction within @ degrees at p95)", table, n, "direction_p95_deg", "{:.3g}");
        a.say(": a tick costs @ us at p99.9, ", table, n, "tick_p999_us");
        a.say("@ us at p50, ", table, n, "tick_p50_us");
        a.say("the assets @ KiB", table, n, "asset_kib", "{:.4g}");
        a.say(" and @ s of conversion", table, n, "conversion_s", "{:.3g}");
    };
    if (!advice.taken) {
        a.say("None of the configurations tried. The fastest is " +
              result.rows[advice.fastest].config.text());
        cost(advice.fastest);
        a.say("; the most accurate is " + result.rows[advice.best].config.text());
        cost(advice.best);
        a.say(". " + machine_text() + ".");
        return a.judged(Verdict::fails);
    }
    const AccuracyConfig &taken = result.rows[*advice.taken].config;
    a.say("h = " + taken.text());
    cost(*advice.taken);
    if (advice.better) {
        a.say(". The next better one costs @ us: ", table, *advice.better, "tick_p999_us");
        a.say(result.rows[*advice.better].config.text());
        a.say(", for an error of @ %", table, *advice.better, "error_pct", "{:.3g}");
    } else {
        a.say(". None that was tried is better");
    }
    const auto nearest = front(result, [](const AccuracyRow &r) { return r.tick.p999; });
    const auto at = std::find(nearest.begin(), nearest.end(), *advice.taken);
    if (at != nearest.end() && at != nearest.begin()) {
        a.say(". The next cheaper one costs @ us: ", table, *(at - 1), "tick_p999_us");
        a.say(result.rows[*(at - 1)].config.text());
        a.say(", for an error of @ %", table, *(at - 1), "error_pct", "{:.3g}");
    }
    const double reach = result.rows[*advice.taken].reach;
    a.say(fmt::format(
        ". {}. To have it: \"voxel\": \"{:g}mm\", \"law\": \"{}\", \"field\": \"{}\", \"weighting\": \"{}\" "
        "in "
        "the scene{}{}.",
        machine_text(), 1e3 * taken.voxel, law_name(taken.method.law), field_name(taken.method.field),
        weighting_name(taken.method.weighting),
        reach > 3 ? fmt::format(", convert --channels {}:{:g}", field_name(taken.method.field), reach) : "",
        taken.method.shell == ShellKind::naive ? ", and --shell naive" : ""));
    return a.judged(Verdict::holds);
}

} // namespace voxshell
