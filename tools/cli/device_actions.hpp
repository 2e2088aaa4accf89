// SPDX-License-Identifier: GPL-3.0-or-later
// What `voxshell device` does, an action each.
#pragma once

#include "cli/failure.hpp"
#include "cli/options.hpp"
#include "study/open_device.hpp"

#include <string>
#include <vector>

namespace voxshell {

struct DeviceOptions : SharedOptions {
    std::string action, device, histogram, mass, down = "-y"; ///< mass and down: calibrate
    std::vector<std::string> plots;
    double seconds = 5, rate = 1000;
    double period = 2; ///< calibrate [s]
    HardwareSettings hardware;
};

DeviceSettings settings_of(const DeviceOptions &options);

/// Hangs a known mass on a device, and says what its newton weighs. Throws Failure: usage, requirement (it
/// did not come to an end, with the cause), interrupted, and as OpenDevice.
ExitCode calibrate_device(const DeviceOptions &options, Progress &progress);

/// Prints what a servo loop in another process shows (simulate --live), a line each 50 ms. Throws Failure:
/// usage, system (no such file), invalid (another version), interrupted.
ExitCode watch_live(const DeviceOptions &options, Progress &progress);

} // namespace voxshell
