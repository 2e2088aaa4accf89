// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell device: which devices are here, why one is not usable and the exact fix, how well it is heard.
#include "cli/device_actions.hpp"
#include "cli/device_doctor.hpp"
#include "cli/hardware_options.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "pipeline/output.hpp"
#include "study/durations.hpp"
#include "study/lateness.hpp"

#include "voxshell/simulated.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;

constexpr const char *not_verified = "not verified on hardware";

const char *verdict_name(Finding::Verdict verdict)
{
    return verdict == Finding::Verdict::ok       ? "ok"
           : verdict == Finding::Verdict::notice ? "notice"
                                                 : "trouble";
}

json candidate_json(const Candidate &c)
{
    return {{"kind", c.kind},
            {"where", c.where},
            {"node", c.node},
            {"usable", c.is_usable},
            {"why_not", c.why_not}};
}

ExitCode list(const DeviceOptions &o)
{
    const std::vector<Candidate> candidates = find_candidates("/");
    json out = {{"schema", "voxshell-device/1"},
                {"version", tool_version()},
                {"action", "list"},
                {"kinds", json::array()},
                {"devices", json::array()}};
    out["kinds"].push_back({{"name", "sim"},
                            {"summary", "simulated: a mass in a hand, no hardware"},
                            {"built", true},
                            {"verified", true},
                            {"lacks", ""}});
    for (std::uint32_t n = 0; const vxs_hardware_kind *kind = vxs_hardware_kind_at(n); ++n)
        out["kinds"].push_back({{"name", kind->name},
                                {"summary", kind->summary},
                                {"built", kind->is_built != 0},
                                {"verified", false},
                                {"lacks", kind->is_built ? "" : kind->lacks_text}});
    for (std::uint32_t n = 0; const vxs_simulated_profile *p = vxs_simulated_profile_at(n); ++n) {
        const std::string name = fmt::format("sim:{}", p->name);
        out["devices"].push_back(candidate_json({"sim", name, "", true, ""}));
    }
    for (const Candidate &c : candidates) out["devices"].push_back(candidate_json(c));
    if (o.json) {
        fmt::print("{}", json_text(out));
        return ExitCode::ok;
    }
    fmt::print("kinds:\n");
    for (const json &kind : out["kinds"])
        fmt::print("  {:<11} {}{}\n", kind["name"].get<std::string>(), kind["summary"].get<std::string>(),
                   !kind["built"].get<bool>()     ? "; " + kind["lacks"].get<std::string>()
                   : kind["verified"].get<bool>() ? ""
                                                  : fmt::format("; {}", not_verified));
    fmt::print("devices:\n");
    for (const json &device : out["devices"])
        fmt::print("  {}{}{}\n", device["where"].get<std::string>(),
                   device["kind"] == "sim" ? "" : "  " + device["kind"].get<std::string>(),
                   device["usable"].get<bool>() ? ""
                                                : "  not usable: " + device["why_not"].get<std::string>());
    if (candidates.empty()) fmt::print("  no hardware found; `voxshell device doctor` looks closer\n");
    return ExitCode::ok;
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

/// Tells, and writes what was asked for. Not a verdict: whether a machine is quiet enough is for its user to
/// say.
json report_loop(const DeviceOptions &o, const Lateness &measured, const std::string &title,
                 Progress &progress)
{
    Outputs outputs(o.force);
    if (!o.histogram.empty()) outputs.add(o.histogram, histogram_csv(measured));
    for (const std::string &plot : o.plots)
        outputs.add(plot, plot_histogram(measured, title, picture_of(plot)));
    progress.check();
    outputs.commit();
    std::vector<float> late_ns = measured.late_ns, work_ns = measured.work_ns;
    const Durations late = durations(late_ns), work = durations(work_ns);
    if (!o.json) {
        fmt::print("  loop    {} ticks at {} Hz, {} periods missed; {}; memory {}\n",
                   format_count(measured.late_ns.size()), o.rate, measured.missed, measured.scheduling,
                   measured.memory);
        fmt::print("  late    {}\n  work    {}\n", durations_text(late), durations_text(work));
    }
    return {{"ticks", measured.late_ns.size()}, {"rate_hz", o.rate},
            {"missed", measured.missed},        {"scheduling", measured.scheduling},
            {"memory", measured.memory},        {"lateness", durations_json(late)},
            {"work", durations_json(work)}};
}

std::uint64_t ticks_of(const DeviceOptions &o)
{
    return static_cast<std::uint64_t>(std::ceil(o.seconds * o.rate));
}

ExitCode doctor(const DeviceOptions &o, Progress &progress)
{
    const std::vector<Finding> findings = examine(find_candidates("/"), "/");
    json out = {{"schema", "voxshell-device/1"},
                {"version", tool_version()},
                {"action", "doctor"},
                {"findings", json::array()}};
    bool is_in_trouble = false;
    for (const Finding &f : findings) {
        out["findings"].push_back(
            {{"what", f.what}, {"verdict", verdict_name(f.verdict)}, {"fact", f.fact}, {"fix", f.fix}});
        is_in_trouble |= f.verdict == Finding::Verdict::trouble;
        if (o.json) continue;
        fmt::print("{:<7} {}: {}\n", verdict_name(f.verdict), f.what, f.fact);
        if (!f.fix.empty()) fmt::print("        fix: {}\n", f.fix);
    }
    if (!o.json) fmt::print("waking up for {} s:\n", o.seconds);
    const Lateness measured = measure_lateness(
        o.rate, ticks_of(o), [] {}, progress);
    out["loop"] = report_loop(o, measured, fmt::format("waking up at {} Hz, {}", o.rate, measured.scheduling),
                              progress);
    if (o.json) fmt::print("{}", json_text(out));
    return is_in_trouble ? ExitCode::requirement : ExitCode::ok;
}

/// Listens only: the device is never armed, so nothing can push.
ExitCode test(const DeviceOptions &o, Progress &progress)
{
    if (o.device.empty())
        throw Failure(ExitCode::usage, "", "device test: say which, as sim:omega-3 or hvlink:/dev/ttyACM0");
    const OpenDevice open(settings_of(o));
    const vxs_device_caps &caps = open.get()->caps;
    vxs_device_state state{};
    std::uint64_t fresh = 0, sequence = 0;
    double age = 0, low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    std::uint32_t buttons = 0;
    const Lateness measured = measure_lateness(
        o.rate, ticks_of(o),
        [&] {
            vxs_device_exchange(open.get(), nullptr, &state, nullptr);
            fresh += state.sequence != sequence;
            sequence = state.sequence;
            age = std::max(age, state.link_age);
            buttons |= state.buttons;
            for (int n = 0; n < 3; ++n) {
                low[n] = std::min(low[n], state.pose.position[n]);
                high[n] = std::max(high[n], state.pose.position[n]);
            }
        },
        progress);
    const double span = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    const double seconds = static_cast<double>(measured.late_ns.size()) / o.rate;
    json out = {{"schema", "voxshell-device/1"},
                {"version", tool_version()},
                {"action", "test"},
                {"device", o.device},
                {"name", caps.name},
                {"verified", !open.is_hardware()},
                {"state", device_state_name(state.state)},
                {"measurements_hz", static_cast<double>(fresh) / seconds},
                {"link_age_max_s", age},
                {"moved_m", span},
                {"buttons", buttons}};
    if (!o.json) {
        fmt::print("{}: {}{}, {} at the end, force off\n", o.device, caps.name,
                   open.is_hardware() ? fmt::format(" ({})", not_verified) : "",
                   device_state_name(state.state));
        fmt::print(
            "  heard   {:.0f} measurements a second, {:.1f} ms old at most; moved within {}, buttons {:#x}\n",
            static_cast<double>(fresh) / seconds, 1e3 * age, format_length(span), buttons);
    }
    out["loop"] = report_loop(
        o, measured, fmt::format("{} at {} Hz, {}", o.device, o.rate, measured.scheduling), progress);
    if (o.json) fmt::print("{}", json_text(out));
    if (state.state == VXS_DEVICE_FAULT || state.state == VXS_DEVICE_GONE)
        throw Failure(
            ExitCode::requirement, o.device,
            fmt::format("the device ended as {}, fault {}", device_state_name(state.state), state.fault));
    return ExitCode::ok;
}

ExitCode run(const DeviceOptions &o)
{
    for (const std::string &plot : o.plots) picture_of(plot);
    const auto progress = make_progress(o.progress, o.quiet);
    if (o.action == "list") return list(o);
    if (o.action == "doctor") return doctor(o, *progress);
    if (o.action == "watch") return watch_live(o, *progress);
    return o.action == "calibrate" ? calibrate_device(o, *progress) : test(o, *progress);
}

} // namespace

DeviceSettings settings_of(const DeviceOptions &o)
{
    return {o.device, o.rate, o.hardware};
}

VerbAction add_device(CLI::App &verb)
{
    auto o = std::make_shared<DeviceOptions>();
    verb.add_option(
            "ACTION", o->action,
            "list: what is here; doctor: why one is not usable, the exact fix, and how late this machine "
            "wakes up; test: listens to a device, force off; calibrate: hangs a known mass on one that "
            "holds itself up, and says what its newton weighs; watch: prints what a loop in another process "
            "does right now")
        ->required()
        ->check(CLI::IsMember({"list", "doctor", "test", "calibrate", "watch"}));
    verb.add_option(
        "DEVICE", o->device,
        "for test: sim:NAME, replay:FILE, hvlink:/dev/ttyACM0 (or hvlink:VVVV:PPPP over libusb), haply the "
        "same, spacemouse, falcon; for "
        "calibrate hardware with motors; for watch the file of `simulate --realtime --live FILE`");
    verb.add_option("--seconds", o->seconds, "doctor, test and watch: how long (default 5; 0.01 to 600)")
        ->check(CLI::Range(0.01, 600.0))
        ->type_name("S");
    verb.add_option("--rate", o->rate,
                    "doctor, test and calibrate: of the loop (default 1000 Hz; 100 to 10000)")
        ->check(CLI::Range(100.0, 10000.0))
        ->type_name("HZ");
    add_hardware_options(verb, o->hardware);
    verb.add_option("--mass", o->mass, "calibrate: what is hung on it, as 100g")->type_name("MASS");
    verb.add_option("--down", o->down, "calibrate: where weight pulls, in the device's frame (default -y)")
        ->check(CLI::IsMember({"x", "-x", "y", "-y", "z", "-z"}));
    verb.add_option("--period", o->period,
                    "calibrate: of its going up and down by 10 mm (default 2; 0.2 to 60)")
        ->check(CLI::Range(0.2, 60.0))
        ->type_name("S");
    verb.add_option("--histogram", o->histogram, "how late and how long each tick was, in bins of 1 us")
        ->type_name("FILE.csv");
    verb.add_option("--plot", o->plots, "the same as a picture, by gnuplot; may be repeated")
        ->type_name("FILE.svg|.png")
        ->expected(1)
        ->take_all();
    add_shared(verb, *o, {Shared::force, Shared::format, Shared::progress, Shared::quiet});
    return [o] { return run(*o); };
}

} // namespace voxshell
