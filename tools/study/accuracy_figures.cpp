// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/accuracy_study.hpp"

#include "cli/options.hpp"
#include "study/gnuplot.hpp"
#include "study/palette.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr double us = 1e-3;
constexpr double middle_law = (VXS_CONTACT_ORIGINAL + VXS_CONTACT_PATCH) / 2.0;

struct Look {
    const char *name, *colour;
};
constexpr Look laws[] = {{"original", palette::vermilion},
                         {"average", palette::blue},
                         {"patch", palette::purple},
                         {"gradient", palette::green}};
struct Symbol {
    const char *name;
    int point; ///< of gnuplot
};
constexpr Symbol fields[] = {{"surface", 6}, {"layers", 8}, {"distance", 5}};

std::string tick_text(double at)
{
    return at >= 1e6 ? fmt::format("{:g}x10^6", at / 1e6) : fmt::format("{:g}", at);
}

/// Ticks as plain numbers, as many as a picture of half the width can hold.
std::string log_axis(char axis, double low, double high)
{
    const std::vector<double> parts = high / low > 300 ? std::vector<double>{1}
                                      : high / low > 8 ? std::vector<double>{1, 2, 5}
                                                       : std::vector<double>{1, 1.5, 2, 3, 4, 5, 7};
    std::string tics;
    for (double decade = std::pow(10, std::floor(std::log10(low)) - 1); decade < 100 * high; decade *= 10) {
        for (const double part : parts) {
            const double at = decade * part;
            if (at < low / 1.01 || at > high * 1.01) continue;
            tics += fmt::format("{}'{}' {:g}", tics.empty() ? "" : ", ", tick_text(at), at);
        }
    }
    return fmt::format("set logscale {0}\nset {0}range [{1:g}:{2:g}]\nset {0}tics ({3})\n", axis, low, high,
                       tics);
}

/// A decent range around values that are all above 0.
struct Range {
    double low = 1e300, high = 0;
    void take(double value)
    {
        if (!(value > 0)) return;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    bool is_empty() const { return !(high > 0); }
    std::string axis(char name) const
    {
        const double end = name == 'y' ? std::max(high, 1.5 * low) : high;
        return log_axis(name, low / 1.5, end * 1.35);
    }
};

struct Cost {
    const char *id, *title, *caption, *axis;
    bool timed;
    bool by_law; ///< else it hangs on voxel edge, field and shell alone, and laws stand side by side
    double (*of)(const AccuracyRow &);
};

/// Whether another weighting of the same errs less.
bool is_beaten_by_weighting(const AccuracyResult &result, const AccuracyRow &row)
{
    return std::any_of(result.rows.begin(), result.rows.end(), [&](const AccuracyRow &r) {
        AccuracyConfig config = r.config;
        config.method.weighting = row.config.method.weighting;
        return config == row.config && r.error < row.error;
    });
}

/// Error against a cost: all configurations, what nothing beats, the scene's own and the one that is advised.
StudyFigure pareto(const AccuracyResult &result, const Advice &advice, const Cost &cost)
{
    StudyFigure figure{
        cost.id, cost.title, cost.caption, "law,field,shell,weighting,voxel_mm,cost,error_pct,mark,place\n",
        "",      900,        600,          cost.timed};
    const AccuracyConfig own{result.scene.voxel, result.scene.method};
    Range x, y;
    for (const AccuracyRow &r : result.rows) {
        x.take(cost.of(r));
        y.take(100 * r.error);
    }
    const double aside = cost.by_law ? 1 : std::pow(1.82 * x.high / x.low, 0.018);
    const auto place = [&](const AccuracyRow &r) {
        return cost.of(r) * std::pow(aside, static_cast<double>(r.config.method.law) - middle_law);
    };
    for (const AccuracyRow &r : result.rows) {
        const Method &m = r.config.method;
        if (!cost.by_law && !(r.config == own) && is_beaten_by_weighting(result, r)) continue;
        figure.csv +=
            fmt::format("{},{},{},{},{:g},{:.6g},{:.6g},{},{:.6g}\n", law_name(m.law), field_name(m.field),
                        shell_name(m.shell), weighting_name(m.weighting), 1e3 * r.config.voxel, cost.of(r),
                        100 * r.error, r.config == own ? "own" : "-", place(r));
    }
    if (cost.timed && advice.taken) {
        const AccuracyRow &r = result.rows[*advice.taken];
        figure.csv += fmt::format(",,,,,{:.6g},{:.6g},advised,{:.6g}\n", cost.of(r), 100 * r.error, place(r));
    }
    for (const std::size_t n : front(result, cost.of))
        figure.csv += fmt::format(",,,,,{0:.6g},{1:.6g},front,{0:.6g}\n", cost.of(result.rows[n]),
                                  100 * result.rows[n].error);
    figure.script = "set tmargin 1\nset bmargin 6\nset rmargin 24\n" + x.axis('x') + y.axis('y') +
                    fmt::format("set xlabel '{}'\nset ylabel 'error of force and torque [%]'\n"
                                "set key at graph 1.03, graph 1 left top Left reverse samplen 1.5\nplot ",
                                cost.axis);
    figure.script += fmt::format("$data using (strcol(8) eq 'front' ? $9 : NaN):7 with steps lw 1.5 lc rgb "
                                 "'{}' title 'beaten by none'",
                                 palette::black);
    for (const Look &law : laws) {
        for (const Symbol &field : fields) {
            if (std::string(law.name) == "gradient" && std::string(field.name) != "distance") continue;
            figure.script +=
                fmt::format(", $data using (strcol(1) eq '{}' && strcol(2) eq '{}' ? $9 : NaN):7 with points "
                            "pt {} ps 1.1 lw 1.3 lc rgb '{}' notitle",
                            law.name, field.name, field.point, law.colour);
        }
    }
    figure.script +=
        fmt::format(", $data using (strcol(8) eq 'own' ? $9 : NaN):7 with points pt 4 ps 2.6 lw 2 lc rgb "
                    "'{}' title 'as the scene is'",
                    palette::grey);
    if (cost.timed && advice.taken)
        figure.script +=
            fmt::format(", $data using (strcol(8) eq 'advised' ? $9 : NaN):7 with points pt 6 ps 2.8 lw 2.5 "
                        "lc rgb '{}' title 'advised'",
                        palette::black);
    for (const Look &law : laws)
        figure.script +=
            fmt::format(", keyentry with points pt 7 ps 1.1 lc rgb '{}' title '{}'", law.colour, law.name);
    for (const Symbol &field : fields)
        figure.script += fmt::format(", keyentry with points pt {} ps 1 lw 1.3 lc rgb '{}' title '{}'",
                                     field.point, palette::grey, field.name);
    figure.script += "\n";
    return figure;
}

/// The scene's weighting by area, exact shell: a line for each law and field.
StudyFigure over_voxel(const AccuracyResult &result)
{
    StudyFigure figure{
        "error_over_voxel",
        "Error over voxel edge: which laws get better with finer cells",
        "Exact shells, weighting by area. A law whose error stays has another cause than its cells.",
        "law,field,voxel_mm,error_pct\n",
        "",
        900,
        560};
    Range x, y;
    std::string edges;
    for (const AccuracyRow &r : result.rows) {
        const Method &m = r.config.method;
        if (m.shell != ShellKind::exact || m.weighting != VXS_CONTACT_AREA) continue;
        const std::string edge = fmt::format("'{0:.3g}' {0:g}", 1e3 * r.config.voxel);
        if (edges.find(edge) == std::string::npos) edges += (edges.empty() ? "" : ", ") + edge;
        x.take(1e3 * r.config.voxel);
        y.take(100 * r.error);
        figure.csv += fmt::format("{},{},{:g},{:.6g}\n", law_name(m.law), field_name(m.field),
                                  1e3 * r.config.voxel, 100 * r.error);
    }
    figure.script = "set tmargin 1\nset bmargin 6\nset rmargin 28\n" + x.axis('x') + y.axis('y') +
                    "set xtics (" + edges +
                    ")\nset datafile missing NaN\nset xlabel 'voxel edge [mm]'\nset ylabel 'error of force "
                    "and torque [%]'\n"
                    "set key at graph 1.03, graph 1 left top Left reverse samplen 3\nplot ";
    bool is_first = true;
    for (const Look &law : laws) {
        for (const Symbol &field : fields) {
            if (std::string(law.name) == "gradient" && std::string(field.name) != "distance") continue;
            figure.script += fmt::format("{}$data using (strcol(1) eq '{}' && strcol(2) eq '{}' ? $3 : "
                                         "NaN):4 with linespoints pt {} ps 1.1 lw "
                                         "1.6 dt {} lc rgb '{}' title '{}, {}'",
                                         is_first ? "" : ", ", law.name, field.name, field.point,
                                         &field - fields + 1, law.colour, law.name, field.name);
            is_first = false;
        }
    }
    figure.script += "\n";
    return figure;
}

/// From the base to the base with one thing changed: error on the left, time on the right.
StudyFigure steps_figure(const AccuracyResult &result, const Study &study)
{
    const StudyTable &table = study.table("steps");
    const std::vector<AccuracyConfig> bases = step_bases(result.scene);
    StudyFigure figure{
        "steps",
        "What each step costs and buys: one thing changed at a time",
        "From the ring to the dot. Above: McNeely's (naive, original, surface, count); below: a field "
        "deep enough (exact, original, distance, area); both at the scene's voxel.",
        "row,base,step,error_from_pct,error_to_pct,p50_from_us,p50_to_us\n",
        "",
        900,
        0,
        true};
    Range errors, times;
    std::string labels, blanks;
    double row = 0;
    const auto name = [&](const std::string &text) {
        labels += fmt::format("{}{} {}", labels.empty() ? "" : ", ", gnuplot_text(text), row);
        blanks += fmt::format("{}'' {}", blanks.empty() ? "" : ", ", row);
    };
    std::string last;
    for (std::size_t n = 0; n < table.rows.size(); ++n) {
        const std::string from = std::get<std::string>(table.rows[n][1]),
                          step = std::get<std::string>(table.rows[n][0]);
        if (from != last) {
            row += n ? 2 : 1;
            name(from == bases.front().text() ? "from McNeely's:" : "from a deep field:");
        }
        last = from;
        row += 1;
        const double e = table.number(n, "error_from_pct"), f = table.number(n, "error_to_pct"),
                     t = table.number(n, "tick_p50_from_us"), u = table.number(n, "tick_p50_to_us");
        for (const double value : {e, f}) errors.take(value);
        for (const double value : {t, u}) times.take(value);
        std::string word = step.substr(0, step.find(", not"));
        name("   " + word);
        word.erase(std::remove(word.begin(), word.end(), ','), word.end());
        figure.csv += fmt::format("{:g},{},{},{:.6g},{:.6g},{:.6g},{:.6g}\n", row,
                                  from == bases.front().text() ? "mcneely" : "deep", word, e, f, t, u);
    }
    figure.height = 150 + static_cast<int>(25 * row);
    figure.script =
        fmt::format("set multiplot layout 1,2\nset yrange [{}:0.2]\nset bmargin 6\nset tmargin 1\n"
                    "set style fill solid\nunset key\n",
                    row + 0.8);
    const struct {
        Range range;
        const char *axis;
        int from;
        double left, right;
    } panels[] = {{errors, "error [%]", 4, 0.31, 0.63}, {times, "tick p50 [us]", 6, 0.68, 0.97}};
    for (const auto &p : panels) {
        const bool first = p.from == 4;
        figure.script +=
            fmt::format("set lmargin at screen {}\nset rmargin at screen {}\n", p.left, p.right) +
            p.range.axis('x') + fmt::format("set xlabel '{}'\n", p.axis) + "set ytics (" +
            (first ? labels : blanks) + ")\n";
        figure.script += fmt::format("plot $data using {0}:1:(${1}-${0}):(0) with vectors nohead lw 2 lc rgb "
                                     "'{2}', $data using {0}:1 with points "
                                     "pt 6 ps 1.2 lw 1.5 lc rgb '{3}', $data using (strcol(2) eq 'mcneely' ? "
                                     "${1} : NaN):1 with points pt 7 ps "
                                     "1.3 lc rgb '{4}', $data using (strcol(2) eq 'deep' ? ${1} : NaN):1 "
                                     "with points pt 7 ps 1.3 lc rgb '{5}'\n{6}",
                                     p.from, p.from + 1, palette::grey, palette::grey, palette::vermilion,
                                     palette::blue, gnuplot_said_once);
    }
    figure.script += "unset multiplot\n";
    return figure;
}

StudyFigure filter_figure(const AccuracyResult &result)
{
    StudyFigure figure{"filter",
                       "Filter bandwidth: delay against noise",
                       "Each curve from 200 Hz (left) to 5 Hz (right); dashed: without any filter.",
                       "base,bandwidth_hz,delay_ms,noise_pct\n",
                       "",
                       900,
                       520};
    const std::vector<AccuracyConfig> bases = step_bases(result.scene);
    Range x, y;
    double unfiltered[2] = {0, 0};
    for (const FilterRow &r : result.filter) {
        const std::size_t base = r.config == bases.front() ? 0 : 1;
        y.take(100 * r.noise);
        if (r.hertz > 0)
            x.take(1e3 * r.delay);
        else
            unfiltered[base] = 100 * r.noise;
        figure.csv += fmt::format("{},{:g},{:.6g},{:.6g}\n", base == 0 ? "mcneely" : "deep", r.hertz,
                                  1e3 * r.delay, 100 * r.noise);
    }
    if (x.is_empty() || y.is_empty()) {
        figure.absent =
            "no two poses of the path follow each other in contact, so that there is no force over time "
            "to be filtered.";
        return figure;
    }
    figure.script = "set tmargin 1\nset bmargin 6\nset rmargin 32\n" + x.axis('x') + y.axis('y') +
                    "set xlabel 'delay [ms]'\nset ylabel 'noise [% of the force]'\n"
                    "set key at graph 1.03, graph 1 left top Left reverse samplen 2\nplot ";
    const struct {
        const char *base, *title, *colour;
        int point;
    } curves[] = {{"mcneely", "naive, original, surface", palette::vermilion, 6},
                  {"deep", "exact, original, distance", palette::blue, 5}};
    for (const auto &c : curves) {
        const bool first = &c == curves;
        figure.script +=
            fmt::format("{0}$data using (strcol(1) eq '{1}' && $2 > 0 ? $3 : NaN):4 with linespoints pt {2} "
                        "ps 1.2 lw 2 lc rgb '{3}' "
                        "title '{4}', $data using (strcol(1) eq '{1}' && $2 > 0 ? $3 : NaN):4:(sprintf('%g "
                        "Hz', $2)) with labels "
                        "offset 0, -0.9 font ',12' textcolor rgb '{3}' notitle, {5:g} with lines dt 2 lw 1 "
                        "lc rgb '{3}' notitle",
                        first ? "" : ", ", c.base, c.point, c.colour, c.title, unfiltered[first ? 0 : 1]);
    }
    figure.script += "\n";
    return figure;
}

StudyFigure scale_figure(const AccuracyResult &result, bool points)
{
    StudyFigure figure{
        points ? "time_over_points" : "time_over_size",
        points ? "Time against points: the worst tick beside the mean"
               : "Time against what stands: the worst tick beside the mean",
        points ? "The scene's own law, shells of other spacings."
               : "Copies of what stands, out of reach, and finer cells, over the surface cells of the map.",
        "kind,over,mean_us,p999_us,worst_us\n",
        "",
        900,
        520,
        true};
    Range x, y;
    for (const ScaleRow &r : result.scale) {
        if ((r.kind == "points") != points) continue;
        const double over = points ? r.points : r.cells;
        x.take(over);
        y.take(us * r.mean_ns);
        y.take(us * r.ns.max);
        figure.csv += fmt::format("{},{:g},{:.6g},{:.6g},{:.6g}\n", r.kind, over, us * r.mean_ns,
                                  us * r.ns.p999, us * r.ns.max);
    }
    figure.script = "set tmargin 1\nset bmargin 6\nset rmargin 26\n" + x.axis('x') + y.axis('y') +
                    fmt::format("set xlabel '{}'\nset ylabel 'tick [us]'\n"
                                "set key at graph 1.03, graph 1 left top Left reverse samplen 2\nplot ",
                                points ? "points of the shell" : "surface cells of what stands");
    const struct {
        const char *kind, *title, *colour;
        int point;
    } kinds[] = {{"points", "", palette::blue, 5},
                 {"copies", "copies, ", palette::blue, 5},
                 {"finer", "finer, ", palette::vermilion, 6}};
    bool is_first = true;
    for (const auto &k : kinds) {
        if ((std::string(k.kind) == "points") != points) continue;
        const struct {
            int column;
            const char *title;
            int dash;
        } lines[] = {{5, "worst", 3}, {4, "p99.9", 2}, {3, "mean", 1}};
        for (const auto &line : lines) {
            figure.script += fmt::format(
                "{}$data using (strcol(1) eq '{}' ? $2 : NaN):{} with linespoints pt {} ps 1.1 lw 1.8 "
                "dt {} lc rgb '{}' title '{}{}'",
                is_first ? "" : ", ", k.kind, line.column, k.point, line.dash, k.colour, k.title, line.title);
            is_first = false;
        }
    }
    figure.script += "\n";
    return figure;
}

} // namespace

std::vector<StudyFigure> accuracy_figures(const AccuracyResult &result, const Advice &advice,
                                          const Study &study)
{
    const Cost costs[] = {
        {"error_over_time", "Error against tick time: all configurations",
         "A dot a configuration: colour is the law, shape the field; naive and exact shells, all voxel "
         "edges, all "
         "weightings. Down and to the left is better.",
         "tick p99.9 [us]", true, true, [](const AccuracyRow &r) { return us * r.tick.p999; }},
        {"error_over_bytes", "Error against asset bytes: what is to be kept on the lab's machine",
         "Map and shell together. Of each law the best of its weightings; laws cost the same and stand side "
         "by "
         "side.",
         "assets [KiB]", false, false, [](const AccuracyRow &r) { return r.asset_bytes / 1024; }},
        {"error_over_conversion", "Error against conversion time: what is to be waited for once",
         "Both assets, on this machine's threads. Of each law the best of its weightings; laws cost the same "
         "and "
         "stand side by side.",
         "conversion [s]", true, false, [](const AccuracyRow &r) { return r.conversion; }}};
    std::vector<StudyFigure> figures;
    for (const Cost &cost : costs) figures.push_back(pareto(result, advice, cost));
    figures.push_back(over_voxel(result));
    figures.push_back(steps_figure(result, study));
    figures.push_back(filter_figure(result));
    figures.push_back(scale_figure(result, true));
    figures.push_back(scale_figure(result, false));
    return figures;
}

} // namespace voxshell
