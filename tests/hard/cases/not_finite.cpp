// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Loop loop(pair, m, [](vxs_servo_config &, vxs_simulated_config &simulated) {
        simulated.start.position[1] = 6e-3;
    });
    vxs_device_arm(loop.device);
    for (int n = 0; n < 1500; ++n) loop.tick({0, n < 100 ? 6e-3 : 4.6e-3, 0});
    m.must(length(loop.command.wrench.force) > 0.01, "no force to lose");
    const double bad[] = {NAN, INFINITY, -INFINITY, 1e308};
    for (int field = 0; field < 13; ++field)
        for (const double value : bad) {
            vxs_device_state state = loop.state;
            double *numbers[] = {state.pose.position, state.pose.orientation, state.velocity,
                                 state.angular_velocity};
            const int first[] = {0, 3, 7, 10}, which = field < 3 ? 0 : field < 7 ? 1 : field < 10 ? 2 : 3;
            numbers[which][field - first[which]] = value;
            state.sequence += 1;
            state.time_ns += 1'000'000;
            const std::uint32_t flags = loop.tick_on(state);
            const std::string here = "field " + std::to_string(field) + " = " + number(value);
            if (!std::isfinite(value)) m.must(flags & VXS_SERVO_FAULT, "no fault, " + here);
            if (flags & VXS_SERVO_FAULT)
                m.note(length(loop.command.wrench.force) + length(loop.command.wrench.torque), here);
            state = loop.state;
            state.sequence += 2;
            state.time_ns += 2'000'000;
            if (flags & VXS_SERVO_FAULT)
                m.must(loop.tick_on(state) & VXS_SERVO_FAULT, "the fault is not latched, " + here);
            vxs_servo_clear(loop.servo);
            loop.state.sequence += 3;
            loop.state.time_ns += 3'000'000;
            m.must(!(loop.tick_on(loop.state) & VXS_SERVO_FAULT),
                   "the fault stays after it was cleared, " + here);
        }
}

} // namespace

extern const Case not_finite{
    "not_finite",
    "NaN, infinity and 1e308 in each number that a device gives: fault, latched zero",
    "force and torque in a fault [N, N m]",
    0,
    all,
    run};

} // namespace hard
