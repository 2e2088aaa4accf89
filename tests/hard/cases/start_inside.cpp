// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Loop loop(pair, m, [](vxs_servo_config &, vxs_simulated_config &simulated) {
        simulated.start.position[1] = 4.6e-3;
    });
    vxs_device_arm(loop.device);
    for (int n = 0; n < 300; ++n) {
        m.must(loop.tick({0, 4.6e-3, 0}) & VXS_SERVO_START_IN_CONTACT,
               "the flag is missing in tick " + std::to_string(n));
        m.note(length(loop.command.wrench.force) + length(loop.command.wrench.torque));
    }
    for (int n = 0; n < 500; ++n) loop.tick({0, 6.5e-3, 0});
    m.must(!(loop.row.flags & VXS_SERVO_START_IN_CONTACT), "the flag stays after it was free");
    for (int n = 0; n < 1500; ++n) loop.tick({0, 4.4e-3, 0});
    m.must(loop.command.wrench.force[1] > 0.01, "no force after it was free");
}

} // namespace

extern const Case start_inside{"start_inside",
                               "armed while the object is in the floor: nothing until it has left",
                               "force and torque before it has left [N, N m]",
                               0,
                               all,
                               run};

} // namespace hard
