// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/push.hpp"

#include "cli/failure.hpp"
#include "plan/memory.hpp"

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

void check(vxs_result result)
{
    if (result != VXS_OK) {
        throw Failure(ExitCode::invalid, "", std::string("push: ") + vxs_result_text(result));
    }
}

double force_at(const Push &push, double depth)
{
    const double at = depth / push.step, last = static_cast<double>(push.force.size()) - 1;
    if (!(at >= 0 && at < last)) return 0;
    const auto n = static_cast<std::size_t>(at);
    const double share = at - static_cast<double>(n);
    return push.force[n] + share * (push.force[n + 1] - push.force[n]);
}

/// Runs it; act gets the device's state and gives the force, which is positive against the push.
template<class F>
double deepest(const Push &push, vxs_simulated_config config, F act)
{
    const Memory memory(vxs_simulated_memory());
    config.start = vxs_pose_identity();
    config.start.position[0] = push.hand.front();
    vxs_device *device = nullptr;
    check(vxs_simulated_open(memory.get(), memory.size(), &config, &device));
    check(vxs_device_arm(device));
    vxs_device_state state{};
    vxs_device_command command{};
    double most = 0;
    for (const double hand : push.hand) {
        const double target[3] = {hand, 0, 0};
        vxs_simulated_hand(device, target, nullptr);
        vxs_device_exchange(device, &command, &state, nullptr);
        most = std::max(most, state.pose.position[0]);
        command.wrench.force[0] = -act(state);
        command.sequence++;
        command.hold_ns = state.time_ns + 1'000'000'000;
        command.expires_ns = command.hold_ns + 1'000'000;
    }
    vxs_device_close(device);
    return most;
}

} // namespace

Stopped stop_push(const Push &push, const vxs_simulated_config &device, const vxs_coupling_config &config)
{
    const Memory memory(vxs_coupling_memory());
    vxs_coupling *coupling = nullptr;
    check(vxs_coupling_init(memory.get(), memory.size(), &config, &coupling));
    bool is_first = true;
    Stopped out{0, 0};
    out.device = deepest(push, device, [&](const vxs_device_state &state) {
        if (is_first) vxs_coupling_reset(coupling, &state.pose);
        is_first = false;
        vxs_pose body;
        vxs_wrench contact{}, felt{};
        double depth;
        do {
            vxs_coupling_pose(coupling, &state.pose, &body);
            depth = body.position[0];
            contact.force[0] = -force_at(push, depth);
        } while (vxs_coupling_refine(coupling, &contact, std::max(depth, 0.0), &state.pose));
        out.body = std::max(out.body, depth);
        vxs_coupling_step(coupling, &contact, &state.pose, &felt);
        return -felt.force[0];
    });
    return out;
}

double stop_at_best(const Push &push, const vxs_simulated_config &device)
{
    double most = 0;
    bool is_stopped = false;
    deepest(push, device, [&](const vxs_device_state &state) {
        is_stopped = is_stopped || (most > 0 && state.velocity[0] < 0);
        if (!is_stopped) most = std::max(most, state.pose.position[0]);
        return most > 0 ? device.profile.peak_force : 0.0;
    });
    return most;
}

} // namespace voxshell
