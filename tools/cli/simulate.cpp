// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell simulate: a scene or a plan on a device, simulated by default, as a summary, a trace and a
// picture.
#include "cli/hardware_options.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/scene_assets.hpp"
#include "cli/verb.hpp"
#include "pipeline/convert_scene.hpp"
#include "pipeline/output.hpp"
#include "plan/scene_contact.hpp"
#include "plan/scene_plan.hpp"
#include "study/servo_run.hpp"
#include "study/stage_costs.hpp"

#include "voxshell/servo.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

struct SimulateOptions : SharedOptions {
    std::string scene, assets, device, trace, recording, live;
    std::vector<std::string> plots;
    double seconds = 0; ///< 0: to the end of the hand's path, or of what is replayed
    HardwareSettings hardware;
    bool realtime = false, explain = false;
};

/// Not of a device of the plan's own kind: what it is run on beside.
bool runs_on_another(const SimulateOptions &o)
{
    return !o.device.empty() && !o.device.starts_with("sim:");
}

std::string flags_text(const ServoRun &run)
{
    std::string text;
    for (unsigned bit = 0; bit < run.flag_ticks.size(); ++bit) {
        if (run.flag_ticks[bit] && !flag_name(bit).empty()) {
            text +=
                fmt::format("{}{} ({} ticks)", text.empty() ? "" : ", ", flag_name(bit), run.flag_ticks[bit]);
        }
    }
    return text.empty() ? "none" : text;
}

std::string durations_text(const Durations &ns)
{
    return fmt::format("p50 {:.1f}, p99 {:.1f}, p99.9 {:.1f}, max {:.1f} us", ns.p50 / 1e3, ns.p99 / 1e3,
                       ns.p999 / 1e3, ns.max / 1e3);
}

json durations_json(const Durations &ns)
{
    return {{"p50_ns", ns.p50}, {"p99_ns", ns.p99}, {"p999_ns", ns.p999}, {"max_ns", ns.max}};
}

/// What it ran on, and who held that.
struct RanOn {
    std::string device, arm;
};

void tell(const PlannedServo &planned, const std::string &name, const RanOn &on, const ServoRun &run)
{
    const double seconds = static_cast<double>(run.ticks) / planned.rate;
    fmt::print("{}: {} s, {} ticks at {} Hz on {}{}\n", name, seconds, format_count(run.ticks), planned.rate,
               on.device,
               on.arm.empty()     ? fmt::format(", {} at the end", run.device_end)
               : on.arm == "free" ? ", held by nobody"
                                  : ", held by a " + on.arm);
    fmt::print("  coupling {}\n", planned.coupling);
    fmt::print("  force   at the hand {:.3f} N at most, {:.3f} N mean in contact, steps of {:.3f} N at most; "
               "collision {:.3f} N "
               "at most\n",
               run.output_peak, run.output_mean, run.step_most, run.collision_peak);
    if (run.contact_ticks) {
        fmt::print("  contact in {} ticks, {} of {} points at once, {} deep at most, hand up to {} ahead\n",
                   format_count(run.contact_ticks), run.points_most,
                   format_count(planned.shell().point_count), format_length(run.depth_most),
                   format_length(run.reach_most));
    } else {
        fmt::print("  contact never\n");
    }
    if (run.budget_points) {
        fmt::print("  budget  {} points in a tick on this machine; {} looked at at most, {}\n",
                   format_count(run.budget_points), format_count(run.probed_most),
                   run.level_most ? fmt::format("some at level of detail {} of 3", run.level_most)
                                  : "all levels of detail kept");
    }
    if (run.energy_least != 0) {
        fmt::print("  energy  taken from the hand never below {:.3g} mJ\n", 1e3 * run.energy_least);
    }
    fmt::print("  flags   {}\n", flags_text(run));
    fmt::print("  tick    {}\n", durations_text(run.tick));
    if (run.realtime) {
        fmt::print("  late    {}; {} periods missed\n", durations_text(run.realtime->lateness),
                   run.realtime->missed);
        fmt::print("  thread  {}; {}\n", run.realtime->scheduling, run.realtime->memory);
        if (run.realtime->rows_dropped) {
            fmt::print("  trace   {} rows came too fast to keep\n", run.realtime->rows_dropped);
        }
    }
}

json summary(const PlannedServo &planned, const std::string &name, const RanOn &on, const ServoRun &run)
{
    json flags = json::object();
    for (unsigned bit = 0; bit < run.flag_ticks.size(); ++bit) {
        if (run.flag_ticks[bit] && !flag_name(bit).empty()) {
            flags[flag_name(bit)] = run.flag_ticks[bit];
        }
    }
    json out = {{"schema", "voxshell-simulate/1"},
                {"version", tool_version()},
                {"scene", name},
                {"device", on.device},
                {"arm", on.arm},
                {"coupling", planned.coupling},
                {"rate_hz", planned.rate},
                {"voxel_m", planned.map().voxel},
                {"shell_points", planned.shell().point_count},
                {"seconds", static_cast<double>(run.ticks) / planned.rate},
                {"ticks", run.ticks},
                {"output_force_peak_n", run.output_peak},
                {"output_force_mean_n", run.output_mean},
                {"collision_force_peak_n", run.collision_peak},
                {"contact_ticks", run.contact_ticks},
                {"contacts_max", run.points_most},
                {"probed_max", run.probed_most},
                {"budget_points", run.budget_points},
                {"level_max", run.level_most},
                {"depth_max_m", run.depth_most},
                {"reach_max_m", run.reach_most},
                {"step_max_n", run.step_most},
                {"energy_min_j", run.energy_least},
                {"flag_ticks", flags},
                {"tick", durations_json(run.tick)}};
    if (run.realtime) {
        out["realtime"] = {{"scheduling", run.realtime->scheduling},
                           {"memory", run.realtime->memory},
                           {"missed", run.realtime->missed},
                           {"lateness", durations_json(run.realtime->lateness)}};
    }
    return out;
}

json number(const std::optional<double> &value)
{
    return value ? json(*value) : json(nullptr);
}

json explained(const TickCosts &costs)
{
    json out = {{"explain", json::array()}, {"stages", json::array()}, {"effects", json::array()}};
    for (const LoopPart &part : costs.parts) {
        json entry = durations_json(part.ns);
        entry["stage"] = part.name;
        entry["what"] = part.what;
        entry["instructions"] = number(part.instructions);
        out["explain"].push_back(entry);
    }
    for (const StageCost &stage : costs.stages) {
        json entry = {{stage.is_effect ? "effect" : "stage", stage.name},
                      {"reads", stage.reads},
                      {"changes", stage.changes},
                      {"ns", number(stage.ns)},
                      {"instructions", number(stage.instructions)}};
        if (stage.is_effect) {
            entry["in"] = stage.is_in;
            entry["why_not"] = stage.why_not;
            entry["elsewhere"] = json::object();
            for (const auto &[name, instructions] : stage.elsewhere) entry["elsewhere"][name] = instructions;
        }
        out[stage.is_effect ? "effects" : "stages"].push_back(entry);
    }
    out["counted_ticks"] = costs.counted_ticks;
    out["not_counted"] = costs.not_counted;
    return out;
}

/// "+12 345", or a dash where nothing was counted.
std::string signed_count(const std::optional<double> &value, bool plus)
{
    if (!value) return "-";
    const double whole = std::round(*value) + 0.0;
    return (whole < 0 ? "-" : plus ? "+" : "") + format_count(static_cast<std::uint64_t>(std::abs(whole)));
}

void tell(const TickCosts &costs, double rate)
{
    fmt::print("in each tick, {:.0f} us apart, each part measured alone:\n", 1e6 / rate);
    for (const LoopPart &part : costs.parts) {
        fmt::print("  {:<9} {:>8.2f} us (p99 {:.2f}) {:>9} instructions  {}\n", part.name, part.ns.p50 / 1e3,
                   part.ns.p99 / 1e3, signed_count(part.instructions, false), part.what);
    }
    const std::string how =
        costs.not_counted.empty()
            ? costs.counted_ticks == 1
                  ? "of one tick near the mean, stepped through one by one"
                  : fmt::format("a mean of {} ticks, stepped through one by one", costs.counted_ticks)
            : "not counted here: " + costs.not_counted;
    fmt::print("  (instructions: {})\n", how);
    const auto line = [](const StageCost &stage) {
        fmt::print("  {:<16} {} ns {:>9} instructions  reads {}{}\n", stage.name,
                   stage.is_effect ? fmt::format("{:>+7.0f}", *stage.ns) : fmt::format("{:>7.0f}", *stage.ns),
                   signed_count(stage.instructions, stage.is_effect), stage.reads,
                   stage.changes.empty() ? "" : "; changes " + stage.changes);
    };
    fmt::print("its stages in order; an effect's cost is its own stage and what it changes in others:\n");
    for (const StageCost &stage : costs.stages)
        if (stage.is_in) line(stage);
    fmt::print("left out, and what each would cost as by default:\n");
    for (const StageCost &stage : costs.stages) {
        if (stage.is_in) continue;
        if (stage.ns)
            line(stage);
        else
            fmt::print("  {:<16}    not here: {}; reads {}\n", stage.name, stage.why_not, stage.reads);
    }
}

/// What is to be run: a plan and its assets, open.
struct Given {
    PlanFile plan;
    std::string name;
    std::optional<SceneAssets> of_scene;
    std::optional<PlanAssets> of_plan;
    std::vector<vxs_asset> assets;
};

void read_plan_file(const SimulateOptions &o, Given &given)
{
    if (!o.device.empty() && !runs_on_another(o))
        throw Failure(ExitCode::usage, o.scene,
                      "--device: a plan is for its own device; simulate the scene instead");
    const fs::path path(o.scene);
    given.plan = read_plan(path);
    given.name = path.stem().string();
    const auto all =
        given.of_plan.emplace(given.plan, o.assets.empty() ? path.parent_path() : fs::path(o.assets)).all();
    given.assets.assign(all.begin(), all.end());
}

void plan_scene(const SimulateOptions &o, Progress &progress, Given &given)
{
    const SceneFile scene = read_scene(o.scene);
    const bool is_own = o.device.empty() || runs_on_another(o);
    if (is_own) check_scene(scene);
    given.name = scene_name(scene.path);
    const SceneAssets &assets = given.of_scene.emplace(scene, o.assets, o.max_memory.value_or(0), progress);
    given.assets = assets.all();
    given.plan = scene_plan(scene, is_own ? scene.device : o.device, assets.statics(), assets.dynamic(),
                            scene_contact(scene, assets.map, assets.shell), assets.mass);
}

/// Opened before anything is armed; hardware says how it is, and runs at the wall clock's rate or not at all.
void open_another(const SimulateOptions &o, double rate, std::optional<OpenDevice> &device)
{
    device.emplace(DeviceSettings{o.device, rate, o.hardware});
    if (device->is_hardware() && !o.realtime)
        throw Failure(ExitCode::usage, o.device, "hardware runs at the wall clock's rate: say --realtime");
    device->wait_until_ready();
}

RunOptions run_options(const SimulateOptions &o, const PlannedServo &planned, OpenDevice *device)
{
    constexpr double of_hardware = 10;
    RunOptions options;
    const double end = !device                 ? planned.hand.keyframes.back().t
                       : device->is_hardware() ? of_hardware
                                               : device->replay_seconds();
    options.seconds = o.seconds > 0 ? o.seconds : end > 0 ? end : 1;
    options.realtime = o.realtime;
    options.keep_rows = !o.trace.empty() || !o.plots.empty();
    options.keep_recording = !o.recording.empty();
    options.device = device;
    options.live = o.live;
    return options;
}

/// As recorder.h writes it.
std::vector<std::uint8_t> recording_bytes(const std::vector<vxs_servo_trace> &rows)
{
    const std::uint32_t about[2] = {sizeof(vxs_servo_trace), 0};
    std::vector<std::uint8_t> bytes(16 + rows.size() * sizeof(vxs_servo_trace));
    std::memcpy(bytes.data(), "VXSREC01", 8);
    std::memcpy(bytes.data() + 8, about, sizeof about);
    if (!rows.empty()) std::memcpy(bytes.data() + 16, rows.data(), rows.size() * sizeof(vxs_servo_trace));
    return bytes;
}

ExitCode simulate(const SimulateOptions &o)
{
    const bool is_plan = fs::path(o.scene).extension() == ".plan";
    if (!is_plan && !is_scene(o.scene)) {
        throw Failure(ExitCode::unsupported, o.scene,
                      "a scene ends in .scene.json, .scene.gltf or .scene.glb, a plan in .plan" +
                          meant_scene(o.scene));
    }
    for (const std::string &plot : o.plots) {
        picture_of(plot);
    }
    if (!o.live.empty() && !o.realtime)
        throw Failure(ExitCode::usage, o.live, "--live shows a loop that runs in --realtime");
    const auto progress = make_progress(o.progress, o.quiet);
    Given given;
    is_plan ? read_plan_file(o, given) : plan_scene(o, *progress, given);
    const PlannedServo planned(given.plan, given.assets, o.scene);
    std::optional<OpenDevice> device;
    if (runs_on_another(o)) open_another(o, planned.rate, device);
    const RunOptions options = run_options(o, planned, device ? &*device : nullptr);
    const ServoRun run = run_servo(planned, options, *progress);
    const RanOn on = device ? RanOn{o.device, ""} : RanOn{planned.device, planned.arm};

    Outputs outputs(o.force);
    if (!o.trace.empty()) {
        outputs.add(o.trace, trace_csv(run.rows));
    }
    if (!o.recording.empty()) {
        outputs.add(o.recording, recording_bytes(run.recording));
    }
    for (const std::string &plot : o.plots) {
        const std::string title =
            fmt::format("{}: voxel {}, {}, {}", given.name, format_length(planned.map().voxel),
                        planned.coupling, on.device);
        outputs.add(plot, plot_trace(run.rows, title, picture_of(plot)));
    }
    progress->check();
    outputs.commit();

    json out = summary(planned, given.name, on, run);
    if (!o.json) {
        tell(planned, given.name, on, run);
    }
    if (o.explain) {
        const TickCosts costs = tick_costs(planned, options.seconds, *progress);
        out.update(explained(costs));
        if (!o.json) tell(costs, planned.rate);
    }
    if (o.json) {
        fmt::print("{}", json_text(out));
    }
    if (run.flags & (VXS_SERVO_FAULT | VXS_SERVO_DEVICE_LOST | VXS_CONTACT_INVALID)) {
        throw Failure(ExitCode::requirement, o.scene,
                      fmt::format("the loop ended in a fault{}: zero force from then on",
                                  device ? fmt::format(" (device {})", run.device_end) : ""));
    }
    return ExitCode::ok;
}

} // namespace

VerbAction add_simulate(CLI::App &verb)
{
    auto o = std::make_shared<SimulateOptions>();
    verb.add_option(
            "SCENE", o->scene,
            "a scene: .scene.json, .scene.gltf, .scene.glb, or a plan: .plan with its assets beside it")
        ->required();
    verb.add_option("--assets", o->assets,
                    "folder with the scene's NAME.voxmap and NAME.pointshell (default: made for this run), "
                    "or with those that the plan names")
        ->type_name("DIR");
    verb.add_option(
            "--device", o->device,
            "in place of the scene's: sim:NAME, also "
            "sim:NAME,noise=20um,delay=3,loss=1%,loss-time=20ms,seed=7; "
            "replay:FILE, a trace, a recording or a table of t_s, x_m, y_m, z_m; or hardware, with "
            "--realtime: "
            "hvlink:/dev/ttyACM0, haply:/dev/ttyACM0, spacemouse, falcon. The coupling stays the scene's; "
            "hardware's middle is where the hand's path begins")
        ->type_name("DEVICE");
    verb.add_option("--seconds", o->seconds,
                    "how long (default: to the end of the hand's path, or of the replay; hardware 10; at "
                    "least one tick)")
        ->check(CLI::PositiveNumber)
        ->type_name("S");
    verb.add_flag(
        "--realtime", o->realtime,
        "on the servo thread at the wall clock's rate (default: virtual time, the same trace on every run)");
    verb.add_option("--trace", o->trace, "every tick as one line of numbers")->type_name("FILE.csv");
    verb.add_option("--record", o->recording, "every tick with all digits, for replay:FILE (recorder.h)")
        ->type_name("FILE.rec");
    verb.add_option("--live", o->live,
                    "with --realtime: shows the newest tick to other processes, as `voxshell device watch "
                    "FILE` (live.h)")
        ->type_name("FILE");
    add_hardware_options(verb, o->hardware);
    verb.add_option("--plot", o->plots,
                    "collision force (thin) and output force (thick) over time, by gnuplot; may be repeated")
        ->type_name("FILE.svg|.png")
        ->expected(1)
        ->take_all();
    verb.add_flag(
        "--explain", o->explain,
        "what runs in a tick, and what each stage and each effect left out costs in time and instructions");
    add_shared(
        verb, *o,
        {Shared::jobs, Shared::max_memory, Shared::force, Shared::format, Shared::progress, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        return simulate(*o);
    };
}

} // namespace voxshell
