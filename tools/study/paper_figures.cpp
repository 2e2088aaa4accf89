// SPDX-License-Identifier: GPL-3.0-or-later
// The paper's figures 8, 9, 11 and 12 in its own arrangement, and ours beside them.
#include "study/gnuplot.hpp"
#include "study/palette.hpp"
#include "study/paper_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr double shown_depth_e = 0.5;
constexpr unsigned shown_seeds = 5;

const PathRun &path_run(const PaperRuns &runs, const std::string &id, double level, unsigned seed = 1,
                        std::size_t variant = 0)
{
    for (const PathRun &run : runs.paths) {
        if (id == run.key.scenario->id && run.key.level_value() == level && run.key.seed == seed &&
            run.key.variant == variant)
            return run;
    }
    throw Failure(ExitCode::bug, id, "no such run");
}

const LoopRun &loop_run(const PaperRuns &runs, const std::string &id, std::size_t variant)
{
    for (const LoopRun &run : runs.loops) {
        if (id == run.key.scenario->id && run.key.variant == variant && run.key.seed == 1) return run;
    }
    throw Failure(ExitCode::bug, id, "no such run");
}

StudyFigure figure8(const PaperRuns &runs)
{
    StudyFigure figure{
        "fig8",
        "Figure 8: force across the plane's normal, a ball sliding at constant depth",
        fmt::format(
            "Each line leads from the ball's middle to the head of the tangential force, in % of the mean "
            "normal force; depth {} e, up to {} seeds. "
            "Ideal is a dot in the middle. Above: plane along the grid; below: turned by Ry(30)Rx(20).",
            shown_depth_e, shown_seeds),
        "panel,seed,t_s,across_x_pct,across_y_pct\n",
        "",
        900,
        940};
    double most = 0;
    for (const char *panel : {"a", "b", "c", "d"}) {
        for (unsigned seed = 1; seed <= shown_seeds; ++seed) {
            const std::string id = std::string("fig8") + panel;
            const auto found = std::find_if(runs.paths.begin(), runs.paths.end(), [&](const PathRun &r) {
                return r.key.seed == seed && id == r.key.scenario->id;
            });
            if (found == runs.paths.end()) continue;
            const PathRun &run = path_run(runs, id, shown_depth_e, seed);
            if (!(run.metrics.normal > 0)) continue;
            for (std::size_t n = 0; n < run.samples.size(); n += 20) {
                const double x = 100 * run.samples[n].force[1] / run.metrics.normal,
                             y = 100 * run.samples[n].force[2] / run.metrics.normal;
                most = std::max({most, std::abs(x), std::abs(y)});
                figure.csv += fmt::format("{},{},{:.3f},{:.5g},{:.5g}\n", panel, seed, run.progress[n], x, y);
            }
        }
    }
    const double end = std::max(1.0, std::ceil(most));
    figure.script = gnuplot_panels(figure.height, 2, 2) +
                    fmt::format("set size ratio -1\nset xrange [-{0}:{0}]\nset yrange "
                                "[-{0}:{0}]\nset xtics 2\nset ytics 2\nunset key\n",
                                end);
    const struct {
        const char *panel, *title, *colour;
    } panels[] = {{"a", "a  along the grid, original", palette::vermilion},
                  {"b", "b  along the grid, average", palette::blue},
                  {"c", "c  turned, original", palette::vermilion},
                  {"d", "d  turned, average", palette::blue}};
    for (const auto &p : panels) {
        figure.script += fmt::format(
            "set title '{0}'\nset xlabel '{1}'\nset ylabel '{2}'\n"
            "plot $data using (0):(0):(strcol(1) eq '{3}' ? $4 : NaN):5 with vectors nohead lw 0.5 lc rgb "
            "'{4}', "
            "$data using (strcol(1) eq '{3}' ? $4 : NaN):5 with points pt 7 ps 0.25 lc rgb '{4}'\n{5}",
            p.title, p.panel[0] >= 'c' ? "across, x [% of normal force]" : "",
            p.panel[0] == 'a' || p.panel[0] == 'c' ? "across, y [%]" : "", p.panel, p.colour,
            gnuplot_said_once);
    }
    figure.script += "unset multiplot\n";
    return figure;
}

/// Over the time of one turn: column `what` of both laws.
StudyFigure figure9(const PaperRuns &runs, bool across)
{
    StudyFigure figure{
        across ? "fig9" : "fig9_normal",
        across ? "Figure 9: force across the cylinder's normal, in one direction"
               : "Figure 9, what it does not show: the normal force",
        across
            ? fmt::format("The ball goes once round the cylinder, {} e deep; the component along its way, in "
                          "% of the mean normal force.",
                          shown_depth_e)
            : fmt::format("The same ticks: the normal force itself, in % of its mean. Both laws of the paper "
                          "leave its ripple; a trilinear distance with its gradient does not. {} e deep.",
                          shown_depth_e),
        "t_s,original_pct,average_pct,gradient_distance_pct\n",
        "",
        900,
        across ? 620 : 760};
    const PathRun &a = path_run(runs, "fig9a", shown_depth_e), &b = path_run(runs, "fig9b", shown_depth_e);
    const Scenario &control = paper_scenario("control9");
    const auto smooth = std::find_if(control.variants.begin(), control.variants.end(), [](const Variant &v) {
        return v.method.law == VXS_CONTACT_GRADIENT && v.method.shell == ShellKind::exact;
    });
    const PathRun &c = path_run(runs, "control9", shown_depth_e, 1,
                                static_cast<std::size_t>(smooth - control.variants.begin()));
    const std::size_t axis = across ? 2 : 0;
    double most = 0;
    for (std::size_t n = 0; n < a.samples.size(); n += 2) {
        figure.csv += fmt::format("{:.3f}", a.progress[n]);
        for (const PathRun *run : {&a, &b, &c}) {
            const double y = 100 * run->samples[n].force[axis] / run->metrics.normal;
            if (run != &c) most = std::max(most, std::abs(y));
            figure.csv += fmt::format(",{:.5g}", y);
        }
        figure.csv += '\n';
    }
    const double end = 5 * std::ceil(most / 5);
    figure.script = gnuplot_panels(figure.height, across ? 2 : 3, 1) +
                    fmt::format("set xrange [0:3]\nunset key\nset ylabel '{} [%]'\n",
                                across ? "force across" : "normal force") +
                    (across ? fmt::format("set yrange [-{0}:{0}]\nset ytics 5\n", end)
                            : fmt::format("set yrange [0:{}]\nset ytics 50\n", end));
    figure.script +=
        fmt::format("set title 'a  original'\nplot $data using 1:2 with lines lw 1 lc rgb '{}'\n{}",
                    palette::vermilion, gnuplot_said_once);
    if (across) figure.script += "set xlabel 'time [s]'\n";
    figure.script += fmt::format("set title 'b  average'\nplot $data using 1:3 with lines lw 1 lc rgb '{}'\n",
                                 palette::blue);
    if (!across)
        figure.script += fmt::format("set xlabel 'time [s]'\nset title 'ours: field distance, law "
                                     "gradient'\nplot $data using 1:4 with lines lw 1 lc rgb '{}'\n",
                                     palette::green);
    figure.script += "unset multiplot\n";
    return figure;
}

StudyFigure figure_ratios(const StudyTable &ratios)
{
    StudyFigure figure{"average_over_original",
                       "Average over original: how much of the tangential peak is left",
                       "The paper's pairs, seed by seed: mean and standard deviation over the seeds. Below "
                       "the line at 0.7 the averaged normal takes away what we ask of it.",
                       "pair,depth_e,peak,deviation\n",
                       "",
                       900,
                       520};
    for (std::size_t n = 0; n < ratios.rows.size(); ++n) {
        const std::string pair = std::get<std::string>(ratios.rows[n][0]);
        if (pair.starts_with("fig"))
            figure.csv += fmt::format("{},{},{},{}\n", pair, ratios.number(n, "level"),
                                      ratios.number(n, "peak"), ratios.number(n, "peak_deviation"));
    }
    const struct {
        const char *pair, *title, *colour;
        double shift;
        int point;
    } pairs[] = {{"fig8b / fig8a", "8b / 8a, plane along the grid", palette::black, -0.15, 4},
                 {"fig8d / fig8c", "8d / 8c, turned plane", palette::blue, 0, 7},
                 {"fig9b / fig9a", "9b / 9a, cylinder", palette::green, 0.15, 9}};
    figure.script =
        "set tmargin 1\nset bmargin 6\nset xrange [0.5:3.5]\nset yrange [0:*]\nset xtics ('0.25 e' 1, '0.5 "
        "e' 2, '1 e' 3)\nset xlabel 'depth'\n"
        "set ylabel 'tangential peak, ratio'\nset key bottom left Left reverse opaque box lc rgb '#d8d8d8'\n"
        "set arrow 1 from graph 0, first 0.7 to graph 1, first 0.7 nohead dt 2 lc rgb '#606060'\nset label 1 "
        "'0.7' at graph 0.005, first 0.7 offset 0, 0.6\n"
        "place(depth) = depth < 0.3 ? 1 : depth < 0.7 ? 2 : 3\nplot ";
    for (const auto &p : pairs) {
        figure.script += fmt::format("{}$data using (strcol(1) eq '{}' ? place($2) + {} : NaN):3:4 with "
                                     "yerrorbars pt {} ps 1.4 lw 2 lc rgb '{}' title '{}'",
                                     p.shift < 0 ? "" : ", ", p.pair, p.shift, p.point, p.colour, p.title);
    }
    figure.script += "\n";
    return figure;
}

/// Methods of the control from worse to better, on one axis each.
StudyFigure figure_control(const StudyTable &control)
{
    StudyFigure figure{
        "control",
        "All methods: what stays across the normal, and in it",
        "Exact and naive shells, each law and field, 0.5 e deep, means over the seeds. Left: tangential "
        "force; right: ripple of the normal force; both in % of the mean normal force, on logarithmic axes.",
        "stands,method,across_rms_pct,ripple_pct,place\n",
        "",
        900,
        800};
    std::string tics, blank;
    int place = 0;
    for (const bool is_round : {false, true}) {
        place = 0;
        for (std::size_t n = 0; n < control.rows.size(); ++n) {
            const auto word = [&](std::size_t column) {
                return std::get<std::string>(control.rows[n][column]);
            };
            if (word(0) != (is_round ? "control9" : "control8") || word(4) != "count" ||
                control.number(n, "level") != shown_depth_e)
                continue;
            const std::string method = fmt::format("{}, {}, {}", word(1), word(2), word(3));
            ++place;
            if (!is_round) blank += fmt::format("{}'' {}", blank.empty() ? "" : ", ", place);
            if (!is_round) tics += fmt::format("{}'{}' {}", tics.empty() ? "" : ", ", method, place);
            figure.csv +=
                fmt::format("{},\"{}\",{:.5g},{:.5g},{}\n", is_round ? "cylinder" : "plane", method,
                            control.number(n, "across_rms_pct"), control.number(n, "ripple_pct"), place);
        }
    }
    figure.script = fmt::format("set multiplot layout 1,2 margins 0.27,0.975,0.13,0.98 spacing 0.07,0.1\nset "
                                "yrange [{}.7:0.3]\nset logscale x\nset xrange [1e-4:100]\n"
                                "set format x '10^{{%L}}'\nset ytics ({})\nset key at graph 0.62, graph 0.98 "
                                "right top\nset xlabel 'tangential rms [%]'\n",
                                place, tics);
    const auto plot = [&](int column, bool key) {
        return fmt::format(
            "plot $data using (strcol(1) eq 'plane' ? ${0} : NaN):5 with points pt 7 ps 1.1 lc rgb '{1}' "
            "{3}, "
            "$data using (strcol(1) eq 'cylinder' ? ${0} : NaN):5 with points pt 9 ps 1.2 lc rgb '{2}' {4}\n",
            column, palette::blue, palette::vermilion, key ? "title 'turned plane'" : "notitle",
            key ? "title 'cylinder'" : "notitle");
    };
    figure.script += plot(3, true) + gnuplot_said_once + fmt::format("set ytics ({})\n", blank) +
                     "set xlabel 'ripple of the normal force [%]'\nset xrange [1e-4:100]\n" + plot(4, false) +
                     "unset multiplot\n";
    return figure;
}

struct Curve {
    std::size_t variant;
    const char *colour, *dash;
};

/// Of fit's variants (paper_scenarios.cpp) those that are drawn.
constexpr Curve curves[] = {{1, palette::blue, "1"},
                            {2, palette::vermilion, "'-'"},
                            {3, palette::black, "'.'"},
                            {4, palette::green, "1"}};

/// Wedge and peg: a panel a level, a curve a method, over what the path goes along.
StudyFigure figure_fits(const PaperRuns &runs, const std::string &id, std::size_t every)
{
    const Scenario &scenario = paper_scenario(id);
    const bool is_peg = id == "peg";
    StudyFigure figure{
        id,
        is_peg ? "Peg in hole: torque while it goes in" : "Wedge: pressed into a groove of 60 degrees",
        is_peg ? "Torque about the peg's middle over its radius; hole of 20 mm, peg tilted by a degree, "
                 "cells of 1 mm: fits are finer than a cell. The ideal of 19.6 mm is none."
               : "Angle between force and that of an elastic foundation on both walls, over the depth at the "
                 "first wall.",
        is_peg ? "level,progress_mm" : "level,depth_e",
        "",
        900,
        is_peg ? 900 : 720};
    for (const Curve &curve : curves) {
        const Method &m = scenario.variants[curve.variant].method;
        figure.csv += fmt::format(",{}_{}_{}", law_name(m.law), field_name(m.field), is_peg ? "ke" : "deg");
    }
    figure.csv += '\n';
    for (const double level : scenario.levels) {
        const std::size_t count = path_run(runs, id, level).samples.size();
        for (std::size_t n = 0; n < count; n += every) {
            figure.csv += fmt::format("{},{:.5g}", level, path_run(runs, id, level).progress[n]);
            for (const Curve &curve : curves) {
                const ForceSample &s = path_run(runs, id, level, 1, curve.variant).samples[n];
                const auto size = [](const Point &p) {
                    return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
                };
                const double both = size(s.force) * size(s.ideal_force), dot = s.force[0] * s.ideal_force[0] +
                                                                               s.force[1] * s.ideal_force[1] +
                                                                               s.force[2] * s.ideal_force[2];
                if (is_peg) {
                    figure.csv += fmt::format(",{:.5g}", size(s.torque) / (level / 2e3));
                } else {
                    figure.csv += both > 0
                                      ? fmt::format(",{:.5g}", std::acos(std::clamp(dot / both, -1.0, 1.0)) *
                                                                   57.29577951308232)
                                      : std::string(",");
                }
            }
            figure.csv += '\n';
        }
    }
    figure.script =
        gnuplot_panels(figure.height, static_cast<int>(scenario.levels.size()), 1) +
        "set key top right Left reverse opaque box lc rgb '#d8d8d8' samplen 3\n" +
        (is_peg ? "set ylabel 'torque / radius [k e]'\nset xrange [0:15]\nset yrange [0:*]\n"
                : "set ylabel 'off by [degrees]'\nset xrange [0:2]\nset yrange [0:60]\nset ytics 20\n");
    for (std::size_t n = 0; n < scenario.levels.size(); ++n) {
        const double level = scenario.levels[n];
        figure.script += fmt::format("set title '{}'\n", is_peg       ? fmt::format("peg of {} mm", level)
                                                         : level == 1 ? "both walls alike"
                                                                      : "the other wall half as deep");
        if (n + 1 == scenario.levels.size())
            figure.script += is_peg ? "set xlabel 'way in [mm]'\n" : "set xlabel 'depth [e]'\n";
        figure.script += "plot ";
        for (std::size_t c = 0; c < std::size(curves); ++c) {
            const Method &m = scenario.variants[curves[c].variant].method;
            figure.script += fmt::format(
                "{}$data using ($1 == {} ? $2 : NaN):{} with lines lw 2 dt {} lc rgb '{}' {}", c ? ", " : "",
                level, c + 3, curves[c].dash, curves[c].colour,
                n == 0 ? fmt::format("title '{}, {}'", law_name(m.law), field_name(m.field)) : "notitle");
        }
        figure.script += "\nunset key\n" + std::string(gnuplot_said_once);
    }
    figure.script += "unset multiplot\n";
    return figure;
}

std::string automatic_title(const std::string &coupling, const char *method)
{
    return fmt::format("automatic: {}; {}", coupling.substr(0, coupling.find(" (auto)")), method);
}

StudyFigure figure11(const PaperRuns &runs)
{
    const Scenario &scenario = paper_scenario("fig11");
    StudyFigure figure{"fig11",
                       "Figure 11: the same contact through several couplings",
                       "Round the cylinder 0.5 e deep after an approach of half a second. Thin: contact at "
                       "the device; thick: what would be felt. Both along the normal; law average, field "
                       "surface, but for the last: patches and distance.",
                       "t_s",
                       "",
                       900,
                       1300};
    for (const Variant &variant : scenario.variants) {
        std::string name = coupled_text(variant.coupled);
        std::replace(name.begin(), name.end(), ' ', '_');
        name += '_';
        name += field_name(variant.method.field);
        figure.csv += fmt::format(",{0}_contact_n,{0}_n", name);
    }
    figure.csv += '\n';
    const LoopRun &first = loop_run(runs, "fig11", 0);
    for (std::size_t n = 0; n < first.time.size(); n += 2) {
        figure.csv += fmt::format("{:.3f}", first.time[n]);
        for (std::size_t v = 0; v < scenario.variants.size(); ++v) {
            const LoopRun &run = loop_run(runs, "fig11", v);
            figure.csv += fmt::format(",{:.5g},{:.5g}", run.collision[n], run.output[n]);
        }
        figure.csv += '\n';
    }
    figure.script = gnuplot_panels(figure.height, static_cast<int>(scenario.variants.size()), 1) +
                    "set xrange [0:3.5]\nset yrange [0:12]\nset ytics 5\nunset key\nset ylabel 'force [N]'\n";
    const char *titles[] = {"none",
                            "spring-damper (0.05 kg, 1 N/mm, damping 0.7)",
                            "PT2 5 Hz, damping 1 (the paper)",
                            "PT2 50 Hz, damping 1",
                            nullptr,
                            nullptr};
    for (std::size_t v = 0; v < scenario.variants.size(); ++v) {
        const std::string title = titles[v]
                                      ? titles[v]
                                      : automatic_title(loop_run(runs, "fig11", v).coupling,
                                                        v == 4 ? "average, surface" : "patch, distance");
        if (v + 1 == scenario.variants.size()) figure.script += "set xlabel 'time [s]'\n";
        figure.script += fmt::format(
            "set title '{}'\nplot $data using 1:{} with lines lw 0.7 lc rgb '{}', $data using "
            "1:{} with lines lw 2.5 lc rgb '{}'\n{}",
            title, 2 * v + 2, palette::amber, 2 * v + 3,
            v + 1 == scenario.variants.size() ? palette::green : palette::blue, gnuplot_said_once);
    }
    figure.script += "unset multiplot\n";
    return figure;
}

StudyFigure figure12(const PaperRuns &runs, std::size_t variant, const std::string &id,
                     const std::string &what)
{
    StudyFigure figure{id,
                       "Figure 12" + what,
                       "Thin: collision force; thick: output force, as commanded to the device; sizes, one "
                       "seed. Left an abrupt collision, right sliding; above the Phantom Premium 1.5, below "
                       "the DLR light-weight robot, both held by a hand. The time begins with the motion.",
                       "panel,t_s,collision_n,output_n\n",
                       "",
                       900,
                       760};
    std::string plots;
    for (const char *panel : {"a", "b", "c", "d"}) {
        const LoopRun &run = loop_run(runs, std::string("fig12") + panel, variant);
        for (std::size_t n = 0; n < run.time.size(); n += 2) {
            if (run.time[n] >= 0)
                figure.csv += fmt::format("{},{:.3f},{:.5g},{:.5g}\n", panel, run.time[n], run.collision[n],
                                          run.output[n]);
        }
        const Scenario &scenario = *run.key.scenario;
        if (panel[0] == 'd') figure.script += "set key top right opaque samplen 2\n";
        figure.script += fmt::format(
            "set title '{}  {}, {:g} mm/s'\nset xlabel '{}'\nset ylabel '{}'\nset xrange [0:{}]\n"
            "plot $data using (strcol(1) eq '{}' ? $2 : NaN):3 with lines lw 0.7 lc rgb '{}' {}, $data using "
            "(strcol(1) eq '{}' ? $2 : NaN):4 with lines lw 2.5 lc rgb '{}' {}\n{}",
            panel, panel[0] < 'c' ? "Premium 1.5" : "light-weight robot", 1e3 * scenario.speeds[0],
            panel[0] < 'c' ? "" : "time [s]", panel[0] == 'a' || panel[0] == 'c' ? "force [N]" : "",
            std::ceil(10 * run.time.back()) / 10, panel, palette::amber,
            panel[0] == 'd' ? "title 'collision force'" : "notitle", panel, palette::blue,
            panel[0] == 'd' ? "title 'output force'" : "notitle", gnuplot_said_once);
    }
    figure.script = gnuplot_panels(figure.height, 2, 2, 0.075) + "set yrange [0:*]\nunset key\n" +
                    figure.script + "unset multiplot\n";
    return figure;
}

/// Thickness against speed: through or not.
StudyFigure figure_wall(const StudyTable &wall)
{
    StudyFigure figure{"wall",
                       "Walls: thickness and speed at which the probe comes through",
                       "Filled: the object's deepest point came out behind with all seeds; open: with none; "
                       "in between by the share of the seeds. The hand's target is 8 mm behind the front.",
                       "law,field,coupling,thickness_e,speed_mm_per_s,through_pct\n",
                       "",
                       900,
                       700};
    std::vector<std::string> panels;
    for (std::size_t n = 0; n < wall.rows.size(); ++n) {
        const auto word = [&](std::size_t column) { return std::get<std::string>(wall.rows[n][column]); };
        const std::string panel = word(2) + ", " + word(3) + ", " + word(5);
        if (panels.empty() || panels.back() != panel) panels.push_back(panel);
        figure.csv +=
            fmt::format("{},{},\"{}\",{},{},{}\n", word(2), word(3), word(5), wall.number(n, "level"),
                        wall.number(n, "speed_mm_per_s"), wall.number(n, "through_pct"));
    }
    figure.script =
        gnuplot_panels(figure.height, 2, 3, 0.05, 2) +
        "unset key\nset logscale x\nset xrange [35:700]\nset xtics (50, 100, "
        "200, 500)\nset yrange [0:6]\nset ytics (1, 2, 3, 5)\n" +
        fmt::format("set label 101 'filled: comes through, open: held' at screen 0.975, screen {:.4f} "
                    "right font ',14'\n",
                    9.0 / figure.height);
    for (std::size_t n = 0; n < panels.size(); ++n) {
        std::string title = panels[n];
        title.replace(title.rfind(", "), 2, "\\n");
        figure.script += fmt::format(
            "set title \"{}\" font ',13'\nset xlabel '{}'\nset ylabel '{}'\nis(law, field, "
            "coupling) = law . ', ' . field . ', ' . coupling eq '{}'\n"
            "plot $data using (is(strcol(1), strcol(2), strcol(3)) ? $5 : NaN):4 with points pt "
            "6 ps 2.2 lw 1.5 lc rgb '{}', "
            "$data using (is(strcol(1), strcol(2), strcol(3)) && $6 > 0 ? $5 : NaN):4:(2.2 * "
            "sqrt($6 / 100)) with points pt 7 ps variable lc rgb '{}'\n{}",
            title, n >= 3 ? "speed [mm/s]" : "", n % 3 == 0 ? "thickness [e]" : "", panels[n], palette::grey,
            palette::vermilion, n == 0 ? "unset label 100\nunset label 101\n" : "");
    }
    figure.script += "unset multiplot\n";
    return figure;
}

} // namespace

std::vector<StudyFigure> paper_figures(const PaperRuns &runs, const Study &study)
{
    std::vector<StudyFigure> figures = point_figures(runs.points);
    for (StudyFigure &figure : std::vector<StudyFigure>{
             figure_ratios(study.table("ratios")), figure8(runs), figure9(runs, true), figure9(runs, false),
             figure_control(study.table("control_means")), figure11(runs),
             figure12(runs, 0, "fig12", ": hitting and sliding on the cup, the paper's coupling"),
             figure12(runs, 5, "fig12_ours", ", ours: patches, distance, a designed spring"),
             figure_wall(study.table("wall_means")), figure_fits(runs, "wedge", 10),
             figure_fits(runs, "peg", 1), figure_spectrum(runs)})
        figures.push_back(std::move(figure));
    return figures;
}

} // namespace voxshell
