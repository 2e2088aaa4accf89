// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/gnuplot.hpp"
#include "study/palette.hpp"
#include "study/stability_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxshell {
namespace {

constexpr double unfiltered_at = 800; ///< where "none" stands on an axis of filters [Hz]
constexpr const char *k_axis = "set logscale y\nset yrange [1:1e5]\nset ytics (1, 10, 100, '1k' 1000, '10k' "
                               "10000, '100k' 100000)\n";

const struct {
    const char *arm, *colour;
    int point;
} arms[] = {{"free", palette::black, 6},
            {"pen", palette::vermilion, 4},
            {"hand", palette::blue, 8},
            {"arm", palette::green, 12}};

std::vector<std::string> devices_of(const StabilityRuns &runs)
{
    std::vector<std::string> out;
    for (const LoopMap &map : runs.loops) {
        if (out.empty() || out.back() != map.key.profile->name) out.emplace_back(map.key.profile->name);
    }
    return out;
}

/// A sheet with a panel a device: all arms and filters, foretold and found.
StudyFigure stability_map(const StabilityRuns &runs)
{
    const std::vector<std::string> devices = devices_of(runs);
    const int columns = 2, rows = static_cast<int>((devices.size() + 1) / 2);
    StudyFigure figure{
        "stability_map",
        "Where the loop begins to oscillate: stiffness, filter, arm, device",
        "Lines: K_max as foretold; marks: where small motions begin to grow when the runtime's own device "
        "and coupling are run (without friction, encoder steps and clamp). Dotted: from here on friction can "
        "keep it hunting. Below a line it is calm. Grey: the stiffness that is recommended for the device. "
        "Filter: PT2 of damping 1.",
        "device,arm,hertz,k_max_n_per_m,found_n_per_m,hunting_n_per_m,recommended_n_per_m\n",
        "",
        900,
        130 + 270 * rows};
    for (const LoopMap &map : runs.loops) {
        figure.csv += fmt::format("{},{},{},{},{},{},{}\n", map.key.profile->name, map.key.arm->name,
                                  map.key.hertz > 0 ? map.key.hertz : unfiltered_at, map.largest, map.found,
                                  map.hunting, map.key.profile->max_stiffness);
    }
    figure.script = gnuplot_panels(figure.height, rows, columns, 0.09, 1) +
                    fmt::format("set logscale x\nset xrange [1.5:1100]\nset xtics (2, 5, 10, 20, 50, 100, "
                                "200, 'none' {})\n{}unset key\n",
                                unfiltered_at, k_axis);
    for (std::size_t d = 0; d < devices.size(); ++d) {
        const bool last = d + 1 == devices.size();
        figure.script += fmt::format(
            "set title '{}'\nset xlabel '{}'\nset ylabel '{}'\n{}plot $data using (strcol(1) eq '{}' ? $3 : "
            "NaN):7 with lines lw 1.5 lc rgb '#a0a0a0' {}",
            devices[d], d + columns >= devices.size() ? "filter [Hz]" : "",
            d % 2 == 0 ? "contact stiffness [N/m]" : "",
            last ? "set key bottom right opaque samplen 2 width -2 font ',12' maxrows 3\n" : "", devices[d],
            last ? "title 'recommended'" : "notitle");
        for (const auto &arm : arms) {
            const std::string mine =
                fmt::format("(strcol(1) eq '{}' && strcol(2) eq '{}' ? $3 : NaN)", devices[d], arm.arm);
            figure.script += fmt::format(
                ", $data using {0}:4 with lines lw 2 lc rgb '{1}' notitle, $data using {0}:6 with lines lw 1 "
                "dt '.' lc rgb '{1}' notitle, $data using {0}:5 with points pt {2} ps 0.9 lw 1.5 lc rgb "
                "'{1}' {3}",
                mine, arm.colour, arm.point, last ? fmt::format("title '{}'", arm.arm) : "notitle");
        }
        figure.script += "\n" + std::string(gnuplot_said_once);
    }
    figure.script += "unset multiplot\n";
    return figure;
}

/// A sheet a device with a panel an arm: how far it swings, in colour.
StudyFigure amplitude_map(const StabilityRuns &runs, const std::string &device)
{
    std::vector<std::string> filters;
    std::string tics;
    StudyFigure figure{
        "swing_" + device,
        "Limit cycle of " + device + ": stiffness, filter, arm",
        "Colour: half the swing, friction, encoder steps and clamp as they are, let go 5 mm "
        "off; white: two encoder steps at most. Line: K_max as foretold; dotted: from here on "
        "friction can keep it hunting; dashed: passive below; circles: where small motions "
        "begin to grow in the time domain; grey: recommended.",
        "arm,filter,stiffness_n_per_m,amplitude_mm,k_max_n_per_m,hunting_n_per_m,passive_n_per_"
        "m,found_n_per_m,recommended_n_per_m,place\n",
        "",
        900,
        860};
    const double step =
        runs.stiffness.size() > 1 ? std::sqrt(runs.stiffness[1] / runs.stiffness[0]) : std::sqrt(10.0);
    for (const LoopMap &map : runs.loops) {
        if (device != map.key.profile->name) continue;
        const std::string filter = map.key.hertz > 0 ? fmt::format("{:g}", map.key.hertz) : "none";
        auto at = std::find(filters.begin(), filters.end(), filter);
        if (at == filters.end()) {
            filters.push_back(filter);
            at = filters.end() - 1;
            tics += fmt::format("{}'{}' {}", tics.empty() ? "" : ", ", filter, filters.size());
        }
        for (std::size_t n = 0; n < runs.stiffness.size(); ++n) {
            figure.csv +=
                fmt::format("{},{},{:.5g},{:.4g},{:.5g},{:.5g},{:.5g},{:.5g},{},{}\n", map.key.arm->name,
                            map.key.filter(), runs.stiffness[n],
                            map.oscillates(n) ? 1e3 * map.amplitude[n] : 0, map.largest, map.hunting,
                            map.passive, map.found, map.key.profile->max_stiffness, at - filters.begin() + 1);
        }
    }
    figure.script =
        gnuplot_panels(figure.height, 2, 2, 0.07, 1) +
        fmt::format("unset key\nunset grid\nset xrange [0.5:{}.5]\nset xtics ({})\n{}set logscale cb\nset "
                    "cbrange [0.01:100]\nset palette defined (0 '#fff7ec', 1 '#fdd49e', 2 '#fc8d59', 3 "
                    "'#d7301f', 4 '#7f0000')\nunset colorbox\n",
                    filters.size(), tics, k_axis);
    // Room for the colours at the right of all panels.
    const auto edge = figure.script.find("0.975");
    figure.script.replace(edge, 5, "0.875");
    for (std::size_t a = 0; a < std::size(arms); ++a) {
        const std::string mine = fmt::format("(strcol(1) eq '{}' ? $10 : NaN)", arms[a].arm);
        if (a == 1) {
            figure.script += "set colorbox user origin screen 0.9, screen 0.3 size screen 0.022, screen "
                             "0.45\nset format cb '%g'\nset cblabel 'half the swing [mm]'\n";
        } else if (a == 2) {
            figure.script += "unset colorbox\n";
        }
        figure.script += fmt::format(
            "set title '{0}'\nset xlabel '{1}'\nset ylabel '{2}'\n"
            "plot $data using (strcol(1) eq '{3}' && $4 > 0 ? $10 : NaN):3:($10 - 0.5):($10 + 0.5):($3 / "
            "{4:.6f}):($3 * "
            "{4:.6f}):($4 > 100 ? 100 : $4) with boxxyerror fs solid noborder lc palette, "
            "$data using {5}:9 with lines lw 1.5 lc rgb '#808080', $data using {5}:7 with lines lw 2 dt '-' "
            "lc rgb '{6}', $data using {5}:6 with lines lw 2 dt '.' lc rgb '{7}', $data using {5}:5 with "
            "lines lw 2 lc rgb '{7}', $data using {5}:8 with points pt 6 ps 1 lw 1.5 lc rgb '{7}'\n{8}",
            arms[a].arm == std::string("free") ? "free (nobody holds it)" : arms[a].arm,
            a >= 2 ? "filter [Hz]" : "", a % 2 == 0 ? "contact stiffness [N/m]" : "", arms[a].arm, step, mine,
            palette::blue, palette::black, gnuplot_said_once);
    }
    figure.script += "unset multiplot\n";
    return figure;
}

StudyFigure springs_figure(const StabilityRuns &runs)
{
    StudyFigure figure{"springs",
                       "Quasi-static coupling: the spring at which it begins, foretold and found",
                       "A contact of 1e6 N/m; each mark a device in a hand. Crosses: the spring that design "
                       "takes for the device, "
                       "calm with contacts of 1 to 1e6 N/m where they lie below the line.",
                       "device,arm,foretold_n_per_m,found_n_per_m,designed_n_per_m\n",
                       "",
                       900,
                       640};
    for (const SpringMap &s : runs.springs)
        figure.csv += fmt::format("{},{},{:.6g},{:.6g},{:.6g}\n", s.key.profile->name, s.key.arm->name,
                                  s.foretold, s.found, s.designed);
    figure.script = fmt::format(
        "set tmargin 1\nset bmargin 6\nset lmargin 12\nset rmargin 3\nset logscale xy\nset format x "
        "'10^{{%L}}'\nset format y '10^{{%L}}'\nset xlabel 'spring at which it begins, foretold [N/m]'\nset "
        "ylabel "
        "'spring [N/m]'\nset key top left Left reverse opaque\n"
        "stats $data using 3 name 'X' nooutput\nstats $data using 5 name 'Y' nooutput\n"
        "set xrange [X_min/2:X_max*2]\nset yrange [Y_min/2:X_max*4]\n"
        "plot x with lines lw 1.5 lc rgb '{}' title 'as foretold', $data using 3:5 with points pt 2 ps 1.2 "
        "lw 1.5 "
        "lc rgb '{}' title 'as designed'",
        palette::grey, palette::grey);
    for (const auto &arm : arms)
        figure.script +=
            fmt::format(", $data using (strcol(2) eq '{}' ? $3 : NaN):4 with points pt {} ps 1.3 lw 1.8 lc "
                        "rgb '{}' title 'found: {}'",
                        arm.arm, arm.point, arm.colour, arm.arm);
    figure.script += "\n";
    return figure;
}

StudyFigure contact_onset(const StabilityRuns &runs)
{
    StudyFigure figure{"contact_onset",
                       "The same with the real contact: foretold and found",
                       "A body that a hand presses into a floor; the contact's stiffness as a whole is "
                       "bounded by most_stiffness, which grows until small motions do. On the line the bound "
                       "is what the loop feels; above it the loop feels less.",
                       "body,arm,k_max_n_per_m,found_n_per_m\n",
                       "",
                       900,
                       640};
    for (const ContactOnset &c : runs.contacts)
        figure.csv += fmt::format("{},{},{:.6g},{:.6g}\n", c.body, c.key.arm->name, c.largest, c.found);
    figure.script = fmt::format(
        "set tmargin 1\nset bmargin 6\nset lmargin 12\nset rmargin 3\nset logscale xy\nset format x "
        "'10^{{%L}}'\nset format y '10^{{%L}}'\nset xlabel 'K_{{max}} as foretold [N/m]'\nset ylabel 'bound "
        "at which it begins [N/m]'\nset key top left Left reverse opaque\n"
        "stats $data using 3 nooutput\nset xrange [STATS_min/2:STATS_max*2]\nset yrange "
        "[STATS_min/2:STATS_max*4]\n"
        "plot x with lines lw 1.5 lc rgb '{0}' title 'as foretold', $data using (strcol(1) eq 'flat' ? $3 : "
        "NaN):4 with points pt 5 ps 1.1 lc rgb "
        "'{1}' title 'flat body', $data using (strcol(1) eq 'ball' ? $3 : NaN):4 with points pt 6 ps 1.4 lw "
        "2 lc rgb '{2}' title 'ball'\n",
        palette::grey, palette::blue, palette::vermilion);
    return figure;
}

} // namespace

std::vector<StudyFigure> stability_figures(const StabilityRuns &runs)
{
    std::vector<StudyFigure> figures{stability_map(runs)};
    for (const std::string &device : devices_of(runs)) figures.push_back(amplitude_map(runs, device));
    figures.push_back(springs_figure(runs));
    figures.push_back(contact_onset(runs));
    return figures;
}

} // namespace voxshell
