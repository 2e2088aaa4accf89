// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell design: the coupling for a device, the arms that hold it and a contact, as a table, JSON and
// pictures.
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/scene_assets.hpp"
#include "cli/verb.hpp"
#include "pipeline/output.hpp"
#include "plan/scene_contact.hpp"
#include "plan/simulated_device.hpp"
#include "scene/quantity.hpp"
#include "study/plot_design.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

constexpr double two_pi = 2 * std::numbers::pi;
constexpr double shown_filters_hz[] = {0, 5, 20, 50, 200}; // 0: none

struct DesignOptions : SharedOptions {
    std::string scene, assets, device, rate, stiffness, coupling, frequency, out;
    std::vector<std::string> assume;
    double damping = 1;
    std::uint32_t delay = 0; ///< 0: the device's
    bool automatic = false;
};

double quantity(const std::string &option, const std::string &text, Dimension dimension)
{
    const auto value = parse_quantity(text, dimension);
    if (!value || !(*value > 0)) {
        throw Failure(ExitCode::usage, "",
                      option + ": '" + text + "' is not a number above zero with a unit of " +
                          units_of(dimension));
    }
    return *value;
}

/// What is asked for, and where the stiffness is from.
struct Question {
    DesignInput input;
    std::string device, source;
};

void take_coupling(const DesignOptions &o, DesignInput &input)
{
    vxs_coupling_config &coupling = input.coupling;
    if (!o.coupling.empty()) {
        coupling.kind = vxs_coupling_kind_named(o.coupling.c_str());
        input.automatic = o.frequency.empty();
        input.any_kind = false;
    }
    if (!o.frequency.empty()) {
        if (!o.coupling.empty() && coupling.kind != VXS_COUPLING_PT2) {
            throw Failure(ExitCode::usage, "", "--frequency is for --coupling pt2");
        }
        coupling.kind = VXS_COUPLING_PT2;
        coupling.omega0 = two_pi * quantity("--frequency", o.frequency, Dimension::frequency);
        coupling.damping = o.damping;
        input.automatic = input.any_kind = false;
    }
    input.automatic = input.automatic || o.automatic;
}

Question question_of(const DesignOptions &o, Progress &progress)
{
    Question q;
    std::optional<SceneFile> scene;
    if (!o.scene.empty()) {
        if (!is_scene(o.scene)) {
            throw Failure(ExitCode::unsupported, o.scene,
                          "a scene ends in .scene.json, .scene.gltf or .scene.glb" + meant_scene(o.scene));
        }
        scene = read_scene(o.scene);
    }
    q.device = !o.device.empty() ? o.device : scene ? scene->device : SceneFile().device;
    if (scene && !o.rate.empty()) {
        throw Failure(ExitCode::usage, "", "the scene says the rate: leave out --rate");
    }
    const double rate = scene            ? scene->rate
                        : o.rate.empty() ? 0
                                         : quantity("--rate", o.rate, Dimension::frequency);
    vxs_simulated_config device = simulated_device(q.device, rate);
    if (!(device.sample_time >= VXS_COUPLING_MIN_SAMPLE_TIME &&
          device.sample_time <= VXS_COUPLING_MAX_SAMPLE_TIME)) {
        throw Failure(ExitCode::usage, "", "--rate must be between 10Hz and 100kHz");
    }
    device.delay_samples = o.delay ? o.delay : device.delay_samples;
    if (scene) {
        q.input = design_input(*scene, device, 1);
    } else {
        q.input.device = device;
        vxs_coupling_config_default(&q.input.coupling);
        q.input.automatic = true;
    }
    take_coupling(o, q.input);
    if (!o.assume.empty()) {
        q.input.assume = o.assume;
    }
    std::optional<SceneAssets> assets;
    const auto open = [&]() -> const SceneAssets & {
        return assets ? *assets : assets.emplace(*scene, o.assets, o.max_memory.value_or(0), progress);
    };
    if (!o.stiffness.empty()) {
        q.input.stiffness = quantity("--stiffness", o.stiffness, Dimension::stiffness);
        q.source = "given";
    } else if (scene && scene->most_stiffness > 0) {
        q.input.stiffness = scene->most_stiffness;
        q.source = "the scene's most_stiffness";
    } else if (scene) {
        const ContactStiffness stiffness = contact_stiffness(*scene, open().map, open().shell);
        q.input.stiffness = stiffness.value;
        q.source = stiffness.source;
    } else {
        q.input.stiffness = device.profile.max_stiffness;
        q.source = "recommended for the device";
    }
    if (q.input.any_kind) {
        q.input.pushes = pushes(*scene, open().map, open().shell);
    }
    return q;
}

/// The command that makes it again, in one order whatever was typed.
std::string command_of(const DesignOptions &o)
{
    std::string text = "voxshell design";
    const auto add = [&](const std::string &name, const std::string &value) {
        if (!value.empty()) text += name + value;
    };
    add(" ", o.scene.empty() ? "" : fs::path(o.scene).filename().string());
    add(" --device ", o.device);
    add(" --rate ", o.rate);
    add(" --delay ", o.delay ? std::to_string(o.delay) : "");
    add(" --stiffness ", o.stiffness);
    add(" --coupling ", o.coupling);
    add(" --frequency ", o.frequency);
    add(" --damping ", o.frequency.empty() ? "" : fmt::format("{}", o.damping));
    add("", o.automatic ? " --auto" : "");
    for (const std::string &arm : o.assume) {
        add(" --assume ", arm);
    }
    return text + " -o DIR";
}

json number(double value)
{
    return std::isfinite(value) ? json(value) : json(nullptr);
}

json margins_json(const Margins &margins)
{
    return {{"gain_db", number(margins.gain_db)},
            {"phase_deg", number(margins.phase_deg)},
            {"delay_ms", number(1e3 * margins.delay_s)}};
}

json push_json(const std::optional<PushDesign> &push)
{
    if (!push) return nullptr;
    return {{"speed_m_per_s", push->speed},      {"wall_m", push->wall},
            {"middle_m", push->middle},          {"arm", push->arm},
            {"device_m", push->stopped.device},  {"body_m", push->stopped.body},
            {"device_at_best_m", push->at_best}, {"holds", push->holds()}};
}

template<class F>
json by_arm(const Design &design, F value)
{
    json out = json::object();
    for (const ArmDesign &arm : design.arms) {
        out[arm.arm] = value(arm);
    }
    return out;
}

/// K_max of the device with a PT2 of damping 1.
std::vector<double> largest_with(const Design &design, double hertz)
{
    vxs_coupling_config coupling = design.coupling;
    coupling.kind = hertz > 0 ? VXS_COUPLING_PT2 : VXS_COUPLING_NONE;
    coupling.omega0 = two_pi * hertz;
    coupling.damping = 1;
    coupling.gain = 1;
    vxs_simulated_config device = design.input.device;
    std::vector<double> out;
    for (const ArmDesign &arm : design.arms) {
        device.arm = *vxs_simulated_arm_named(arm.arm.c_str());
        out.push_back(Loop(device, coupling).largest_stiffness());
    }
    return out;
}

bool fits(const Design &design, double hertz)
{
    return hertz * design.input.device.sample_time <= VXS_COUPLING_MAX_RATE;
}

json as_json(const Question &q, const Design &d)
{
    const bool is_pt2 = d.coupling.kind == VXS_COUPLING_PT2;
    json assume = json::array();
    for (const ArmDesign &arm : d.arms) {
        if (arm.counts) assume.push_back(arm.arm);
    }
    json filters = json::array();
    for (const double hertz : shown_filters_hz) {
        if (!fits(d, hertz)) continue;
        const std::vector<double> largest = largest_with(d, hertz);
        json row = {{"omega0_hz", hertz > 0 ? json(hertz) : json(nullptr)}};
        for (std::size_t n = 0; n < d.arms.size(); ++n) row[d.arms[n].arm] = number(largest[n]);
        filters.push_back(row);
    }
    return {
        {"schema", "voxshell-design/1"},
        {"version", tool_version()},
        {"device", q.device},
        {"rate_hz", 1 / d.input.device.sample_time},
        {"delay_samples", d.input.device.delay_samples},
        {"coupling", vxs_coupling_kind_name(d.coupling.kind)},
        {"automatic", d.input.automatic},
        {"chosen", d.chosen.empty() ? json(nullptr) : json(d.chosen)},
        {"push", push_json(d.push)},
        {"omega0_hz", is_pt2 ? json(d.coupling.omega0 / two_pi) : json(nullptr)},
        {"damping", is_pt2 ? json(d.coupling.damping) : json(nullptr)},
        {"gain", is_pt2 ? d.coupling.gain : 1.0},
        {"spring_n_per_m",
         d.coupling.kind == VXS_COUPLING_QUASI_STATIC ? json(d.coupling.stiffness) : json(nullptr)},
        {"bandwidth_hz", d.bandwidth_hz},
        {"contact_n_per_m", d.input.stiffness},
        {"contact_source", q.source},
        {"seen_n_per_m", d.seen},
        {"assume", assume},
        {"k_max_n_per_m", by_arm(d, [](const ArmDesign &arm) { return number(arm.largest_stiffness); })},
        {"k_hunting_n_per_m", by_arm(d, [](const ArmDesign &arm) { return number(arm.hunting_stiffness); })},
        {"margins", margins_json(d.worst)},
        {"margins_held", d.margins_held},
        {"margins_by_arm", by_arm(d, [](const ArmDesign &arm) { return margins_json(arm.margins); })},
        {"passive", by_arm(d, [](const ArmDesign &arm) { return json(arm.passive()); })},
        {"k_passive_n_per_m", by_arm(d, [](const ArmDesign &arm) { return number(arm.passive_stiffness); })},
        {"damping_missing_ns_per_m",
         by_arm(d, [](const ArmDesign &arm) { return json(arm.damping_missing); })},
        {"quantisation_n_per_m", number(d.quantisation)},
        {"unfiltered_free",
         {{"k_passive_n_per_m", number(d.unfiltered.passive_stiffness)},
          {"damping_missing_ns_per_m", d.unfiltered.damping_missing},
          {"rate_needed_hz", number(d.unfiltered.rate_needed)}}},
        {"k_max_by_filter", filters},
        {"refused", d.refused},
        {"advice", d.advice}};
}

std::string cell(double value, const char *format)
{
    return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

void tell(const Question &q, const Design &d)
{
    const auto &device = d.input.device;
    fmt::print("{} at {:.6g} Hz, {} sample{} of delay; contact up to {:.4g} N/m ({})\n", q.device,
               1 / device.sample_time, device.delay_samples, device.delay_samples == 1 ? "" : "s",
               d.input.stiffness, q.source);
    fmt::print("  device    {:.3g} kg, {:.3g} N s/m, friction {:.3g} N (assumed); steps of {:.3g} um, {:.3g} "
               "N and {:.4g} N/m at most\n",
               device.profile.mass, device.profile.viscosity, device.profile.friction,
               1e6 * device.profile.resolution, device.profile.peak_force, device.profile.max_stiffness);
    const char *how = d.input.automatic ? "picked" : "as given";
    if (d.coupling.kind == VXS_COUPLING_PT2) {
        fmt::print("  coupling  pt2 {:.4g} Hz, damping {:.3g}, gain {:.4g}, {}; force bandwidth {:.4g} Hz\n",
                   d.coupling.omega0 / two_pi, d.coupling.damping, d.coupling.gain, how, d.bandwidth_hz);
    } else if (d.coupling.kind == VXS_COUPLING_QUASI_STATIC) {
        fmt::print("  coupling  quasi-static, spring of {:.4g} N/m, {}; the device feels {:.4g} N/m\n",
                   d.coupling.stiffness, how, d.seen);
    } else {
        fmt::print("  coupling  none\n");
    }
    if (!d.chosen.empty()) {
        fmt::print("  chosen    {}\n", d.chosen);
    }
    if (d.push) {
        fmt::print("  push      at {:.3g} m/s into {:.3g} mm, by {}: the device comes {:.2f} mm in (its peak "
                   "force at once would stop it after "
                   "{:.2f}), what feels contact {:.2f} mm\n",
                   d.push->speed, 1e3 * d.push->wall, d.push->arm == "free" ? "nobody" : "a " + d.push->arm,
                   1e3 * d.push->stopped.device, 1e3 * d.push->at_best, 1e3 * d.push->stopped.body);
    }
    fmt::print("\n  {:<8}{:>12}{:>11}{:>10}{:>11}{:>10}{:>16}{:>23}\n", "arm", "K_max N/m", "hunts from",
               "gain dB", "phase deg", "delay ms", "passive to N/m", "damping missing N s/m");
    for (const ArmDesign &arm : d.arms) {
        fmt::print("  {:<8}{:>12}{:>11}{:>10}{:>11}{:>10}{:>16}{:>23}{}\n", arm.arm,
                   cell(arm.largest_stiffness, "{:.4g}"), cell(arm.hunting_stiffness, "{:.4g}"),
                   cell(arm.margins.gain_db, "{:.1f}"), cell(arm.margins.phase_deg, "{:.1f}"),
                   cell(1e3 * arm.margins.delay_s, "{:.2f}"), cell(arm.passive_stiffness, "{:.4g}"),
                   arm.passive() ? "passive" : fmt::format("{:.3g}", arm.damping_missing),
                   arm.counts ? "" : "  not assumed");
    }
    fmt::print(
        "\n  K_max N/m by filter (damping 1), with the hand off, a pen's, a hand's and an arm's hold:\n");
    for (const double hertz : shown_filters_hz) {
        if (!fits(d, hertz)) continue;
        fmt::print("  {:<8}", hertz > 0 ? fmt::format("{:g} Hz", hertz) : "none");
        for (const double largest : largest_with(d, hertz)) fmt::print("{:>12}", cell(largest, "{:.4g}"));
        fmt::print("\n");
    }
    fmt::print("  quantisation limit {} N/m\n", cell(d.quantisation, "{:.4g}"));
    for (const std::string &advice : d.advice) {
        fmt::print("- {}\n", advice);
    }
}

ExitCode design(const DesignOptions &o)
{
    const auto progress = make_progress(o.progress, o.quiet);
    const Question q = question_of(o, *progress);
    const Design d = design_coupling(q.input);
    if (!o.out.empty()) {
        Outputs outputs(o.force);
        for (const DesignPlot &plot : plot_design(d, command_of(o))) {
            const fs::path base = fs::path(o.out) / plot.name;
            outputs.add(base.string() + ".csv", plot.csv);
            outputs.add(base.string() + ".svg", plot.draw(Picture::svg));
            outputs.add(base.string() + ".png", plot.draw(Picture::png));
        }
        outputs.add(fs::path(o.out) / "design.json", json_text(as_json(q, d)));
        progress->check();
        outputs.commit();
    }
    if (o.json) {
        fmt::print("{}", json_text(as_json(q, d)));
    } else {
        tell(q, d);
    }
    if (d.refused) {
        std::fflush(stdout);
        throw Failure(ExitCode::requirement, o.scene,
                      "unstable with an arm that counts; soften the contact, take --coupling quasi-static, "
                      "or say --assume hand if the "
                      "device is always held");
    }
    return ExitCode::ok;
}

} // namespace

VerbAction add_design(CLI::App &verb)
{
    auto o = std::make_shared<DesignOptions>();
    verb.add_option("SCENE", o->scene,
                    "a scene: its device, rate, coupling and contact (default: what the options say)");
    verb.add_option("--device", o->device, "(default the scene's, or sim:phantom-premium-1.5)")
        ->type_name("sim:NAME");
    verb.add_option("--rate", o->rate, "of the loop, as 4kHz; 10Hz to 100kHz (default the device's own)")
        ->type_name("HZ");
    verb.add_option("--delay", o->delay, "samples between a command and its effect, 1 to 64 (default 1)")
        ->check(CLI::Range(1u, 64u))
        ->type_name("N");
    verb.add_option("--stiffness", o->stiffness,
                    "largest of the contact, as 800N/m (default the scene's most_stiffness, or all that its "
                    "path asks for "
                    "at once; without a scene what is recommended for the device)")
        ->type_name("N/m");
    verb.add_option("--coupling", o->coupling, "none, pt2 or quasi-static (default the scene's, or pt2)")
        ->check(CLI::IsMember({"none", "pt2", "quasi-static"}))
        ->type_name("KIND");
    verb.add_flag("--auto", o->automatic, "pick its numbers also where the scene says them");
    verb.add_option("--frequency", o->frequency,
                    "of a given pt2, as 5Hz; 0.05Hz to 0.49 of the rate (default: picked)")
        ->type_name("HZ");
    verb.add_option("--damping", o->damping, "of that pt2, 0.001 to 1000 (default 1)")
        ->check(CLI::Range(1e-3, 1e3))
        ->type_name("D");
    verb.add_option("--assume", o->assume,
                    "an arm that must hold; may be repeated (default free, pen, hand and arm)")
        ->check(CLI::IsMember({"free", "pen", "hand", "arm"}))
        ->type_name("ARM")
        ->expected(1)
        ->take_all();
    verb.add_option("--assets", o->assets, "folder with the scene's assets (default: made for this run)")
        ->type_name("DIR");
    verb.add_option("-o,--output", o->out,
                    "Bode, Nyquist and impedance plots as .svg, .png and .csv, and design.json")
        ->type_name("DIR");
    add_shared(
        verb, *o,
        {Shared::jobs, Shared::max_memory, Shared::force, Shared::format, Shared::progress, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        return design(*o);
    };
}

} // namespace voxshell
