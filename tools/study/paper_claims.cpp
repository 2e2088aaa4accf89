// SPDX-License-Identifier: GPL-3.0-or-later
// What the paper says and what came out. A verdict is decided by the numbers, never written down.
#include "study/paper_study.hpp"
#include "study/study_account.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr double asked = 0.7;      ///< of average over original, tangential peak
constexpr double calm_share = 0.1; ///< of the steady force may swing at the end

/// Tangential peak, average over original, at each depth with its spread.
StudyClaim averaged(const Study &study, const char *id, const char *pair, const char *text, const char *why)
{
    Account a(study, id, text, why);
    const StudyTable &ratios = study.table("ratios");
    double worst = 0, worst_rms = 0;
    a.say("Tangential peak over that of the original law: ");
    for (const std::size_t row : rows_of(ratios, {{"pair", pair}})) {
        const double depth = ratios.number(row, "level"), peak = a.say("@", ratios, row, "peak", "{:.2f}");
        a.say(" +- @", ratios, row, "peak_deviation", "{:.2f}");
        a.say(fmt::format(" at {} e ", depth));
        const double rms = a.say("(rms @", ratios, row, "rms", "{:.2f}");
        a.say(", without its mean @", ratios, row, "noise", "{:.2g}");
        a.say("); ");
        if (depth < 1) worst = std::max(worst, peak), worst_rms = std::max(worst_rms, rms);
    }
    a.say("seeds @.", ratios, rows_of(ratios, {{"pair", pair}}).front(), "seeds");
    return a.judged(verdict_of(worst <= asked && worst_rms < 1, worst < 1));
}

StudyClaim smoother(const Study &study)
{
    Account a(study, "smoother", "All in all the force evolves more smoothly (section 5).",
              "The laws differ in the direction of the forces, not in which points collide. A point under "
              "the one force layer gives none, one above it none: whole rings of points come and go as the "
              "layer's steps pass, "
              "and the normal force follows. At the four sides of the cylinder its face lies along the grid "
              "at a border of cells: there what is half a cell deep has not yet reached the middle of its "
              "cell, from which depth counts, and the force is 0. The paper's figures leave the normal force "
              "out. A trilinear distance has no layer to leave.");
    const StudyTable &ratios = study.table("ratios");
    double least = 9;
    a.say("Ripple of the normal force, average over original: ");
    for (const char *pair : {"fig8d / fig8c", "fig9b / fig9a"}) {
        for (const std::size_t row : rows_of(ratios, {{"pair", pair}})) {
            if (ratios.number(row, "level") != 0.5) continue;
            least =
                std::min(least, a.say(std::string("@ (") + pair + "), ", ratios, row, "ripple", "{:.2f}"));
        }
    }
    a.say("0.5 e deep; in figure 9 b it is @ % of the mean force", "fig9_means", {{"scenario", "fig9b"}}, 0.5,
          "ripple_pct");
    a.say(". With the field distance and the law gradient it is @ %.", "control_means",
          {{"scenario", "control9"}, {"shell", "exact"}, {"law", "gradient"}}, 0.5, "ripple_pct");
    return a.judged(verdict_of(least < asked, least < 0.95));
}

StudyClaim exact_points(const Study &study)
{
    Account a(study, "exact",
              "Points that lie exactly on the surface avoid force distractions (sections 2.1 and 5).",
              "A naive point is off by up to 0.87 e, which is more than the layer is deep: on the plane that "
              "pushes to the side. On the cylinder along the grid it helps: its cells are alike all along "
              "the axis, exact points of equal depth "
              "meet a step of the cells at once, naive ones one after another; turned out of the grid, the "
              "same cylinder has it the other way round. With a distance in place of the layer exact points "
              "have far less force across.");
    const StudyTable &ratios = study.table("ratios");
    double most = 0, least = 9;
    const auto pair = [&](const char *name, const char *text) {
        for (const std::size_t row : rows_of(ratios, {{"pair", name}})) {
            if (ratios.number(row, "level") != 0.5) continue;
            const double rms = a.say(std::string(text) + " rms @", ratios, row, "rms", "{:.2f}"),
                         peak = a.say(", peak @", ratios, row, "peak", "{:.2f}");
            a.say(", ripple of the normal force @; ", ratios, row, "ripple", "{:.2f}");
            most = std::max({most, rms, peak});
            least = std::min({least, rms, peak});
        }
    };
    a.say("Tangential force, exact over naive, original law, 0.5 e: ");
    pair("exact / naive, tilted plane, original", "turned plane");
    pair("exact / naive, cylinder, original", "cylinder");
    pair("exact / naive, turned cylinder, original", "the same cylinder turned");
    a.say("with the field distance @", "control_means",
          {{"scenario", "control8"}, {"shell", "exact"}, {"law", "original"}, {"field", "distance"}}, 0.5,
          "across_rms_pct");
    a.say(" % against @ % on the plane.", "control_means",
          {{"scenario", "control8"}, {"shell", "naive"}, {"law", "original"}, {"field", "distance"}}, 0.5,
          "across_rms_pct");
    return a.judged(verdict_of(most < 1, least < 1));
}

StudyClaim filtered(const Study &study)
{
    Account a(study, "filter",
              "A dynamic shaping filter of 5 Hz gives a smoother force than a heuristically tuned virtual "
              "coupling (figure 11).",
              "It is a low pass: what is slow passes, and it comes late. The spring-damper is in series with "
              "the contact, so that it is soft as well. Whether the delay spoils the impression, as the "
              "paper denies, needs people.");
    const auto row = [&](const char *text, const char *coupling, const char *column,
                         const char *format = "{:.3g}") {
        return a.say(text, "fig11_means", {{"coupling", coupling}, {"field", "surface"}}, any_level, column,
                     format);
    };
    a.say("Swing above 10 Hz, of the mean force: ");
    row("none @ %, ", "none", "felt_swing_above_10hz_pct");
    const double spring = row("spring-damper @ %, ", "spring-damper", "felt_swing_above_10hz_pct"),
                 five = row("PT2 5 Hz @ %, ", "PT2 5 Hz", "felt_swing_above_10hz_pct");
    row("PT2 50 Hz @ %. ", "PT2 50 Hz", "felt_swing_above_10hz_pct");
    row("Lag: @ ms with 5 Hz, ", "PT2 5 Hz", "lag_ms");
    row("@ ms with the spring-damper. ", "spring-damper", "lag_ms");
    row("What is slower than the filter stays: ripple @ %", "PT2 5 Hz", "felt_ripple_pct");
    row(" against @ % without any.", "none", "felt_ripple_pct");
    return a.judged(verdict_of(five < asked * spring, five < spring));
}

const char *panels[] = {"fig12a", "fig12b", "fig12c", "fig12d"};

StudyClaim stable(const Study &study)
{
    Account a(study, "stable",
              "With the filter the interaction is stable, on the Phantom and on the light-weight robot "
              "(figure 12, section 5).",
              "With k = 1 N per e for each point (the paper gives no stiffness) some fifty points push at "
              "once. Device, hand and a filter of 5 Hz are calm below the stiffness in the table, which is a "
              "small share of that: the filter's delay turns the contact's spring into a motor. "
              "What a figure of forces shows as a thick calm line depends on who holds the device, and how "
              "firmly.");
    bool any_calm = false, all_calm = true;
    a.say("The output's swing in the last 0.3 s: ");
    for (const char *panel : panels) {
        const Words words{
            {"scenario", panel}, {"law", "average"}, {"field", "surface"}, {"coupling", "PT2 5 Hz"}};
        const double swing = a.say(std::string(panel).substr(3) + " @ N", "fig12_means", words, any_level,
                                   "oscillation_n", "{:.2f}");
        const double steady = a.say(" (mean @ N), ", "fig12_means", words, any_level, "steady_n");
        const bool calm = swing <= calm_share * steady;
        any_calm |= calm;
        all_calm &= calm;
    }
    const Words first{{"scenario", "fig12a"}, {"field", "surface"}, {"coupling", "PT2 5 Hz"}};
    a.say("the contact being up to @ N/m stiff", "fig12_means", first, any_level, "contact_n_per_m");
    a.say(" where the loop carries @ N/m.", "fig12_means", first, any_level, "carried_n_per_m");
    return a.judged(verdict_of(all_calm, any_calm));
}

StudyClaim framework(const Study &study)
{
    Account a(
        study, "framework",
        "The framework fits other devices with almost no change of the virtual environment (sections 1 and "
        "3).",
        "One rule serves both devices: bound the contact as a whole to half of what the loop carries. But "
        "that bound is a parameter of the environment, and it is another one for each device; and what is "
        "left of the wall is soft: the hand reaches its target, and the wall is thinner than that.");
    bool all_calm = true, through = false;
    a.say("So bounded, the output's swing at the end is ");
    for (const char *panel : panels) {
        const Words words{
            {"scenario", panel}, {"law", "average"}, {"field", "surface"}, {"coupling", "PT2 5 Hz bounded"}};
        const double swing = a.say(std::string(panel).substr(3) + " @ N, ", "fig12_means", words, any_level,
                                   "oscillation_n", "{:.2f}");
        all_calm &= swing <= 0.1;
        through |= study.table("fig12_means")
                       .number(rows_of(study.table("fig12_means"), words).front(), "through_pct") > 0;
    }
    const Words first{{"scenario", "fig12a"}, {"field", "surface"}, {"coupling", "PT2 5 Hz bounded"}};
    a.say("but of the wall @ N is left at the end of a", "fig12_means", first, any_level, "steady_n");
    a.say(", and the hand gets @ mm deep.", "fig12_means", first, any_level, "deepest_mm");
    return a.judged(verdict_of(all_calm && !through, all_calm));
}

StudyClaim walls(const Study &study)
{
    const StudyTable &wall = study.table("wall_means");
    Account a(study, "walls",
              "A wall of three voxels is enough to prevent an unrecognised interpenetration (section 2.1).",
              "No point slips between cells: the collision is recognised. But one force layer pushes over "
              "one cell's depth and no further; behind it points count as deep and give nothing. Layers and "
              "a distance push deeper, up to the middle of the wall, and in a loop that is not stable the "
              "swing carries the probe past it.");
    double most = 0;
    a.say("Seeds in which the probe comes through three cells: ");
    for (const std::size_t row : rows_of(wall, {{"field", "surface"}, {"coupling", "PT2 5 Hz"}})) {
        if (wall.number(row, "level") != 3) continue;
        most = std::max(most, a.say("@ %", wall, row, "through_pct"));
        a.say(" at @ mm/s, ", wall, row, "speed_mm_per_s");
    }
    a.say("with one layer and the filter of 5 Hz");
    double ours = 0;
    for (const std::size_t row : rows_of(wall, {{"coupling", "automatic"}}))
        ours = std::max(ours, wall.number(row, "through_pct"));
    for (const std::size_t row : rows_of(wall, {{"coupling", "automatic"}})) {
        if (wall.number(row, "through_pct") != ours || wall.number(row, "level") != 3) continue;
        a.say("; with patches, distance and a designed spring @ %", wall, row, "through_pct");
        a.say(", at most @ mm deep at that speed.", wall, row, "deepest_mm");
        break;
    }
    return a.judged(verdict_of(most == 0, most < 100));
}

StudyClaim fits(const Study &study)
{
    Account a(study, "patches",
              "Ours: patches keep opposed normals apart, where the paper's one mean cancels (wedge, peg).",
              "In a wedge that is pressed aslant, and in a hole, one mean stands for two walls. One force "
              "layer of 1 mm cannot render fits of 0.2 mm whatever the law: a surface cell reaches up to a "
              "cell off the wall, and so pushes a peg that has play. What is left with a distance we lay to "
              "the mouth, where it leads up and out as well as inwards, and to the tip's edge, where a point "
              "stands for two faces; not measured apart.");
    const auto wrench = [&](const char *text, const char *group, const char *law, double level) {
        return a.say(text, std::string(group) + "_means", {{"law", law}, {"field", "distance"}}, level,
                     "wrench_error_pct");
    };
    a.say("Off an elastic foundation, field distance: wedge pressed aslant ");
    const double patch = wrench("@ % with patches, ", "wedge", "patch", 0.5),
                 average = wrench("@ % with the average; ", "wedge", "average", 0.5);
    const double peg = wrench("peg of 20.2 mm @ %", "peg", "patch", 20.2);
    wrench(" and @ %. ", "peg", "average", 20.2);
    a.say("The mean cancels in @ % of the peg's ticks. ", "peg_means",
          {{"law", "average"}, {"field", "distance"}}, 20.2, "cancelled_pct");
    a.say("A peg of 19.6 mm touches nothing, and one force layer gives it @ k e", "peg_means",
          {{"law", "patch"}, {"field", "surface"}}, 19.6, "size_ke");
    a.say(" on the mean.");
    return a.judged(verdict_of(patch < 0.2 * average && peg < 10, patch < 0.2 * average));
}

StudyClaim ours(const Study &study)
{
    Account a(study, "ours",
              "Ours: patches, distance and a designed spring are calm, firm and keep the probe outside "
              "(figure 12).",
              "The design picks a quasi-static spring: the object hangs on the device by a spring that the "
              "loop carries, whatever the contact's stiffness; the device may be ahead, the object is not.");
    bool calm = true, outside = true;
    a.say("The output's swing in the last 0.3 s: ");
    for (const char *panel : panels) {
        const Words words{{"scenario", panel}, {"coupling", "automatic"}};
        const double swing = a.say(std::string(panel).substr(3) + " @ N", "fig12_means", words, any_level,
                                   "oscillation_n", "{:.2f}");
        const double steady = a.say(" (mean @ N)", "fig12_means", words, any_level, "steady_n");
        const double deepest = a.say(", deepest @ mm; ", "fig12_means", words, any_level, "deepest_mm");
        calm &= swing <= std::max(0.05, calm_share * steady);
        outside &= deepest < 2;
    }
    a.say("energy taken from the hand at least @ mJ (c).", "fig12_means",
          {{"scenario", "fig12c"}, {"coupling", "automatic"}}, any_level, "energy_mj");
    return a.judged(verdict_of(calm && outside, calm || outside));
}

StudyClaim spring_on_layer(const Study &study)
{
    Account a(study, "spring-on-one-layer",
              "Ours: the designed spring goes with any contact (figure 11, the automatic design).",
              "Each tick the spring seeks the pose where contact and spring balance. One force layer ends "
              "where its cells do, so that there may be no such pose; a distance has no such end. The "
              "numbers are before the device's clamp.");
    const double surface =
        a.say("Largest output, mean over the seeds: @ N with one force layer", "fig11_means",
              {{"coupling", "automatic"}, {"field", "surface"}}, any_level, "output_peak_n");
    const double distance =
        a.say("; @ N with patches and distance, ", "fig11_means",
              {{"coupling", "automatic"}, {"field", "distance"}}, any_level, "output_peak_n");
    const double contact = a.say("the contact itself being at most @ N with one layer.", "fig11_means",
                                 {{"coupling", "none"}}, any_level, "collision_peak_n");
    return a.judged(verdict_of(surface < 2 * contact, distance < 2 * contact));
}

} // namespace

std::vector<StudyClaim> paper_claims(const Study &study)
{
    return {averaged(study, "fig8-turned", "fig8d / fig8c",
                     "The averaged normal takes distractions away on a plane that is askew to the grid "
                     "(figure 8 d against c).",
                     "All colliding points share one normal, so that one which comes or goes turns it by its "
                     "share of the mean, in place of pushing aslant by itself. Left is a constant pull to "
                     "the side: points sit unevenly."),
            averaged(study, "fig8-grid", "fig8b / fig8a",
                     "It does so as well on a plane along the grid (figure 8 b against a).",
                     "The same points collide all the time, so that the mean normal stands still and the "
                     "noise is gone. But it stands a little aslant, as the points of a turned shell sit "
                     "unevenly, and that constant pull is larger than the noise which it replaces: with the "
                     "original law each point's own error is met by its opposite."),
            averaged(study, "fig9", "fig9b / fig9a", "It does so on a cylinder (figure 9 b against a).",
                     "As in figure 8: the most aslant points, those at the rim of the contact, no longer "
                     "push along their own normals."),
            smoother(study),
            exact_points(study),
            filtered(study),
            stable(study),
            framework(study),
            walls(study),
            fits(study),
            ours(study),
            spring_on_layer(study)};
}

Study paper_study(const PaperOptions &options, const std::string &command, Progress &progress)
{
    Study study;
    study.name = "paper";
    study.title = "The paper's experiments, run again";
    study.lead = fmt::format("Renz, Preusche, Pötke, Kriegel and Hirzinger give their experiments (\"Stable "
                             "Haptic Interaction with Virtual Environments Using an Adapted "
                             "Voxmap-PointShell Algorithm\", 2001) in words, without sizes, "
                             "stiffness or speeds. Ours: e = 1 mm (2 mm for figures 11 and 12), a ball of 20 "
                             "e, 1 kHz, k = 1 N per e for each point, one turn in 3 s; the cup has 40 and 34 "
                             "mm, its wall three cells. All runs use the shipped C runtime on assets "
                             "of the real pipeline; {} seed{} turn the shell and place the path. Devices and "
                             "hands are simulated; masses and frictions are assumed.",
                             options.seeds, options.seeds == 1 ? "" : "s");
    study.command = command;
    study.options = {{"seeds", std::to_string(options.seeds)}, {"quick", options.quick ? "yes" : "no"}};
    const PaperRuns runs = run_paper(options, progress);
    study.tables = paper_tables(runs);
    study.timings = paper_timings(runs);
    study.claims = paper_claims(study);
    study.figures = paper_figures(runs, study);
    return study;
}

} // namespace voxshell
