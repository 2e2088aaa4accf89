// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell device calibrate: a known mass on a device that holds itself up.
#include "cli/device_actions.hpp"
#include "cli/run_report.hpp"
#include "scene/quantity.hpp"

#include "voxshell/calibration.h"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <optional>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;

void set_down(const std::string &text, double down[3])
{
    const std::size_t axis = std::string("xyz").find(text.back());
    down[0] = down[1] = down[2] = 0;
    down[axis] = text.front() == '-' ? -1 : 1;
}

const char *request(std::uint32_t phase, std::uint32_t before)
{
    if (phase == before) return nullptr;
    switch (phase) {
    case VXS_CALIBRATION_EMPTY:
        return "it weighs itself: do not touch it";
    case VXS_CALIBRATION_HANG:
        return "now hang the mass on it";
    case VXS_CALIBRATION_LOADED:
        return "it weighs the mass: do not touch it";
    default:
        return nullptr;
    }
}

const char *cause(std::uint32_t phase)
{
    switch (phase) {
    case VXS_CALIBRATION_IMPATIENT:
        return "nothing was hung on it in time, it never came to rest, or friction holds it";
    case VXS_CALIBRATION_TOO_HEAVY:
        return "the mass is more than it may hold here: take a lighter one";
    default:
        return "it let go: moved too fast, or not ARMED any more";
    }
}

/// What the option is that takes the scale, "" for none.
std::string option_of(const DeviceOptions &o, double scale)
{
    vxs_hardware_config config;
    vxs_hardware_config_default(&config);
    const double units = o.hardware.units_per_nm > 0 ? o.hardware.units_per_nm : config.units_per_nm;
    const double gain = o.hardware.torque_gain > 0 ? o.hardware.torque_gain : config.torque_gain;
    if (o.device.starts_with("falcon")) return fmt::format("--units-per-nm {:.0f}", units * scale);
    if (o.device.starts_with("haply")) return fmt::format("--torque-gain {:.4g}", gain * scale);
    return "";
}

void sleep_until(std::int64_t time_ns)
{
    const timespec time{.tv_sec = time_ns / 1'000'000'000, .tv_nsec = time_ns % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, nullptr);
}

std::int64_t now_ns()
{
    timespec time{};
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

vxs_calibration_result run(const DeviceOptions &o, const vxs_calibration_config &config, vxs_device *device,
                           Progress &progress)
{
    const Memory memory(vxs_calibration_memory());
    vxs_calibration *calibration = nullptr;
    if (vxs_calibration_init(memory.get(), memory.size(), &config, &calibration) != VXS_OK)
        throw Failure(ExitCode::usage, o.device,
                      "--mass, --period or --rate is out of the calibration's range");
    vxs_device_state state{};
    vxs_device_command command{};
    std::uint32_t phase = VXS_CALIBRATION_EMPTY, before = VXS_CALIBRATION_DONE;
    const auto period = static_cast<std::int64_t>(1e9 / o.rate + 0.5);
    for (std::int64_t next = now_ns() + period; phase < VXS_CALIBRATION_DONE;
         next = std::max(next + period, now_ns())) {
        if (const char *words = request(phase, before); words && !o.quiet)
            fmt::print(stderr, "{}: {}\n", o.device, words);
        before = phase;
        sleep_until(next);
        vxs_device_exchange(device, &command, &state, nullptr);
        phase = vxs_calibration_tick(calibration, &state, &command);
        progress.check();
    }
    vxs_device_exchange(device, &command, &state, nullptr); // zero
    vxs_calibration_result result;
    vxs_calibration_get(calibration, &result);
    if (phase != VXS_CALIBRATION_DONE)
        throw Failure(ExitCode::requirement, o.device,
                      fmt::format("{} ({}{}{})", cause(phase), device_state_name(state.state),
                                  state.fault ? ", " : "",
                                  state.fault ? device_fault_name(state.fault) : ""));
    return result;
}

} // namespace

ExitCode calibrate_device(const DeviceOptions &o, Progress &progress)
{
    const std::optional<double> mass = parse_quantity(o.mass, Dimension::mass);
    if (o.device.empty() || !mass || !(*mass > 0))
        throw Failure(
            ExitCode::usage, "",
            "device calibrate: say which device and what hangs on it, as hvlink:/dev/ttyACM0 --mass 100g");
    OpenDevice open(settings_of(o));
    const vxs_device_caps &caps = open.get()->caps;
    if (!caps.has_motors) throw Failure(ExitCode::unsupported, o.device, "has no motors to hold a mass with");
    vxs_calibration_config config;
    vxs_calibration_config_default(&config);
    config.mass = *mass;
    config.sample_time = 1 / o.rate;
    config.period = o.period;
    set_down(o.down, config.down);
    if (caps.peak_force > 0) config.max_force = std::min(config.max_force, caps.peak_force);
    open.wait_until_ready();
    if (const vxs_result armed = vxs_device_arm(open.get()); armed != VXS_OK)
        throw Failure(ExitCode::requirement, o.device, vxs_result_text(armed));
    const vxs_calibration_result result = run(o, config, open.get(), progress);
    const std::string option = option_of(o, result.scale);
    if (o.json) {
        fmt::print("{}", json_text(json{{"schema", "voxshell-device/1"},
                                        {"version", tool_version()},
                                        {"action", "calibrate"},
                                        {"device", o.device},
                                        {"name", caps.name},
                                        {"mass_kg", *mass},
                                        {"empty_n", result.empty},
                                        {"loaded_n", result.loaded},
                                        {"spread_n", result.spread},
                                        {"scale", result.scale},
                                        {"option", option}}));
        return ExitCode::ok;
    }
    fmt::print("{}: {}\n", o.device, caps.name);
    fmt::print("  weighed {:.3f} N commanded empty, {:.3f} N with {:.4g} kg ({:.3f} N), the last two periods "
               "{:.3f} N apart\n",
               result.empty, result.loaded, *mass, *mass * config.gravity, result.spread);
    fmt::print("  scale   {:.4f} commanded newtons a true one{}\n", result.scale,
               option.empty() ? "; its firmware is to give as many times as much"
                              : "; from now on say " + option);
    return ExitCode::ok;
}

} // namespace voxshell
