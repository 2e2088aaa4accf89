// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/paper_study.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

namespace voxshell {
namespace {

using Row = std::vector<std::variant<std::string, double>>;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// A figure of a run: how the CSV names it, how the page, and where it comes from.
template<class Run>
struct Figure {
    const char *name, *label; ///< no label: in the CSV alone
    std::function<double(const Run &)> value;
    bool spread = false; ///< with its standard deviation over the seeds
};

double percent(double share)
{
    return 100 * share;
}

const std::vector<Figure<PathRun>> &path_figures()
{
    static const std::vector<Figure<PathRun>> all{
        {"normal_ke", "normal force [k e]", [](const PathRun &r) { return r.metrics.normal; }},
        {"ripple_pct", "its ripple [%]", [](const PathRun &r) { return percent(r.metrics.ripple); }, true},
        {"across_rms_pct", "tangential rms [%]",
         [](const PathRun &r) { return percent(r.metrics.across_rms); }, true},
        {"across_peak_pct", "tangential peak [%]",
         [](const PathRun &r) { return percent(r.metrics.across_peak); }, true},
        {"across_bias_pct", "bias [%]", [](const PathRun &r) { return percent(r.metrics.across_bias); }},
        {"across_noise_pct", "noise [%]", [](const PathRun &r) { return percent(r.metrics.across_noise); }},
        {"angle_mean_deg", "", [](const PathRun &r) { return r.metrics.angle_mean; }},
        {"angle_p95_deg", "direction p95 [deg]", [](const PathRun &r) { return r.metrics.angle_p95; }},
        {"angle_max_deg", "direction max [deg]", [](const PathRun &r) { return r.metrics.angle_max; }},
        {"torque_error_pct", "torque error [%]",
         [](const PathRun &r) { return percent(r.metrics.torque_error); }},
        {"size_ke", "force size [k e]", [](const PathRun &r) { return r.metrics.size; }},
        {"torque_ke", "torque / radius [k e]", [](const PathRun &r) { return r.metrics.torque_size; }},
        {"wrench_error_pct", "wrench error [%]",
         [](const PathRun &r) { return percent(r.metrics.wrench_error); }, true},
        {"magnitude_error_pct", "", [](const PathRun &r) { return percent(r.metrics.magnitude_error); },
         true},
        {"points_min", "", [](const PathRun &r) { return r.metrics.points_min; }},
        {"points_mean", "points", [](const PathRun &r) { return r.metrics.points_mean; }},
        {"points_max", "", [](const PathRun &r) { return r.metrics.points_max; }},
        {"jump_pct", "largest jump [%]", [](const PathRun &r) { return percent(r.metrics.jump); }},
        {"above_10hz_pct", "", [](const PathRun &r) { return percent(r.metrics.above_10); }},
        {"above_30hz_pct", "power above 30 Hz [%]",
         [](const PathRun &r) { return percent(r.metrics.above_30); }},
        {"above_100hz_pct", "", [](const PathRun &r) { return percent(r.metrics.above_100); }},
        {"swing_above_10hz_pct", "", [](const PathRun &r) { return percent(r.metrics.swing_above_10); }},
        {"crossing_hz", "", [](const PathRun &r) { return r.crossing_hz; }},
        {"at_crossing_pct", "at v/e [%]", [](const PathRun &r) { return percent(r.metrics.at_crossing); }},
        {"touching_pct", "", [](const PathRun &r) { return percent(r.metrics.touching); }},
        {"deep_pct", "ticks with deep points [%]", [](const PathRun &r) { return percent(r.metrics.deep); }},
        {"cancelled_pct", "", [](const PathRun &r) { return percent(r.metrics.cancelled); }}};
    return all;
}

const std::vector<Figure<LoopRun>> &loop_figures()
{
    static const std::vector<Figure<LoopRun>> all{
        {"contact_n_per_m", "contact [N/m]", [](const LoopRun &r) { return r.contact_stiffness; }},
        {"bound_n_per_m", "bounded to [N/m]", [](const LoopRun &r) { return r.bound; }},
        {"carried_n_per_m", "loop carries [N/m]", [](const LoopRun &r) { return r.largest_stiffness; }},
        {"collision_peak_n", "", [](const LoopRun &r) { return r.collision_peak; }},
        {"output_peak_n", "output peak [N]", [](const LoopRun &r) { return r.output_peak; }},
        {"steady_n", "at the end [N]", [](const LoopRun &r) { return r.response.steady; }},
        {"rise_ms", "rise [ms]", [](const LoopRun &r) { return 1e3 * r.response.rise; }},
        {"overshoot_pct", "overshoot [%]", [](const LoopRun &r) { return percent(r.response.overshoot); }},
        {"settling_ms", "settling [ms]", [](const LoopRun &r) { return 1e3 * r.response.settling; }},
        {"lag_ms", "lag [ms]", [](const LoopRun &r) { return 1e3 * r.response.lag; }},
        {"oscillation_n", "swing at the end [N]", [](const LoopRun &r) { return r.response.oscillation; },
         true},
        {"felt_ripple_pct", "felt ripple [%]", [](const LoopRun &r) { return percent(r.felt.ripple); }},
        {"felt_across_rms_pct", "", [](const LoopRun &r) { return percent(r.felt.across_rms); }},
        {"felt_above_10hz_pct", "", [](const LoopRun &r) { return percent(r.felt.above_10); }},
        {"felt_above_30hz_pct", "", [](const LoopRun &r) { return percent(r.felt.above_30); }},
        {"felt_above_100hz_pct", "", [](const LoopRun &r) { return percent(r.felt.above_100); }},
        {"felt_swing_above_10hz_pct", "swing above 10 Hz [%]",
         [](const LoopRun &r) { return percent(r.felt.swing_above_10); }},
        {"felt_jump_pct", "", [](const LoopRun &r) { return percent(r.felt.jump); }},
        {"deepest_mm", "deepest [mm]", [](const LoopRun &r) { return 1e3 * r.deepest; }},
        {"through_pct", "through the wall [% of seeds]",
         [](const LoopRun &r) { return std::isfinite(r.deepest) ? (r.through ? 100.0 : 0.0) : nothing; }},
        {"energy_mj", "least energy [mJ]", [](const LoopRun &r) { return 1e3 * r.energy; }},
        {"saturated_s", "saturated [s]", [](const LoopRun &r) { return r.saturated; }},
        {"deep_pct", "", [](const LoopRun &r) { return percent(r.flagged_deep); }}};
    return all;
}

std::vector<StudyColumn> key_columns(bool loop)
{
    std::vector<StudyColumn> columns{
        {"scenario", "scenario"}, {"shell", "shell"}, {"law", "law"}, {"field", "field"}, {"weighting", ""}};
    if (loop) columns.insert(columns.end(), {{"coupling", "coupling"}, {"speed_mm_per_s", "speed [mm/s]"}});
    columns.push_back({"level", loop ? "" : "level"});
    return columns;
}

Row key_row(const RunKey &key, bool loop)
{
    const Method &m = key.how().method;
    Row row{std::string(key.scenario->id), shell_name(m.shell), law_name(m.law), field_name(m.field),
            weighting_name(m.weighting)};
    if (loop) {
        row.emplace_back(coupled_text(key.how().coupled));
        row.emplace_back(key.scenario->speeds.empty() ? nothing : 1e3 * key.speed_value());
    }
    row.emplace_back(key.level_value());
    return row;
}

bool is_scored(const PathRun &run)
{
    return !run.degenerate;
}

bool is_scored(const LoopRun &)
{
    return true;
}

/// All runs one by one.
template<class Run>
StudyTable each(const std::string &id, const std::vector<Run> &runs, const std::vector<Figure<Run>> &figures,
                bool loop)
{
    StudyTable table{id, "", "", key_columns(loop), {}, ""};
    table.columns.push_back({"seed", ""});
    table.columns.push_back({"degenerate", ""});
    for (const auto &figure : figures) table.columns.push_back({figure.name, ""});
    for (const Run &run : runs) {
        Row row = key_row(run.key, loop);
        row.emplace_back(static_cast<double>(run.key.seed));
        row.emplace_back(is_scored(run) ? 0.0 : 1.0);
        for (const auto &figure : figures) row.emplace_back(figure.value(run));
        table.rows.push_back(std::move(row));
    }
    return table;
}

/// Means over the seeds; runs that differ by the seed alone stand together.
template<class Run>
StudyTable means(const std::string &group, const std::vector<Run> &runs,
                 const std::vector<Figure<Run>> &figures, bool loop)
{
    StudyTable table{group + "_means", "", "", key_columns(loop), {}, group};
    table.columns.push_back({"seeds", "seeds"});
    table.columns.push_back({"degenerate", loop ? "" : "degenerate"});
    for (const auto &figure : figures) {
        table.columns.push_back({figure.name, figure.label});
        if (figure.spread)
            table.columns.push_back({std::string(figure.name) + "_deviation", figure.label[0] ? "+-" : ""});
    }
    for (std::size_t first = 0; first < runs.size();) {
        const RunKey &key = runs[first].key;
        std::size_t end = first;
        std::vector<const Run *> scored;
        for (; end < runs.size() && runs[end].key.scenario == key.scenario &&
               runs[end].key.variant == key.variant && runs[end].key.level == key.level &&
               runs[end].key.speed == key.speed;
             ++end) {
            if (is_scored(runs[end])) scored.push_back(&runs[end]);
        }
        if (group == key.scenario->group) {
            Row row = key_row(key, loop);
            row.emplace_back(static_cast<double>(end - first));
            row.emplace_back(static_cast<double>(end - first - scored.size()));
            for (const auto &figure : figures) {
                std::vector<double> values;
                for (const Run *run : scored) values.push_back(figure.value(*run));
                const MeanAndSpread m = mean_and_spread(values);
                row.emplace_back(m.mean);
                if (figure.spread) row.emplace_back(m.deviation);
            }
            table.rows.push_back(std::move(row));
        }
        first = end;
    }
    return table;
}

std::string &label(StudyTable &table, const std::string &name)
{
    for (StudyColumn &column : table.columns) {
        if (column.name == name) return column.label;
    }
    throw Failure(ExitCode::bug, table.id, "no column " + name);
}

/// Shares of a normal force, where there is one; sizes and the error against the ideal, where forces cancel.
void show_fitting(StudyTable &table)
{
    const bool is_fit = table.id == "wedge_means" || table.id == "peg_means",
               is_peg = table.id == "peg_means";
    for (const char *name :
         {"normal_ke", "ripple_pct", "ripple_pct_deviation", "across_rms_pct", "across_rms_pct_deviation",
          "across_peak_pct", "across_peak_pct_deviation", "across_bias_pct", "across_noise_pct", "jump_pct",
          "above_30hz_pct", "at_crossing_pct"}) {
        if (is_fit) label(table, name).clear();
    }
    for (const char *name : {"size_ke", "torque_ke", "wrench_error_pct", "wrench_error_pct_deviation"}) {
        if (!is_fit) label(table, name).clear();
    }
    if (is_peg)
        label(table, "angle_p95_deg").clear(), label(table, "angle_max_deg").clear(),
            label(table, "cancelled_pct") = "mean cancelled [% of ticks]";
    if (table.id == "control_means") label(table, "weighting") = "weighting";
}

/// One law or shell over another, seed by seed: the same shell on the same path.
StudyTable ratios(const PaperRuns &runs)
{
    StudyTable table{"ratios",
                     "One over the other, seed by seed",
                     "Each seed turns the shell and places the path anew, the same for both. Mean, standard "
                     "deviation and extremes over the seeds that are scored.",
                     {{"pair", "pair"},
                      {"level", "depth [e]"},
                      {"seeds", "seeds"},
                      {"peak", "tangential peak, ratio"},
                      {"peak_deviation", "+-"},
                      {"peak_least", "least"},
                      {"peak_most", "most"},
                      {"rms", "rms, ratio"},
                      {"rms_deviation", "+-"},
                      {"noise", "noise, ratio"},
                      {"ripple", "ripple of the normal force, ratio"},
                      {"ripple_deviation", "+-"}},
                     {},
                     "average_over_original"};
    struct Side {
        std::string id;
        Method method;
    };
    const auto paper = [](ShellKind shell, std::uint32_t law) {
        return Method{shell, law, VXS_CONTACT_SURFACE, VXS_CONTACT_COUNT};
    };
    constexpr auto exact = ShellKind::exact, naive = ShellKind::naive;
    const Method original = paper(exact, VXS_CONTACT_ORIGINAL), average = paper(exact, VXS_CONTACT_AVERAGE);
    const struct {
        const char *name;
        Side over, under;
    } pairs[] = {{"fig8b / fig8a", {"fig8b", average}, {"fig8a", original}},
                 {"fig8d / fig8c", {"fig8d", average}, {"fig8c", original}},
                 {"fig9b / fig9a", {"fig9b", average}, {"fig9a", original}},
                 {"exact / naive, tilted plane, original",
                  {"control8", original},
                  {"control8", paper(naive, VXS_CONTACT_ORIGINAL)}},
                 {"exact / naive, tilted plane, average",
                  {"control8", average},
                  {"control8", paper(naive, VXS_CONTACT_AVERAGE)}},
                 {"exact / naive, cylinder, original",
                  {"control9", original},
                  {"control9", paper(naive, VXS_CONTACT_ORIGINAL)}},
                 {"exact / naive, turned cylinder, original",
                  {"control9-turned", original},
                  {"control9-turned", paper(naive, VXS_CONTACT_ORIGINAL)}},
                 {"exact / naive, turned cylinder, average",
                  {"control9-turned", average},
                  {"control9-turned", paper(naive, VXS_CONTACT_AVERAGE)}},
                 {"exact / naive, cylinder, average",
                  {"control9", average},
                  {"control9", paper(naive, VXS_CONTACT_AVERAGE)}}};
    const auto find = [&](const Side &side, double level, unsigned seed) -> const PathRun * {
        for (const PathRun &run : runs.paths) {
            const Method &m = run.key.how().method;
            if (side.id == run.key.scenario->id && run.key.level_value() == level && run.key.seed == seed &&
                m.shell == side.method.shell && m.law == side.method.law && m.field == side.method.field &&
                m.weighting == side.method.weighting) {
                return &run;
            }
        }
        return nullptr;
    };
    for (const auto &pair : pairs) {
        for (const double level : {0.25, 0.5, 1.0}) {
            std::vector<double> peak, rms, noise, ripple;
            for (unsigned seed = 1;; ++seed) {
                const PathRun *over = find(pair.over, level, seed), *under = find(pair.under, level, seed);
                if (!over || !under) break;
                if (!is_scored(*over) || !is_scored(*under)) continue;
                peak.push_back(over->metrics.across_peak / under->metrics.across_peak);
                rms.push_back(over->metrics.across_rms / under->metrics.across_rms);
                noise.push_back(over->metrics.across_noise / under->metrics.across_noise);
                ripple.push_back(over->metrics.ripple / under->metrics.ripple);
            }
            if (peak.empty()) continue;
            const MeanAndSpread p = mean_and_spread(peak), r = mean_and_spread(rms),
                                n = mean_and_spread(noise), w = mean_and_spread(ripple);
            table.rows.push_back({std::string(pair.name), level, static_cast<double>(p.count), p.mean,
                                  p.deviation, p.least, p.most, r.mean, r.deviation, n.mean, w.mean,
                                  w.deviation});
        }
    }
    return table;
}

/// Force against the one that is known, as Sagardia and Hulin, and Weller and others, compare methods.
StudyTable quality(const std::vector<StudyTable> &tables)
{
    StudyTable table{
        "quality",
        "Force against the known one, means over the seeds",
        "Known: along the normal at constant size (plane and cylinder), an elastic foundation "
        "(wedge, peg); one factor for all ticks of a run makes it as large as what was measured. "
        "Size: rms of the force's size off the known one; wrench: force and torque / radius. Forces on the "
        "peg cancel: of it the wrench alone says something.",
        {{"benchmark", "benchmark"},
         {"shell", "shell"},
         {"law", "law"},
         {"field", "field"},
         {"angle_mean_deg", "direction, mean [deg]"},
         {"angle_p95_deg", "p95 [deg]"},
         {"angle_max_deg", "max [deg]"},
         {"magnitude_error_pct", "size [%]"},
         {"magnitude_error_pct_deviation", "+-"},
         {"wrench_error_pct", "wrench [%]"},
         {"above_30hz_pct", "power above 30 Hz [%]"},
         {"above_100hz_pct", "above 100 Hz [%]"}},
        {},
        "spectrum"};
    const struct {
        const char *group, *scenario, *name;
        double level;
    } benchmarks[] = {{"control", "control8", "fig8, turned plane, 0.5 e deep", 0.5},
                      {"control", "control9", "fig9, cylinder, 0.5 e deep", 0.5},
                      {"wedge", "wedge", "wedge, pressed aslant", 0.5},
                      {"peg", "peg", "peg of 20.2 mm", 20.2}};
    for (const auto &b : benchmarks) {
        const auto found = std::ranges::find(tables, std::string(b.group) + "_means", &StudyTable::id);
        for (std::size_t n = 0; n < found->rows.size(); ++n) {
            if (found->word(n, "scenario") != b.scenario || found->number(n, "level") != b.level ||
                found->word(n, "weighting") != "count")
                continue;
            Row row{std::string(b.name), found->word(n, "shell"), found->word(n, "law"),
                    found->word(n, "field")};
            for (std::size_t column = row.size(); column < table.columns.size(); ++column) {
                const std::string &name = table.columns[column].name;
                const bool says = b.group != std::string("peg") || name == "wrench_error_pct";
                row.emplace_back(says ? found->number(n, name) : nothing);
            }
            table.rows.push_back(std::move(row));
        }
    }
    return table;
}

} // namespace

std::vector<StudyTable> paper_tables(const PaperRuns &runs)
{
    std::vector<StudyTable> tables{each("runs", runs.paths, path_figures(), false),
                                   each("loop_runs", runs.loops, loop_figures(), true), ratios(runs)};
    const struct {
        const char *group, *title, *note;
    } paths[] = {
        {"fig8", "Figure 8, means over the seeds",
         "Level: depth in e. The plane of a and b is along the grid; where it lies in its cells is drawn by "
         "seed, so that its normal force differs from seed to seed."},
        {"fig9", "Figure 9, means over the seeds", "Level: depth in e."},
        {"degenerate", "Degenerate control, not scored",
         "Plane at mid-cell height, shell and plane along the grid: what pushes aside on the left does so on "
         "the right, and all points meet a border at once. Recognised by the pose; no number of it counts."},
        {"control", "All methods, means over the seeds",
         "Level: depth in e. control8: the tilted plane of figure 8 c and d; control9: the cylinder of "
         "figure 9."},
        {"wedge", "V groove of 60 degrees, means over the seeds",
         "Level: depth at the other wall as a share of that at the one. Ideal: an elastic foundation on both "
         "walls; wrench error by the best factor."},
        {"peg", "Peg in hole, means over the seeds",
         "Level: the peg's diameter in mm; the hole has 20 mm. Shares of the normal force say nothing here: "
         "forces cancel. Ideal: an elastic foundation on the peg's side; wrench error by the best factor, "
         "where there is one."}};
    for (const auto &group : paths) {
        StudyTable table = means(group.group, runs.paths, path_figures(), false);
        table.title = group.title;
        table.note = group.note;
        if (group.group == std::string("degenerate")) table.figure = "fig8";
        show_fitting(table);
        tables.push_back(std::move(table));
    }
    tables.push_back(quality(tables));
    tables.push_back(point_table(runs.points));
    const struct {
        const char *group, *title, *note;
    } loops[] = {
        {"fig11", "Figure 11, means over the seeds",
         "Pose prescribed: no device in the loop. Lag: of the output behind the contact at the device, both "
         "along the normal. Automatic: what the design of kind and numbers picks for the stiffness on this "
         "path, held by a hand."},
        {"fig12", "Figure 12, means over the seeds",
         "Loop carries: the stiffness below which device, hand and filter stay calm, friction counted. "
         "Contact: the stiffest on the way. Energy: least taken from the hand; below 0 the loop gave some."},
        {"wall", "Walls, means over the seeds",
         "Level: thickness in e. Through: the object's deepest point came out behind."}};
    for (const auto &group : loops) {
        StudyTable table = means(group.group, runs.loops, loop_figures(), true);
        table.title = group.title;
        table.note = group.note;
        if (group.group == std::string("wall")) label(table, "level") = "thickness [e]";
        for (const char *name : {"shell", "weighting"}) label(table, name).clear();
        tables.push_back(std::move(table));
    }
    return tables;
}

std::vector<StudyTable> paper_timings(const PaperRuns &runs)
{
    StudyTable table{"timing", "", "", key_columns(true), {}, ""};
    for (const char *name :
         {"seed", "tick_p50_us", "tick_p99_us", "tick_p999_us", "tick_max_us", "period_us"})
        table.columns.push_back({name, ""});
    for (const LoopRun &run : runs.loops) {
        if (!is_loop(*run.key.scenario)) continue;
        Row row = key_row(run.key, true);
        for (const double value : {static_cast<double>(run.key.seed), run.tick.p50 / 1e3, run.tick.p99 / 1e3,
                                   run.tick.p999 / 1e3, run.tick.max / 1e3, 1e6 / study_rate})
            row.emplace_back(value);
        table.rows.push_back(std::move(row));
    }
    return {table};
}

} // namespace voxshell
