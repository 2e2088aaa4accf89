// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/accuracy_study.hpp"

#include "cli/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace voxshell {
namespace {

using Row = std::vector<std::variant<std::string, double>>;

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double us = 1e-3, kib = 1024, mib = 1024 * 1024; ///< of [ns], bytes

/// How the CSV names a number, how the page, whether it is a time, and where it comes from.
struct Shown {
    const char *name, *label;
    bool timed;
    std::function<double(const AccuracyRow &)> value;
};

const std::vector<Shown> &shown()
{
    static const std::vector<Shown> all{
        {"error_pct", "error [%]", false, [](const AccuracyRow &r) { return 100 * r.error; }},
        {"force_error_pct", "force [%]", false, [](const AccuracyRow &r) { return 100 * r.force; }},
        {"size_error_pct", "", false, [](const AccuracyRow &r) { return 100 * r.size; }},
        {"direction_mean_deg", "", false, [](const AccuracyRow &r) { return r.angle_mean; }},
        {"direction_p95_deg", "direction p95 [deg]", false, [](const AccuracyRow &r) { return r.angle_p95; }},
        {"torque_error_pct", "torque [%]", false, [](const AccuracyRow &r) { return 100 * r.torque; }},
        {"no_force_pct", "no force [% of poses]", false,
         [](const AccuracyRow &r) { return 100 * r.missing; }},
        {"deep_pct", "too deep [% of poses]", false, [](const AccuracyRow &r) { return 100 * r.deep; }},
        {"stiffness", "", false, [](const AccuracyRow &r) { return r.stiffness; }},
        {"reach_cells", "", false, [](const AccuracyRow &r) { return r.reach; }},
        {"shell_points", "points", false, [](const AccuracyRow &r) { return r.points; }},
        {"colliding", "", false, [](const AccuracyRow &r) { return r.hits; }},
        {"touched", "looked at", false, [](const AccuracyRow &r) { return r.probed; }},
        {"touched_most", "", false, [](const AccuracyRow &r) { return r.probed_most; }},
        {"asset_kib", "assets [KiB]", false, [](const AccuracyRow &r) { return r.asset_bytes / kib; }},
        {"memory_kib", "memory [KiB]", false, [](const AccuracyRow &r) { return r.runtime_bytes / kib; }},
        {"tick_mean_us", "", true, [](const AccuracyRow &r) { return us * r.mean_ns; }},
        {"tick_p50_us", "tick p50 [us]", true, [](const AccuracyRow &r) { return us * r.tick.p50; }},
        {"tick_p99_us", "p99 [us]", true, [](const AccuracyRow &r) { return us * r.tick.p99; }},
        {"tick_p999_us", "p99.9 [us]", true, [](const AccuracyRow &r) { return us * r.tick.p999; }},
        {"tick_worst_us", "worst [us]", true, [](const AccuracyRow &r) { return us * r.tick.max; }},
        {"tick_max_us", "max [us]", true, [](const AccuracyRow &r) { return us * r.most_ns; }},
        {"conversion_s", "conversion [s]", true, [](const AccuracyRow &r) { return r.conversion; }},
        {"conversion_peak_mib", "its peak [MiB]", true,
         [](const AccuracyRow &r) { return r.conversion_bytes / mib; }}};
    return all;
}

StudyTable accuracy_table(const AccuracyResult &result)
{
    StudyTable table{
        "accuracy",
        "All configurations",
        "Points looked at, and times, are of a tick in contact. Times: each tick the least of three passes, "
        "worst the largest of them; max is of any pass, and has the system's interruptions. Memory: assets "
        "and contact. "
        "Conversion: both assets, and its peak on top of what was there.",
        {{"configuration", ""},
         {"voxel_mm", "voxel [mm]"},
         {"shell", "shell"},
         {"law", "law"},
         {"field", "field"},
         {"weighting", "weighting"}},
        {},
        "error_over_time"};
    for (const Shown &s : shown()) table.columns.push_back({s.name, s.label, s.timed});
    for (const AccuracyRow &r : result.rows) {
        const Method &m = r.config.method;
        Row row{r.config.text(), 1e3 * r.config.voxel, shell_name(m.shell),
                law_name(m.law), field_name(m.field),  weighting_name(m.weighting)};
        for (const Shown &s : shown()) row.emplace_back(s.value(r));
        table.rows.push_back(std::move(row));
    }
    return table;
}

StudyTable reference_table(const AccuracyResult &result)
{
    StudyTable table{
        "reference",
        "The reference, checked",
        "Halved: what the last halving of its pieces changed. Formula: the mesh's distance against a "
        "formula, where there is one; both rms over the poses, of the force. A scene of files has no "
        "formula: its meshes have facets.",
        {{"scene", "scene"},
         {"poses", "poses"},
         {"deepest_mm", "deepest [mm]"},
         {"pieces_mm", "edge of a piece [mm]"},
         {"halved_pct", "halved [%]"},
         {"formula_pct", "formula [%]"}},
        {},
        "error_over_voxel"};
    for (const ReferenceRow &r : result.references)
        table.rows.push_back(
            {r.scene, r.poses, 1e3 * r.deepest, 1e3 * r.spacing, 100 * r.halving, 100 * r.apart});
    return table;
}

const AccuracyRow *find(const AccuracyResult &result, const AccuracyConfig &config)
{
    for (const AccuracyRow &row : result.rows) {
        if (row.config == config) return &row;
    }
    return nullptr;
}

/// One thing changed: from `from` to what `to` makes of it, where that is another valid configuration.
struct Step {
    const char *id, *text;
    std::function<bool(AccuracyConfig &)> change; ///< false: this one is not a start of it
};

std::vector<Step> steps()
{
    const auto law = [](std::uint32_t from, std::uint32_t to) {
        return [=](AccuracyConfig &c) { return c.method.law == from && (c.method.law = to, true); };
    };
    const auto field = [](std::uint32_t from, std::uint32_t to) {
        return [=](AccuracyConfig &c) { return c.method.field == from && (c.method.field = to, true); };
    };
    return {{"exact", "exact points, not cells' centres",
             [](AccuracyConfig &c) {
                 return c.method.shell == ShellKind::naive && (c.method.shell = ShellKind::exact, true);
             }},
            {"average", "averaged normals, not each its own", law(VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE)},
            {"patch", "normals of a patch, not each its own", law(VXS_CONTACT_ORIGINAL, VXS_CONTACT_PATCH)},
            {"gradient", "the field's gradient, not each its own",
             law(VXS_CONTACT_ORIGINAL, VXS_CONTACT_GRADIENT)},
            {"layers", "deeper field: layers, not surface", field(VXS_CONTACT_SURFACE, VXS_CONTACT_LAYERS)},
            {"distance", "trilinear distance, not surface", field(VXS_CONTACT_SURFACE, VXS_CONTACT_DISTANCE)},
            {"trilinear", "trilinear distance, not layers", field(VXS_CONTACT_LAYERS, VXS_CONTACT_DISTANCE)},
            {"area", "weighting by area, not count",
             [](AccuracyConfig &c) {
                 return c.method.weighting == VXS_CONTACT_COUNT &&
                        (c.method.weighting = VXS_CONTACT_AREA, true);
             }},
            {"finer", "voxels of half the edge", [](AccuracyConfig &c) {
                 c.voxel /= 2;
                 return true;
             }}};
}

StudyTable steps_table(const AccuracyResult &result)
{
    StudyTable table{"steps",
                     "What each step costs and buys, one at a time",
                     "From a base to the same with one thing changed.",
                     {{"step", "step"},
                      {"from", "from"},
                      {"error_from_pct", "error from [%]"},
                      {"error_to_pct", "to [%]"},
                      {"error_change_pct", "change [% points]"},
                      {"direction_from_deg", "direction p95 from [deg]"},
                      {"direction_to_deg", "to [deg]"},
                      {"asset_from_kib", "assets from [KiB]"},
                      {"asset_to_kib", "to [KiB]"},
                      {"tick_p50_from_us", "tick p50 from [us]", true},
                      {"tick_p50_to_us", "to [us]", true},
                      {"tick_p999_from_us", "p99.9 from [us]", true},
                      {"tick_p999_to_us", "to [us]", true},
                      {"conversion_from_s", "conversion from [s]", true},
                      {"conversion_to_s", "to [s]", true}},
                     {},
                     "steps"};
    for (const AccuracyConfig &base : step_bases(result.scene)) {
        const AccuracyRow *from = find(result, base);
        if (!from) continue;
        for (const Step &step : steps()) {
            AccuracyConfig changed = base;
            const AccuracyRow *to = step.change(changed) ? find(result, changed) : nullptr;
            if (!to) continue;
            table.rows.push_back({std::string(step.text), base.text(), 100 * from->error, 100 * to->error,
                                  100 * (to->error - from->error), from->angle_p95, to->angle_p95,
                                  from->asset_bytes / kib, to->asset_bytes / kib, us * from->tick.p50,
                                  us * to->tick.p50, us * from->tick.p999, us * to->tick.p999,
                                  from->conversion, to->conversion});
        }
    }
    return table;
}

/// Each step over all configurations that it can start from.
StudyTable pairs_table(const AccuracyResult &result)
{
    StudyTable table{
        "pairs",
        "Each step over all configurations",
        "Pairs of configurations that differ by this alone. Ratios are geometric means, with over "
        "without; below 1: less.",
        {{"step", "step"},
         {"id", ""},
         {"pairs", "pairs"},
         {"less_error_pct", "less error in [%]"},
         {"error_ratio", "error ratio"},
         {"error_ratio_least", "least"},
         {"error_ratio_most", "most"},
         {"direction_ratio", "direction ratio"},
         {"bytes_ratio", "bytes ratio"},
         {"time_ratio", "tick p50 ratio", true},
         {"conversion_ratio", "conversion ratio", true}},
        {},
        "steps"};
    for (const Step &step : steps()) {
        double pairs = 0, less = 0, error = 0, bytes = 0, time = 0, conversion = 0, direction = 0,
               directed = 0;
        double least = std::numeric_limits<double>::infinity(), most = 0;
        for (const AccuracyRow &from : result.rows) {
            AccuracyConfig changed = from.config;
            const AccuracyRow *to = step.change(changed) ? find(result, changed) : nullptr;
            if (!to) continue;
            ++pairs;
            const double ratio = to->error / from.error;
            less += ratio < 1;
            least = std::min(least, ratio);
            most = std::max(most, ratio);
            error += std::log(ratio);
            if (to->angle_p95 > 0 && from.angle_p95 > 0) {
                direction += std::log(to->angle_p95 / from.angle_p95);
                ++directed;
            }
            bytes += std::log(to->asset_bytes / from.asset_bytes);
            time += std::log(to->tick.p50 / from.tick.p50);
            conversion += std::log(to->conversion / from.conversion);
        }
        if (pairs == 0) continue;
        table.rows.push_back({std::string(step.text), std::string(step.id), pairs, 100 * less / pairs,
                              std::exp(error / pairs), least, most,
                              directed > 0 ? std::exp(direction / directed) : nothing,
                              std::exp(bytes / pairs), std::exp(time / pairs), std::exp(conversion / pairs)});
    }
    return table;
}

StudyTable culling_table(const AccuracyResult &result)
{
    StudyTable table{
        "culling",
        "Culling: no error at all",
        "The same poses with every point in plain C, with vectors, and with points passed over; other "
        "bits: wrenches that are not plain C's to the last bit.",
        {{"configuration", "configuration"},
         {"mode", "mode"},
         {"poses", "poses"},
         {"other_bits", "other bits"},
         {"looked_at", "points looked at"},
         {"p50_us", "p50 [us]", true},
         {"p99_us", "p99 [us]", true},
         {"p999_us", "p99.9 [us]", true},
         {"max_us", "max [us]", true}},
        {},
        "steps"};
    for (const CullingRow &r : result.culling)
        table.rows.push_back({r.config, r.mode, r.poses, r.differing, r.probed, us * r.ns.p50, us * r.ns.p99,
                              us * r.ns.p999, us * r.ns.max});
    return table;
}

StudyTable rounding_table(const AccuracyResult &result)
{
    StudyTable table{
        "rounding",
        "Floats against doubles",
        "Points are stored in floats, and their cells are looked up in floats; forces are computed in "
        "doubles. "
        "Here against the same law in doubles throughout, with points before rounding: a naive shell's are "
        "its "
        "cells' centres, an exact shell's the nearest of the mesh. Poses moved: by 0.29 cells along each "
        "axis. In "
        "planes: points within 1e-5 cells of a plane between two cells, which rounding may put into either. "
        "Cancelled: the sum of all points' forces, each without its direction, over the force that is left "
        "of "
        "them.",
        {{"configuration", "configuration"},
         {"poses", "poses"},
         {"rms_ppm", "rms [ppm of the force]"},
         {"worst_ppm", "worst pose [ppm]"},
         {"other_cell_ppm", "points in contact or not by rounding [ppm]"},
         {"in_planes_pct", "points in planes [%]"},
         {"cancelled", "cancelled"},
         {"moved_nm", "a point by rounding at most [nm]"}},
        {},
        "steps"};
    for (const RoundingRow &r : result.rounding)
        table.rows.push_back({r.config, r.poses, 1e6 * r.wrench, 1e6 * r.worst, 1e6 * r.other_cells,
                              100 * r.in_planes, r.cancelled, 1e9 * r.moved});
    return table;
}

StudyTable filter_table(const AccuracyResult &result)
{
    StudyTable table{
        "filter_bandwidth",
        "Filter bandwidth: delay against noise",
        "The force along the longest stretch of contact, there and back for 2 s at the hand's mean "
        "speed, through the pt2 filter (damping 1). Noise: rms of the filtered error without its mean, of "
        "the "
        "force that ought to be. Delay: of that force through the filter, the shift that fits best; beside "
        "it 2 d / w0. 0 Hz: no filter. Empty where the hand rests, or leaves the contact, between all poses.",
        {{"configuration", "configuration"},
         {"bandwidth_hz", "bandwidth [Hz]"},
         {"delay_ms", "delay [ms]"},
         {"delay_ideal_ms", "2 d / w0 [ms]"},
         {"noise_pct", "noise [%]"}},
        {},
        "filter"};
    for (const FilterRow &r : result.filter)
        table.rows.push_back({r.config.text(), r.hertz, 1e3 * r.delay, 1e3 * r.delay_ideal, 100 * r.noise});
    return table;
}

StudyTable scale_table(const AccuracyResult &result, bool points)
{
    StudyTable table{
        points ? "points" : "static_size",
        points ? "Time against points" : "Time against what stands",
        points ? "The scene's own law, its shell with other spacings (--shell-spacing), its map as it is."
               : "The scene's own law and shell. Copies: as many of what stands, whole cells apart, out of "
                 "reach; finer: its cells smaller, for so many times the surface cells.",
        {},
        {},
        points ? "time_over_points" : "time_over_size"};
    table.columns = {{"row", ""},
                     {"kind", points ? "" : "kind"},
                     {points ? "asked" : "factor", points ? "points asked for" : "factor"},
                     {"shell_points", points ? "points" : ""},
                     {"surface_cells", points ? "" : "surface cells"},
                     {"map_kib", points ? "" : "map [KiB]"},
                     {"shell_kib", points ? "shell [KiB]" : ""},
                     {"colliding", "colliding"},
                     {"touched", "looked at"},
                     {"error_pct", "error [%]"},
                     {"other_force", points ? "" : "poses with another force"},
                     {"tick_mean_us", "tick mean [us]", true},
                     {"tick_p50_us", "p50 [us]", true},
                     {"tick_p99_us", "p99 [us]", true},
                     {"tick_p999_us", "p99.9 [us]", true},
                     {"tick_worst_us", "worst [us]", true},
                     {"tick_max_us", "max [us]", true}};
    for (const ScaleRow &r : result.scale) {
        if ((r.kind == "points") != points) continue;
        table.rows.push_back({fmt::format("{} {:g}", r.kind, r.factor), r.kind, r.factor, r.points, r.cells,
                              r.map_bytes / kib, r.shell_bytes / kib, r.hits, r.probed, 100 * r.error,
                              r.kind == "copies" ? r.differing : nothing, us * r.mean_ns, us * r.ns.p50,
                              us * r.ns.p99, us * r.ns.p999, us * r.ns.max, us * r.most_ns});
    }
    return table;
}

/// What nothing beats in error and time: from run to run not quite the same.
StudyTable front_table(const AccuracyResult &result)
{
    StudyTable table{
        "front",
        "What nothing beats in both, error and time",
        "From the fastest to the most accurate. Which they are hangs on times, and so the whole table may "
        "differ a little from run to run.",
        {{"configuration", "configuration", true},
         {"error_pct", "error [%]", true},
         {"direction_p95_deg", "direction p95 [deg]", true},
         {"tick_p999_us", "tick p99.9 [us]", true},
         {"tick_p50_us", "p50 [us]", true},
         {"asset_kib", "assets [KiB]", true},
         {"conversion_s", "conversion [s]", true}},
        {},
        "error_over_time"};
    for (const std::size_t n : front(result, [](const AccuracyRow &r) { return r.tick.p999; })) {
        const AccuracyRow &r = result.rows[n];
        table.rows.push_back({r.config.text(), 100 * r.error, r.angle_p95, us * r.tick.p999, us * r.tick.p50,
                              r.asset_bytes / kib, r.conversion});
    }
    return table;
}

} // namespace

std::vector<StudyTable> accuracy_tables(const AccuracyResult &result, const Advice &)
{
    return {front_table(result),       accuracy_table(result), reference_table(result),
            steps_table(result),       pairs_table(result),    culling_table(result),
            rounding_table(result),    filter_table(result),   scale_table(result, true),
            scale_table(result, false)};
}

} // namespace voxshell
