// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/stability_study.hpp"
#include "study/study_account.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace voxshell {
namespace {

constexpr double close = 0.05; ///< of K_max

const StudyTable *find_table(const Study &study, const std::string &id)
{
    const auto found = std::find_if(study.tables.begin(), study.tables.end(),
                                    [&](const StudyTable &table) { return table.id == id; });
    return found == study.tables.end() ? nullptr : &*found;
}

StudyClaim foretold(const Study &study)
{
    Account a(study, "foretold", "Small motions begin to grow where theory says: at K_max.",
              "The model is the sampled loop as the simulated device and the coupling run it, substep by "
              "substep; it leaves out friction, encoder steps and the clamp, and so does this run.");
    const StudyTable &all = study.table("agreement");
    const double least = a.say("Found over foretold: @", all, 0, "ratio_least", "{:.4f}"),
                 most = a.say(" to @", all, 0, "ratio_most", "{:.4f}");
    a.say(" in @ loops.", all, 0, "loops");
    return a.judged(
        verdict_of(least > 1 - close && most<1 + close, least> 1 - 3 * close && most < 1 + 3 * close));
}

StudyClaim as_it_is(const Study &study)
{
    Account a(
        study, "as-it-is",
        "What theory calls calm stays calm on the device as it is, let go 5 mm off: friction, encoder "
        "steps and clamp in place.",
        "Between hunting and K_max friction, which small motions feel as damping and large ones do "
        "not, decides; beyond K_max it holds what is small. The clamp bounds how far it swings. Hunting is "
        "foretold from friction alone: where the encoder's steps are coarse for the stiffness, both "
        "together can keep going what neither does alone.");
    const StudyTable &all = study.table("agreement");
    const double cells = a.say("Of @ cells below both K_max and where friction can keep it hunting ", all, 0,
                               "calm_cells"),
                 swing = a.say("@ swing", all, 0, "calm_swinging");
    a.say(", by up to @ mm. ", all, 0, "calm_swinging_mm");
    a.say("Of @ between these two ", all, 0, "hunting_cells");
    a.say("@ do; ", all, 0, "hunting_swinging");
    a.say("of @ beyond K_max ", all, 0, "unstable_cells");
    a.say("@ are held by friction.", all, 0, "unstable_still");
    if (const StudyTable *odd = find_table(study, "odd_swings")) {
        a.say(fmt::format(" What swings below ({}, {}, {}, ", odd->word(0, "device"), odd->word(0, "arm"),
                          odd->word(0, "filter")));
        a.say("@ N/m) swings by ", *odd, 0, "stiffness_n_per_m", "{:.4g}");
        a.say("@ mm without encoder steps, ", *odd, 0, "without_steps_mm");
        a.say("@ mm without friction.", *odd, 0, "without_friction_mm");
    }
    return a.judged(verdict_of(swing == 0, swing <= close * cells));
}

StudyClaim passive(const Study &study)
{
    Account a(study, "passive", "What is passive by Colgate's condition does not swing.",
              "Passive is stricter than stable: it holds whoever holds the device. Encoder steps are not "
              "part of it.");
    const StudyTable &all = study.table("agreement");
    a.say("Of @ cells ", all, 0, "passive_cells");
    const double swing = a.say("@ swing.", all, 0, "passive_swinging");
    return a.judged(verdict_of(swing == 0, swing <= close * all.number(0, "passive_cells")));
}

StudyClaim five_hertz(const Study &study)
{
    Account a(study, "five-hertz",
              "The paper: reducing the dynamics of the force to 5 Hz keeps device and hand from becoming "
              "unstable (section 3).",
              "A filter delays: its 2 d / w0 of 64 ms is added to the loop, and what the device's damping "
              "carries falls with the delay. It takes noise away, and with it stiffness that the loop could "
              "carry.");
    const StudyTable &arms = study.table("arms");
    double lowers = 0, all = 0;
    a.say("With 5 Hz K_max is lower than without a filter ");
    for (std::size_t n = 0; n < arms.rows.size(); ++n) {
        lowers += a.say(n ? "; " + arms.word(n, "arm") + ": on @" : arms.word(n, "arm") + ": on @", arms, n,
                        "five_lowers");
        all += a.say(" of @ devices", arms, n, "devices");
        a.say(", @", arms, n, "five_over_none_least", "{:.2g}");
        a.say(" to @ of it", arms, n, "five_over_none_most", "{:.2g}");
    }
    a.say(".");
    return a.judged(verdict_of(lowers == 0, lowers < 0.5 * all));
}

StudyClaim recommended(const Study &study)
{
    Account a(study, "recommended",
              "A device carries, held by a hand, the stiffness that its makers recommend.",
              "The recommended stiffness is published, masses, friction and damping of device and arm are "
              "assumed. A hand's damping is what carries; with nobody at the device there is only its own.");
    const StudyTable &arms = study.table("arms");
    double none = 0, devices = 0;
    for (const char *name : {"hand", "free"}) {
        const std::size_t row = rows_of(arms, {{"arm", name}}).at(0);
        const double carries = a.say(std::string(name) + ": @", arms, row, "none_carries");
        const double of = a.say(" of @ without a filter, ", arms, row, "devices");
        a.say("@ with 5 Hz, ", arms, row, "five_carries");
        a.say(name == std::string("hand") ? "@ with some filter of the map; " : "@ with some.", arms, row,
              "any_carries");
        if (name == std::string("hand")) none = carries, devices = of;
    }
    return a.judged(verdict_of(none == devices, none > 0));
}

StudyClaim contact(const Study &study)
{
    Account a(
        study, "contact",
        "The contact's bound most_stiffness is the stiffness of theory: the real contact begins to "
        "oscillate where it passes K_max.",
        "The bound scales the contact's force as a whole. A flat body's points all collide at once: its "
        "force is the bound times the depth. A ball gains points as it goes in, each of which takes "
        "from the others: its force grows by less than the bound, and it is calm a little further.");
    const StudyTable &ratios = study.table("contact_ratios");
    const double low =
                     a.say("Bound at the onset over K_max: flat body @", ratios, 0, "ratio_least", "{:.3f}"),
                 high = a.say(" to @", ratios, 0, "ratio_most", "{:.3f}");
    const double ball = a.say("; ball @", ratios, 1, "ratio_least", "{:.3f}");
    a.say(" to @", ratios, 1, "ratio_most", "{:.3f}");
    a.say(" (@ loops each).", ratios, 0, "loops");
    const bool flat = low > 1 - close && high < 1 + close;
    return a.judged(verdict_of(flat && std::abs(ball - 1) < close, flat && ball > 1 - close));
}

StudyClaim quasi_static(const Study &study)
{
    Account a(
        study, "quasi-static",
        "A quasi-static coupling is calm with contact of any stiffness, if its spring is one that the "
        "device carries.",
        "The device feels contact and spring in a row, the spring at most: theory has no line of contact "
        "stiffness for it, and K_max bounds the spring instead. Run so, small motions begin to grow where "
        "the spring passes that bound.");
    const StudyTable &all = study.table("springs_agreement");
    const double least = a.say("On a contact of 1e6 N/m they begin at @", all, 0, "ratio_least", "{:.4f}"),
                 most = a.say(" to @ of the spring foretold", all, 0, "ratio_most", "{:.4f}");
    a.say(" (@ loops). ", all, 0, "loops");
    a.say("With the spring that design takes, at most @ of K_max, ", all, 0, "designed_share_most");
    const double swing = a.say("@ of ", all, 0, "swinging");
    a.say("@ pairs of loop and contact (1 to 1e6 N/m) swing.", all, 0, "cells");
    const bool foretold = least > 1 - close && most < 1 + close;
    return a.judged(verdict_of(foretold && swing == 0, foretold && swing < close * all.number(0, "cells")));
}

StudyClaim hard(const Study &study)
{
    Account a(study, "hard", "Every law and field keeps the hard cases' bounds.",
              "The cases' files and contact.h say of each pair what it does not claim, and why. Field "
              "distance keeps the most.");
    const StudyTable &totals = study.table("hard_totals");
    bool all = true, fails = false;
    for (std::size_t n = 0; n < totals.rows.size(); ++n) {
        const double holds = a.say((n ? ", " : "") + totals.word(n, "pair") + " @", totals, n, "holds");
        all &= holds == totals.number(n, "cases");
        fails |= totals.number(n, "fails") > 0;
    }
    a.say(" of @.", totals, 0, "cases");
    return a.judged(verdict_of(all, !fails));
}

} // namespace

std::vector<StudyClaim> stability_claims(const Study &study)
{
    std::vector<StudyClaim> claims{foretold(study),    as_it_is(study),     passive(study), five_hertz(study),
                                   recommended(study), quasi_static(study), contact(study)};
    if (find_table(study, "hard_totals")) claims.push_back(hard(study));
    return claims;
}

Study stability_study(const StabilityOptions &options, const std::string &command, Progress &progress)
{
    Study study;
    study.name = "stability";
    study.title = "Where the loop begins to oscillate";
    study.lead = fmt::format(
        "Device, arm, filter and contact are a loop with a delay. How stiff may contact be before it "
        "oscillates? Foretold by the sampled loop (K_max, margins, passivity), and found by running the "
        "runtime's own simulated device, coupling and contact. Masses, friction and damping of devices and "
        "arms are assumed, force limits and recommended stiffness published.{}",
        options.hard_map.empty() ? " Without the hard cases: --hard-map adds what hard_suite --csv wrote."
                                 : "");
    study.command = command;
    study.options = {{"quick", options.quick ? "yes" : "no"},
                     {"hard_map", options.hard_map.empty() ? "none" : options.hard_map.filename().string()}};
    std::optional<HardMap> hard_map;
    if (!options.hard_map.empty()) hard_map = read_hard_map(options.hard_map); // told now, not after all runs
    const StabilityRuns runs = run_stability(options.quick, progress);
    study.tables = stability_tables(runs);
    study.figures = stability_figures(runs);
    if (hard_map) {
        study.tables.push_back(std::move(hard_map->totals));
        study.tables.push_back(std::move(hard_map->cases));
        study.figures.push_back(std::move(hard_map->figure));
    }
    study.claims = stability_claims(study);
    return study;
}

} // namespace voxshell
