// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/stability_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxshell {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

StudyTable loops_table(const StabilityRuns &runs)
{
    StudyTable table{"loops",
                     "Each device, arm and filter",
                     "K_max: foretold; found: where small motions begin to grow in the time domain, without "
                     "friction, encoder steps and clamp. Friction keeps it hunting from: foretold as well. "
                     "Swings from: the lowest stiffness of the map at which the device as it is swings by "
                     "more than two encoder steps. Margins at the stiffness that is recommended for the "
                     "device; below 0 dB it is unstable there.",
                     {{"device", "device"},
                      {"arm", "arm"},
                      {"filter", "filter"},
                      {"hertz", ""},
                      {"bandwidth_hz", "bandwidth [Hz]"},
                      {"k_max_n_per_m", "K_max [N/m]"},
                      {"found_n_per_m", "found [N/m]"},
                      {"found_over_k_max", "found / K_max"},
                      {"hunting_n_per_m", "hunting from [N/m]"},
                      {"passive_n_per_m", "passive to [N/m]"},
                      {"quantisation_n_per_m", ""},
                      {"swings_from_n_per_m", "swings from [N/m]"},
                      {"recommended_n_per_m", "recommended [N/m]"},
                      {"gain_margin_db", "gain [dB]"},
                      {"phase_margin_deg", "phase [deg]"},
                      {"delay_margin_ms", "delay [ms]"}},
                     {},
                     "stability_map"};
    for (const LoopMap &map : runs.loops) {
        double swings = nothing;
        for (std::size_t n = runs.stiffness.size(); n-- > 0;)
            swings = map.oscillates(n) ? runs.stiffness[n] : swings;
        table.rows.push_back({std::string(map.key.profile->name), std::string(map.key.arm->name),
                              map.key.filter(), map.key.hertz, map.bandwidth, map.largest, map.found,
                              map.found / map.largest, map.hunting, map.passive, map.quantisation, swings,
                              map.key.profile->max_stiffness, map.margins.gain_db, map.margins.phase_deg,
                              1e3 * map.margins.delay_s});
    }
    return table;
}

/// Of all loops, or of one device's.
std::vector<std::variant<std::string, double>> agreement_row(const StabilityRuns &runs,
                                                             const std::string &device)
{
    double loops = 0, least = infinity, most = -infinity;
    double calm = 0, calm_swinging = 0, worst = 0, between = 0, between_swinging = 0, beyond = 0,
           beyond_still = 0, passive = 0, passive_swinging = 0;
    for (const LoopMap &map : runs.loops) {
        if (!device.empty() && device != map.key.profile->name) continue;
        ++loops;
        least = std::min(least, map.found / map.largest);
        most = std::max(most, map.found / map.largest);
        for (std::size_t n = 0; n < runs.stiffness.size(); ++n) {
            const double k = runs.stiffness[n];
            const bool swings = map.oscillates(n);
            if (k < map.passive) ++passive, passive_swinging += swings;
            if (k < map.hunting) {
                ++calm;
                calm_swinging += swings;
                worst = std::max(worst, swings ? map.amplitude[n] : 0);
            } else if (k < map.largest) {
                ++between;
                between_swinging += swings;
            } else {
                ++beyond;
                beyond_still += !swings;
            }
        }
    }
    return {device.empty() ? "all" : device,
            loops,
            least,
            most,
            calm,
            calm_swinging,
            1e3 * worst,
            between,
            between_swinging,
            beyond,
            beyond_still,
            passive,
            passive_swinging};
}

StudyTable agreement_table(const StabilityRuns &runs)
{
    StudyTable table{"agreement",
                     "Foretold against found",
                     "Cells: a loop at one stiffness of the map, the device as it is.",
                     {{"device", "device"},
                      {"loops", "loops"},
                      {"ratio_least", "found / K_max, least"},
                      {"ratio_most", "most"},
                      {"calm_cells", "cells foretold calm"},
                      {"calm_swinging", "that swing"},
                      {"calm_swinging_mm", "by up to [mm]"},
                      {"hunting_cells", "cells foretold to hunt"},
                      {"hunting_swinging", "that swing"},
                      {"unstable_cells", "cells foretold unstable"},
                      {"unstable_still", "that friction holds"},
                      {"passive_cells", "cells foretold passive"},
                      {"passive_swinging", "that swing"}},
                     {},
                     "stability_map"};
    table.rows.push_back(agreement_row(runs, ""));
    for (std::size_t n = 0; n < runs.loops.size(); ++n) {
        const std::string device = runs.loops[n].key.profile->name;
        if (n == 0 || device != runs.loops[n - 1].key.profile->name)
            table.rows.push_back(agreement_row(runs, device));
    }
    return table;
}

/// Without rows where nothing is odd.
StudyTable odd_table(const StabilityRuns &runs)
{
    StudyTable table{
        "odd_swings",
        "Foretold calm, and swings",
        "Half the swing after 72 s, and the same without the device's encoder steps, and without its "
        "friction.",
        {{"device", "device"},
         {"arm", "arm"},
         {"filter", "filter"},
         {"stiffness_n_per_m", "stiffness [N/m]"},
         {"hunting_n_per_m", "hunting from [N/m]"},
         {"k_max_n_per_m", "K_max [N/m]"},
         {"quantisation_n_per_m", "encoder steps may feed it from [N/m]"},
         {"swing_mm", "swing [mm]"},
         {"without_steps_mm", "without encoder steps [mm]"},
         {"without_friction_mm", "without friction [mm]"}},
        {},
        "stability_map"};
    for (const LoopMap &map : runs.loops) {
        for (const OddSwing &odd : map.odd)
            table.rows.push_back({std::string(map.key.profile->name), std::string(map.key.arm->name),
                                  map.key.filter(), odd.stiffness, map.hunting, map.largest, map.quantisation,
                                  1e3 * odd.amplitude, 1e3 * odd.without_steps, 1e3 * odd.without_friction});
    }
    return table;
}

/// What a filter does to K_max, by device and arm.
StudyTable filters_table(const StabilityRuns &runs)
{
    StudyTable table{"filters",
                     "K_max with and without a filter",
                     "Carries: the recommended stiffness is below that from which friction can keep it "
                     "hunting; 1: yes.",
                     {{"device", "device"},
                      {"arm", "arm"},
                      {"recommended_n_per_m", "recommended [N/m]"},
                      {"none_n_per_m", "K_max, no filter [N/m]"},
                      {"five_n_per_m", "K_max, 5 Hz [N/m]"},
                      {"five_over_none", "5 Hz / none"},
                      {"worst_hz", "worst filter [Hz]"},
                      {"worst_n_per_m", "K_max with it [N/m]"},
                      {"none_carries", "carries without"},
                      {"five_carries", "with 5 Hz"},
                      {"any_carries", "with any filter of the map"}},
                     {},
                     "stability_map"};
    for (std::size_t first = 0; first < runs.loops.size();) {
        const LoopKey &key = runs.loops[first].key;
        const LoopMap *none = nullptr, *five = nullptr, *worst = nullptr;
        bool any = false;
        std::size_t end = first;
        for (; end < runs.loops.size() && runs.loops[end].key.profile == key.profile &&
               runs.loops[end].key.arm == key.arm;
             ++end) {
            const LoopMap &map = runs.loops[end];
            none = map.key.hertz == 0 ? &map : none;
            five = map.key.hertz == 5 ? &map : five;
            any |= map.key.hertz > 0 && map.hunting > key.profile->max_stiffness;
            if (map.key.hertz > 0 && (!worst || map.largest < worst->largest)) worst = &map;
        }
        if (!none || !five) throw Failure(ExitCode::bug, "", "a map without filter none or 5 Hz");
        const double asked = key.profile->max_stiffness;
        table.rows.push_back({std::string(key.profile->name), std::string(key.arm->name), asked,
                              none->largest, five->largest, five->largest / none->largest, worst->key.hertz,
                              worst->largest, none->hunting > asked ? 1.0 : 0.0,
                              five->hunting > asked ? 1.0 : 0.0, any ? 1.0 : 0.0});
        first = end;
    }
    return table;
}

/// By arm: how many devices.
StudyTable arms_table(const StudyTable &filters)
{
    StudyTable table{"arms",
                     "How many devices carry what is recommended for them",
                     "",
                     {{"arm", "arm"},
                      {"devices", "devices"},
                      {"none_carries", "without a filter"},
                      {"five_carries", "with 5 Hz"},
                      {"any_carries", "with any filter of the map"},
                      {"five_lowers", "5 Hz lowers K_max"},
                      {"five_over_none_least", "to so much of it, least"},
                      {"five_over_none_most", "most"}},
                     {},
                     "stability_map"};
    for (std::uint32_t a = 0; const auto *arm = vxs_simulated_arm_at(a); ++a) {
        double devices = 0, none = 0, five = 0, any = 0, lowers = 0, least = infinity, most = -infinity;
        for (std::size_t n = 0; n < filters.rows.size(); ++n) {
            if (filters.word(n, "arm") != arm->name) continue;
            const double ratio = filters.number(n, "five_over_none");
            ++devices;
            none += filters.number(n, "none_carries");
            five += filters.number(n, "five_carries");
            any += filters.number(n, "any_carries");
            lowers += ratio < 1;
            least = std::min(least, ratio);
            most = std::max(most, ratio);
        }
        table.rows.push_back({std::string(arm->name), devices, none, five, any, lowers, least, most});
    }
    return table;
}

StudyTable springs_table(const StabilityRuns &runs)
{
    StudyTable table{
        "springs",
        "With a quasi-static coupling",
        "What touches hangs on the device by a spring, and the device feels the two in a row: the spring at "
        "most, "
        "however stiff contact is. So the map has no line of contact stiffness for it; K_max is a bound of "
        "the spring. Designed: what design takes for the device in any hand or none. Begins: the spring at "
        "which small motions grow on a contact of 1e6 N/m, foretold 1 / (1 / K_max - 1 / 1e6), and found in "
        "the "
        "time domain. Swings: with the spring as designed, the device as it is, let go 5 mm off, on contacts "
        "of "
        "1, 10, ... 1e6 N/m.",
        {{"device", "device"},
         {"arm", "arm"},
         {"k_max_n_per_m", "K_max without a filter [N/m]"},
         {"designed_n_per_m", "spring as designed [N/m]"},
         {"foretold_n_per_m", "begins at a spring of, foretold [N/m]"},
         {"found_n_per_m", "found [N/m]"},
         {"found_over_foretold", "found / foretold"},
         {"contacts", "contacts"},
         {"swinging", "that swing"},
         {"swing_mm", "by up to [mm]"}},
        {},
        "springs"};
    for (const SpringMap &s : runs.springs) {
        const double most = *std::max_element(s.amplitude.begin(), s.amplitude.end());
        table.rows.push_back({std::string(s.key.profile->name), std::string(s.key.arm->name), s.largest,
                              s.designed, s.foretold, s.found, s.found / s.foretold,
                              static_cast<double>(s.amplitude.size()), static_cast<double>(s.swinging()),
                              s.swinging() > 0 ? 1e3 * most : 0});
    }
    return table;
}

/// Least and most of all springs.
StudyTable springs_agreement(const StudyTable &springs)
{
    StudyTable table{"springs_agreement",
                     "With a quasi-static coupling, all in all",
                     "",
                     {{"loops", "loops"},
                      {"ratio_least", "found / foretold, least"},
                      {"ratio_most", "most"},
                      {"designed_share_most", "spring as designed / K_max, at most"},
                      {"cells", "loops and contacts"},
                      {"swinging", "that swing"}},
                     {},
                     "springs"};
    double least = infinity, most = -infinity, share = 0, cells = 0, swinging = 0;
    for (std::size_t n = 0; n < springs.rows.size(); ++n) {
        least = std::min(least, springs.number(n, "found_over_foretold"));
        most = std::max(most, springs.number(n, "found_over_foretold"));
        share = std::max(share, springs.number(n, "designed_n_per_m") / springs.number(n, "k_max_n_per_m"));
        cells += springs.number(n, "contacts");
        swinging += springs.number(n, "swinging");
    }
    table.rows.push_back({static_cast<double>(springs.rows.size()), least, most, share, cells, swinging});
    return table;
}

StudyTable contact_table(const StabilityRuns &runs)
{
    StudyTable table{"contact_onset",
                     "With the real contact",
                     "A hand presses a body 0.2 mm into a floor; law gradient, field distance; the contact's "
                     "most_stiffness is what grows.",
                     {{"body", "body"},
                      {"device", "device"},
                      {"arm", "arm"},
                      {"filter", "filter"},
                      {"k_max_n_per_m", "K_max [N/m]"},
                      {"found_n_per_m", "bound at which it begins [N/m]"},
                      {"found_over_k_max", "found / K_max"}},
                     {},
                     "contact_onset"};
    for (const ContactOnset &c : runs.contacts) {
        table.rows.push_back({c.body, std::string(c.key.profile->name), std::string(c.key.arm->name),
                              c.key.filter(), c.largest, c.found, c.found / c.largest});
    }
    return table;
}

StudyTable contact_ratios(const StudyTable &contacts)
{
    StudyTable table{"contact_ratios",
                     "With the real contact, least and most",
                     "",
                     {{"body", "body"},
                      {"loops", "loops"},
                      {"ratio_least", "found / K_max, least"},
                      {"ratio_median", "median"},
                      {"ratio_most", "most"}},
                     {},
                     "contact_onset"};
    for (const char *body : {"flat", "ball"}) {
        std::vector<double> ratios;
        for (std::size_t n = 0; n < contacts.rows.size(); ++n) {
            if (contacts.word(n, "body") == body) ratios.push_back(contacts.number(n, "found_over_k_max"));
        }
        std::sort(ratios.begin(), ratios.end());
        if (ratios.empty()) continue;
        table.rows.push_back({std::string(body), static_cast<double>(ratios.size()), ratios.front(),
                              ratios[ratios.size() / 2], ratios.back()});
    }
    return table;
}

} // namespace

std::vector<StudyTable> stability_tables(const StabilityRuns &runs)
{
    std::vector<StudyTable> tables{agreement_table(runs)};
    if (StudyTable odd = odd_table(runs); !odd.rows.empty()) tables.push_back(std::move(odd));
    StudyTable filters = filters_table(runs), contacts = contact_table(runs);
    tables.push_back(arms_table(filters));
    tables.push_back(std::move(filters));
    tables.push_back(loops_table(runs));
    StudyTable springs = springs_table(runs);
    tables.push_back(springs_agreement(springs));
    tables.push_back(std::move(springs));
    tables.push_back(contact_ratios(contacts));
    tables.push_back(std::move(contacts));
    return tables;
}

} // namespace voxshell
