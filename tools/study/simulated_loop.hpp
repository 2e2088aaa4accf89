// SPDX-License-Identifier: GPL-3.0-or-later
// A plan's loop on a simulated device, for whoever runs it or measures it.
#pragma once

#include "study/planned_servo.hpp"

#include "voxshell/servo.h"
#include "voxshell/simulated.h"

#include <chrono>
#include <cstdint>
#include <string>

namespace voxshell {

/// Throws Failure(invalid) for what is not VXS_OK.
void require_ok(vxs_result result, const std::string &where);

/// A simulated device at the start of the hand's path.
class Simulated {
  public:
    explicit Simulated(const PlannedServo &planned);
    ~Simulated();
    Simulated(const Simulated &) = delete;
    Simulated &operator=(const Simulated &) = delete;
    vxs_simulated_config config;
    vxs_device *device = nullptr;

  private:
    Memory memory_;
};

class Servo {
  public:
    explicit Servo(const vxs_servo_config &config);
    vxs_servo *servo = nullptr;

  private:
    Memory memory_;
};

/// Of so many seconds. Throws Failure(usage) for none and for more than 10^8.
std::uint64_t ticks_of(const PlannedServo &planned, double seconds);

void move_hand(vxs_device *device, const Pose &pose);

using Clock = std::chrono::steady_clock;
float ns_since(Clock::time_point begin);

} // namespace voxshell
