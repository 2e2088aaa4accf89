// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch touch(asset("tilted block", h, [] { return moved(block(), tilted); }),
                asset("ball", h, [] { return ball(); }), pair, m);
    // In at one place, along, out at another, and the other way round: 0.45 h deep, h/200 a step.
    const Point corner[] = {
        {-2e-3, 5.6e-3, 1e-3}, {-2e-3, 5.05e-3, 1e-3}, {1.3e-3, 5.05e-3, -0.7e-3}, {1.3e-3, 5.6e-3, -0.7e-3}};
    for (const int direction : {1, -1}) {
        double taken = 0, most = 0, last_force[3] = {}, last[3] = {};
        bool has_last = false;
        for (int leg = 0; leg < 3; ++leg) {
            const Point &from = corner[direction > 0 ? leg : 3 - leg],
                        &to = corner[direction > 0 ? leg + 1 : 2 - leg];
            const int steps = static_cast<int>(std::ceil(apart(from.data(), to.data()) / (h / 200)));
            for (int n = 0; n <= steps; ++n) {
                const double share = static_cast<double>(n) / steps;
                const Point p =
                    tilted({from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1]),
                            from[2] + share * (to[2] - from[2])});
                const vxs_contact_result &result = touch.at(pose_at(p));
                for (int i = 0; i < 3; ++i) {
                    if (has_last) taken -= (result.wrench.force[i] + last_force[i]) / 2 * (p[i] - last[i]);
                    last_force[i] = result.wrench.force[i];
                    last[i] = p[i];
                }
                has_last = true;
                most = std::max(most, taken);
            }
        }
        m.must(most > 0, "nothing was taken on the way in");
        m.note(most > 0 ? std::max(0.0, -taken) / most : 0, direction > 0 ? "one way" : "the other way");
    }
}

} // namespace

// The bound: what has a potential gives back what it took. A distance channel of 4 cells has steps of 4/32767
// h, so that depth is off by half of one at either end of the path, at 0.45 h; energy goes with its cube at
// most. The other laws push along directions of the shell, which are no slope of anything: a force F that
// leans by e against the wall gives e F on every metre along it (contact.h), and this path is 7.6 depths
// long.
extern const Case energy{
    "energy",
    "a ball pressed into a tilted floor, moved along and lifted elsewhere: what it gives beyond what it took",
    "energy created, of what was stored",
    3 * 4 / 32767.0 / 0.45,
    is_conservative,
    run};

} // namespace hard
