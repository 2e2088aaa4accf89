// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch touch(asset("block", h, [] { return block(); }),
                asset("slab", h,
                      [] {
                          return solids::box({-8e-3, 0, -8e-3}, {8e-3, 4e-3, 8e-3});
                      }),
                pair, m);
    Comparison same(m, 8e-3);
    for (int n = 0; n < 40; ++n) {
        const vxs_pose unit = turned({0.2e-3, 0.6e-3, 0}, {1, 0.2 * n, -0.5}, 0.01 * n);
        const vxs_wrench wrench = touch.at(unit).wrench;
        for (const double factor : {-1.0, 1.5e-6, -0.3, 7.0, 1e100}) {
            vxs_pose other = unit;
            for (double &q : other.orientation) q *= factor;
            same.add(wrench, touch.at(other).wrench, "times " + number(factor));
        }
    }
    // A device that flips the sign of its quaternion stands still all the same.
    Loop loop(pair, m);
    vxs_device_arm(loop.device);
    for (int n = 0; n < 400; ++n) {
        vxs_simulated_hand(loop.device, Point{0, 5.5e-3, 0}.data(), nullptr);
        vxs_device_exchange(loop.device, &loop.command, &loop.state, &loop.report);
        const vxs_pose pose = turned({0, 0, 0}, {0.3, 1, 2}, 0.4);
        for (int i = 0; i < 4; ++i) loop.state.pose.orientation[i] = (n % 2 ? -3 : 2) * pose.orientation[i];
        m.must(!(loop.tick_on(loop.state) & (VXS_SERVO_TELEPORT | VXS_SERVO_FAULT)),
               "a flipped sign counts as motion");
    }
}

} // namespace

// The bound: a rotation from a quaternion that is normalised is off by some 8 ulp (2e-15), at a lever of 11
// mm over a mean depth of 0.1 mm 2e-13.
extern const Case quaternions{
    "quaternions",
    "orientations of any length and either sign, and a device that flips the sign in every tick",
    "wrench off that of the unit quaternion",
    1e-12,
    all,
    run};

} // namespace hard
