// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/simulated_loop.hpp"

#include "plan/design.hpp"
#include "plan/scene_contact.hpp"
#include "plan/simulated_device.hpp"

#include <fmt/format.h>

#include <cmath>

namespace voxshell {
namespace {

constexpr std::uint64_t most_ticks = 100'000'000;

} // namespace

void require_ok(vxs_result result, const std::string &where)
{
    if (result != VXS_OK) {
        throw Failure(ExitCode::invalid, "", where + ": " + vxs_result_text(result));
    }
}

Simulated::Simulated(const PlannedServo &planned)
    : config(simulated_device(planned.device, planned.rate)), memory_(vxs_simulated_memory())
{
    const vxs_simulated_arm *arm = vxs_simulated_arm_named(planned.arm.c_str());
    if (!arm) throw Failure(ExitCode::unsupported, "", "no arm \"" + planned.arm + "\"");
    config.arm = *arm;
    config.start = as_runtime(planned.hand.at(0));
    require_ok(vxs_simulated_open(memory_.get(), memory_.size(), &config, &device), planned.device);
}

Simulated::~Simulated()
{
    vxs_device_close(device);
}

Servo::Servo(const vxs_servo_config &config) : memory_(vxs_servo_memory(&config))
{
    require_ok(vxs_servo_init(memory_.get(), memory_.size(), &config, &servo), "servo");
}

std::uint64_t ticks_of(const PlannedServo &planned, double seconds)
{
    const double ticks = std::round(seconds * planned.rate);
    if (!(ticks >= 1) || ticks > static_cast<double>(most_ticks)) {
        throw Failure(
            ExitCode::usage, "",
            fmt::format("--seconds must give between 1 and {} ticks at {} Hz", most_ticks, planned.rate));
    }
    return static_cast<std::uint64_t>(ticks);
}

void move_hand(vxs_device *device, const Pose &pose)
{
    const vxs_pose target = as_runtime(pose);
    vxs_simulated_hand(device, target.position, target.orientation);
}

float ns_since(Clock::time_point begin)
{
    return std::chrono::duration<float, std::nano>(Clock::now() - begin).count();
}

} // namespace voxshell
