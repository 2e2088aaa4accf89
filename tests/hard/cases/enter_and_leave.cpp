// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch touch(asset("block", h, [] { return block(); }), asset("ball", h, [] { return ball(); }), pair, m);
    for (const double along : {0.0, 1.0, 3.0}) { // how much further it goes sideways than down
        m.note(worst_jump(touch, m, 200,
                          [along](double share) {
                              const double down = 1e-3 * (share < 0.5 ? 2 * share : 2 - 2 * share);
                              return pose_at({along * 1e-3 * share, 6e-3 - down, 0.4 * along * 1e-3 * share});
                          }),
               "sideways " + number(along));
    }
}

} // namespace

// The bound: the project's bar, no jump over 5 % from tick to tick. A step of h/100 to a depth of 0.95 h is a
// jump of 1 % where force is linear in depth, 2 % for an edge or a ball, 3 % for a tip.
extern const Case enter_and_leave{"enter_and_leave",
                                  "a ball into a floor and out again, by h/100 a step, straight and aslant",
                                  "jump of the force, of the largest",
                                  0.05,
                                  has_common_normal,
                                  run};

} // namespace hard
