// SPDX-License-Identifier: GPL-3.0-or-later
// The error of the force over time and frequency, on the benchmarks whose force is known.
#include "study/gnuplot.hpp"
#include "study/paper_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr std::size_t window = 128; ///< ticks
constexpr double most_hz = 250;
constexpr double least_db = -80, most_db = 0;

const PathRun *run_of(const PaperRuns &runs, const std::string &scenario, double level, std::uint32_t law,
                      std::uint32_t field)
{
    for (const PathRun &run : runs.paths) {
        const Method &m = run.key.how().method;
        if (scenario == run.key.scenario->id && run.key.level_value() == level && run.key.seed == 1 &&
            m.law == law && m.field == field && m.shell == ShellKind::exact &&
            m.weighting == VXS_CONTACT_COUNT)
            return &run;
    }
    throw Failure(ExitCode::bug, scenario, "no such run");
}

} // namespace

StudyFigure figure_spectrum(const PaperRuns &runs)
{
    StudyFigure figure{
        "spectrum",
        "Where the force is wrong, over time and frequency",
        "Power of the force's error in pieces of 128 ms (Hann), in dB of the known force's "
        "mean square, one factor left free; one seed. Left and middle: one force layer; right: "
        "distance. A hand is most sensitive at 200 to 300 Hz. Peg: insertion takes 0.3 s.",
        "panel,t_s,hz,db\n",
        "",
        900,
        1150};
    const struct {
        const char *scenario, *name;
        double level;
        std::uint32_t ours;
    } rows[] = {{"control8", "fig8, turned plane", 0.5, VXS_CONTACT_GRADIENT},
                {"control9", "fig9, cylinder", 0.5, VXS_CONTACT_GRADIENT},
                {"wedge", "wedge aslant", 0.5, VXS_CONTACT_PATCH},
                {"peg", "peg of 20.2 mm", 20.2, VXS_CONTACT_PATCH}};
    constexpr int columns = 3;
    figure.script = gnuplot_panels(figure.height, static_cast<int>(std::size(rows)), columns, 0.05);
    const auto edge = figure.script.find("0.975");
    figure.script.replace(edge, 5, "0.865");
    figure.script += fmt::format(
        "unset key\nunset grid\nset yrange [0:{}]\nset ytics 50\nset cbrange [{}:{}]\nset palette defined (0 "
        "'#ffffff', 1 '#fff0dc', 2 '#fdd49e', 3 '#fc8d59', 4 '#d7301f', 5 '#7f0000')\nset colorbox user "
        "origin screen 0.89, screen 0.35 size screen 0.02, screen 0.35\nset cblabel 'error [dB of the known "
        "force]'\n",
        most_hz, least_db, most_db);
    int panel = 0;
    for (const auto &row : rows) {
        const bool is_last = &row == &rows[std::size(rows) - 1];
        for (int column = 0; column < columns; ++column) {
            const std::uint32_t laws[] = {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE, row.ours};
            const std::uint32_t law = laws[column];
            constexpr std::uint32_t fields[] = {VXS_CONTACT_SURFACE, VXS_CONTACT_SURFACE,
                                                VXS_CONTACT_DISTANCE};
            const PathRun &run = *run_of(runs, row.scenario, row.level, law, fields[column]);
            const std::size_t hop =
                std::max<std::size_t>(1, std::min(window, (run.samples.size() - window) / 16));
            const ShortTimeSpectrum spectrum =
                error_spectrum(run.samples, study_rate, run.radius, window, hop);
            ++panel;
            for (std::size_t piece = 0; piece < spectrum.power.size(); ++piece) {
                for (std::size_t n = 1; spectrum.step_hz * static_cast<double>(n) <= most_hz; ++n) {
                    const double power = spectrum.power[piece][n];
                    figure.csv += fmt::format(
                        "{},{:.4g},{:.5g},{:.3g}\n", panel,
                        spectrum.first_s + spectrum.step_s * static_cast<double>(piece),
                        spectrum.step_hz * static_cast<double>(n),
                        power > 0 ? std::clamp(10 * std::log10(power), least_db, most_db) : least_db);
                }
            }
            const double half = spectrum.step_s / 2, high = spectrum.step_hz / 2;
            figure.script += fmt::format(
                "set title '{}' font ',13'\nset xlabel '{}'\nset ylabel '{}'\nset xrange "
                "[0:{}]\nset xtics {}\nplot $data using ($1 == {} && $4 > -80 ? $2 : NaN):3:($2 - "
                "{:.5f}):($2 + "
                "{:.5f}):($3 - {:.4f}):($3 + {:.4f}):4 with boxxyerror fs solid noborder lc palette\n{}",
                fmt::format("{}: {}", row.name, law_name(law)), is_last ? "time [s]" : "",
                column == 0 ? "frequency [Hz]" : "", static_cast<double>(run.samples.size()) / study_rate,
                run.samples.size() > 1000 ? "1" : "0.1", panel, half, half, high, high, gnuplot_said_once);
            if (panel == 1) figure.script += "unset colorbox\n";
        }
    }
    figure.script += "unset multiplot\n";
    return figure;
}

} // namespace voxshell
