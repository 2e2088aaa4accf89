// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/open_device.hpp"

#include "cli/failure.hpp"
#include "plan/simulated_device.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

namespace voxshell {
namespace {

constexpr std::size_t most_bytes = std::size_t{1} << 30; // a recording of an hour at 1 kHz

std::vector<char> bytes_of(const std::string &path)
{
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const auto size = file ? static_cast<std::streamoff>(file.tellg()) : -1;
    if (size < 0) throw Failure(ExitCode::system, path, "cannot be read");
    if (static_cast<std::size_t>(size) > most_bytes)
        throw Failure(ExitCode::unsupported, path,
                      fmt::format("a recording of more than {} bytes", most_bytes));
    std::vector<char> bytes(static_cast<std::size_t>(size));
    file.seekg(0);
    if (!file.read(bytes.data(), size)) throw Failure(ExitCode::system, path, "cannot be read");
    return bytes;
}

} // namespace

const char *device_state_name(std::uint32_t state)
{
    static constexpr const char *names[] = {"CLOSED", "NO_FIRMWARE", "UNCALIBRATED", "READY",
                                            "ARMED",  "FAULT",       "GONE"};
    return state < std::size(names) ? names[state] : "?";
}

const char *device_fault_name(std::uint32_t fault)
{
    static constexpr const char *names[] = {"none", "user",    "velocity", "watchdog", "software",
                                            "usb",  "deadman", "protocol", "overrun"};
    return fault < std::size(names) ? names[fault] : "?";
}

OpenDevice::OpenDevice(const DeviceSettings &settings) : settings_(settings)
{
    const std::string &name = settings_.name;
    const auto colon = name.find(':');
    const std::string kind = name.substr(0, colon),
                      rest = colon == std::string::npos ? "" : name.substr(colon + 1);
    const vxs_result result = kind == "sim"      ? open_simulated()
                              : kind == "replay" ? open_replay(rest)
                                                 : open_hardware(kind, rest);
    if (result != VXS_OK)
        throw Failure(result == VXS_UNSUPPORTED ? ExitCode::unsupported : ExitCode::system, name,
                      fmt::format("{}; `voxshell device doctor` looks closer", vxs_result_text(result)));
}

OpenDevice::~OpenDevice()
{
    vxs_device_close(device_);
}

vxs_result OpenDevice::open_simulated()
{
    const vxs_simulated_config config = simulated_device(settings_.name);
    memory_.emplace(vxs_simulated_memory());
    return vxs_simulated_open(memory_->get(), memory_->size(), &config, &device_);
}

vxs_result OpenDevice::open_replay(const std::string &file)
{
    if (file.empty()) throw Failure(ExitCode::usage, settings_.name, "say what: replay:FILE.csv");
    const std::vector<char> bytes = bytes_of(file);
    std::size_t count = 0, line = 0;
    vxs_result result = vxs_replay_parse(bytes.data(), bytes.size(), nullptr, 0, &count, &line);
    if (result == VXS_OK && count == 0) result = VXS_CORRUPT;
    if (result != VXS_OK)
        throw Failure(
            ExitCode::invalid, file,
            fmt::format(
                "{}: {}; a line of names (t_s, x_m, y_m, z_m, and where wanted qw to qz and buttons), then "
                "lines of numbers, or a recording of this version",
                line ? fmt::format("line {}", line) : "as a recording", vxs_result_text(result)));
    rows_.resize(count);
    vxs_replay_parse(bytes.data(), bytes.size(), rows_.data(), count, &count, &line);
    vxs_replay_config config;
    vxs_replay_config_default(&config);
    config.rows = rows_.data();
    config.row_count = count;
    config.sample_time = 1 / settings_.rate;
    memory_.emplace(vxs_replay_memory());
    result = vxs_replay_open(memory_->get(), memory_->size(), &config, &device_);
    if (result == VXS_PARAM)
        throw Failure(ExitCode::invalid, file,
                      "times that do not grow, a rotation that is none, or a number beyond 1e9");
    return result;
}

vxs_result OpenDevice::open_hardware(const std::string &kind, const std::string &address)
{
    const std::string &name = settings_.name;
    const vxs_hardware_kind *hardware = vxs_hardware_kind_named(kind.c_str());
    if (!hardware)
        throw Failure(ExitCode::usage, name, "no such kind of device; `voxshell device list` has them");
    if (!hardware->is_built) throw Failure(ExitCode::unsupported, name, hardware->lacks_text);
    if ((hardware->wires & VXS_HARDWARE_TTY) != 0 && address.empty())
        throw Failure(ExitCode::usage, name,
                      fmt::format("say where: {0}:/dev/ttyACM0, or {0}:VVVV:PPPP over libusb", kind));
    vxs_hardware_config config;
    vxs_hardware_config_default(&config);
    config.address = address.empty() ? nullptr : address.c_str();
    config.rate_hz = settings_.rate;
    const HardwareSettings &h = settings_.hardware;
    config.firmware = h.firmware.empty() ? nullptr : h.firmware.c_str();
    config.is_in_place = h.is_in_place;
    if (h.haply_setup != 0) config.haply_setup = h.haply_setup;
    if (!h.haply_links.empty()) std::ranges::copy(h.haply_links, config.haply_links);
    if (h.units_per_nm > 0) config.units_per_nm = h.units_per_nm;
    if (h.torque_gain > 0) config.torque_gain = h.torque_gain;
    memory_.emplace(vxs_hardware_memory());
    is_hardware_ = true;
    return vxs_hardware_open(memory_->get(), memory_->size(), hardware, &config, &device_);
}

void OpenDevice::wait_until_ready()
{
    using namespace std::chrono_literals;
    constexpr int most_turns = 200;
    vxs_device_state state{};
    if (!is_hardware_) return; // and no sample is lost
    for (int turn = 0; turn < most_turns; ++turn) {
        vxs_device_exchange(device_, nullptr, &state, nullptr);
        if (state.state == VXS_DEVICE_READY && state.sequence > 0) return;
        std::this_thread::sleep_for(10ms);
    }
    const char *why =
        state.state == VXS_DEVICE_UNCALIBRATED  ? ": calibrate it (falcon: pull the grip out and push it in; "
                                                  "haply: put it in its starting pose and say --in-place)"
        : state.state == VXS_DEVICE_NO_FIRMWARE ? ": give it a firmware of yours with --firmware"
        : state.state == VXS_DEVICE_READY       ? ", but nothing is heard of it: push it a little"
                                                : "";
    throw Failure(ExitCode::requirement, settings_.name,
                  fmt::format("is {}{}", device_state_name(state.state), why));
}

} // namespace voxshell
