// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/time_domain.hpp"

#include "cli/failure.hpp"

#include <algorithm>
#include <numbers>

namespace voxshell {
namespace {

constexpr double at_rest = 1e-100; ///< [m], [m/s], [N]: less counts as none

} // namespace

vxs_simulated_config small_motions(vxs_simulated_config device)
{
    device.profile.friction = device.profile.resolution = 0;
    device.profile.peak_force = 1e30;
    return device;
}

TimeDomain::TimeDomain(vxs_simulated_config device, const vxs_coupling_config &coupling, double start)
    : device_memory_(vxs_simulated_memory()), coupling_memory_(vxs_coupling_memory())
{
    device.start.position[0] = start;
    if (vxs_simulated_open(device_memory_.get(), device_memory_.size(), &device, &device_) != VXS_OK ||
        vxs_device_arm(device_) != VXS_OK ||
        vxs_coupling_init(coupling_memory_.get(), coupling_memory_.size(), &coupling, &coupling_) != VXS_OK) {
        throw Failure(ExitCode::bug, device.profile.name, "the runtime refuses the loop");
    }
    const double origin[3] = {0, 0, 0};
    vxs_simulated_hand(device_, origin, nullptr);
}

TimeDomain::~TimeDomain()
{
    vxs_device_close(device_);
}

Motion TimeDomain::run(double stiffness, long ticks)
{
    Motion motion{0, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (long n = 0; n < ticks; ++n) {
        vxs_device_state state;
        vxs_device_exchange(device_, &command_, &state, nullptr);
        vxs_wrench contact = {{0, 0, 0}, {0, 0, 0}};
        vxs_pose body;
        do {
            vxs_coupling_pose(coupling_, &state.pose, &body);
            contact.force[0] = -stiffness * body.position[0];
        } while (vxs_coupling_refine(coupling_, &contact, std::abs(body.position[0]), &state.pose));
        vxs_coupling_step(coupling_, &contact, &state.pose, &command_.wrench);
        command_.sequence++;
        command_.hold_ns = state.time_ns + 1'000'000'000;
        command_.expires_ns = command_.hold_ns + 1'000'000;
        double at[3], speed[3];
        vxs_simulated_truth(device_, at, speed);
        motion.rms += at[0] * at[0] / static_cast<double>(ticks);
        motion.least = std::min(motion.least, at[0]);
        motion.most = std::max(motion.most, at[0]);
        if (std::max({std::abs(at[0]), std::abs(speed[0]), std::abs(command_.wrench.force[0])}) < at_rest)
            break; // what died away would go on in denormal numbers, forty times slower
    }
    motion.rms = std::sqrt(motion.rms);
    return motion;
}

double growth(const vxs_simulated_config &device, const vxs_coupling_config &coupling, double stiffness,
              long ticks)
{
    TimeDomain loop(small_motions(device), coupling);
    loop.run(stiffness, ticks / 4);
    const double before = loop.run(stiffness, ticks / 4).rms;
    loop.run(stiffness, ticks / 4);
    const double after = loop.run(stiffness, ticks / 4).rms;
    return std::isfinite(after) ? std::log(after / before) : std::numeric_limits<double>::infinity();
}

long ticks_of_onset(const Loop &loop, double stiffness, double periods)
{
    double best = std::numeric_limits<double>::infinity(), angle = 0.1;
    for (double a = 1e-4; a < std::numbers::pi; a *= 1.001) {
        const double off = std::abs(1.0 + stiffness * loop.gain(a));
        if (off < best) {
            best = off;
            angle = a;
        }
    }
    return static_cast<long>(periods * 2 * std::numbers::pi / angle) + 6000;
}

} // namespace voxshell
