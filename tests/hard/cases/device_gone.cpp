// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Loop loop(pair, m);
    vxs_device_arm(loop.device);
    for (int n = 0; n < 1500; ++n) loop.tick({0, n < 100 ? 6e-3 : 4.6e-3, 0});
    m.must(length(loop.command.wrench.force) > 0.01, "no force to lose");
    vxs_simulated_break(loop.device, VXS_DEVICE_FAULT_USB);
    for (int n = 0; n < 50; ++n) {
        m.must(loop.tick({0, 4.6e-3, 0}) & VXS_SERVO_DEVICE_LOST,
               "the flag is missing in tick " + std::to_string(n));
        m.note(length(loop.command.wrench.force) + length(loop.command.wrench.torque),
               "tick " + std::to_string(n));
    }
    // One whose clock goes on without news counts as lost, too.
    Loop stale(pair, m);
    vxs_device_arm(stale.device);
    for (int n = 0; n < 1500; ++n) stale.tick({0, n < 100 ? 6e-3 : 4.6e-3, 0});
    for (int n = 1; n <= 40; ++n) {
        stale.state.time_ns += 1'000'000;
        const std::uint32_t flags = stale.tick_on(stale.state);
        m.must(flags & VXS_SERVO_DEVICE_STALE, "the stale flag is missing");
        if (n > 12) m.note(length(stale.command.wrench.force), "stale tick " + std::to_string(n));
    }
}

} // namespace

extern const Case device_gone{
    "device_gone",
    "a device unplugged in contact, and one that goes silent: zero within a tick, or after hold and decay",
    "force from then on [N]",
    0,
    all,
    run};

} // namespace hard
