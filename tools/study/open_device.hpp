// SPDX-License-Identifier: GPL-3.0-or-later
// A device by what people call it, open: sim:NAME, replay:FILE, or hardware, as hvlink:/dev/ttyACM0.
#pragma once

#include "plan/memory.hpp"

#include "voxshell/hardware.h"
#include "voxshell/replay.h"

#include <optional>
#include <string>
#include <vector>

namespace voxshell {

/// What hardware wants to know besides its name (hardware.h); 0 and empty: as by default.
struct HardwareSettings {
    std::string firmware;                     ///< falcon: a file of the user's
    bool is_in_place = false;                 ///< haply: it stands in its starting pose
    std::uint32_t haply_setup = 0;            ///< 2 or 3
    std::vector<double> haply_links;          ///< [m] three
    double units_per_nm = 0, torque_gain = 0; ///< falcon, haply: of the motors
};

struct DeviceSettings {
    std::string name;
    double rate =
        1000; ///< [Hz], of hardware's packets and of a replay's samples; a simulated device has its own
    HardwareSettings hardware;
};

/// For as long as this lives: letting go is its end, however it comes.
class OpenDevice {
  public:
    /// Throws Failure: usage (no such device; a name that lacks a place; options that are none), system (not
    /// there, not permitted, held by another program, not readable), unsupported (not in this build), invalid
    /// (a recording, with its line).
    explicit OpenDevice(const DeviceSettings &settings);
    ~OpenDevice();
    OpenDevice(const OpenDevice &) = delete;
    OpenDevice &operator=(const OpenDevice &) = delete;

    vxs_device *get() const { return device_; }
    bool is_hardware() const { return is_hardware_; }
    bool is_replay() const { return !rows_.empty(); }
    double replay_seconds() const { return rows_.empty() ? 0 : rows_.back().time - rows_.front().time; }
    const DeviceSettings &settings() const { return settings_; }

    /// Until it is READY: a device that needs calibration by its user, or a firmware, never is. Throws
    /// Failure(requirement) with what is missing, Failure(interrupted) never: it takes 2 s at most.
    void wait_until_ready();

  private:
    vxs_result open_simulated();
    vxs_result open_replay(const std::string &file);
    vxs_result open_hardware(const std::string &kind, const std::string &address);

    DeviceSettings settings_;
    std::optional<Memory> memory_;
    std::vector<vxs_replay_row> rows_;
    vxs_device *device_ = nullptr;
    bool is_hardware_ = false;
};

/// "READY"
const char *device_state_name(std::uint32_t state);

/// "watchdog": the cause of a FAULT.
const char *device_fault_name(std::uint32_t fault);

} // namespace voxshell
