// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    const Asset &floor = asset("block", h, [] { return block(); }), &tip = asset("centred cone", h, [] {
        return cone(3e-3, 9e-3, {0.5e-3, 0.5e-3, 0.5e-3});
    });
    Touch down(floor, tip, pair, m);
    m.note(worst_jump(down, m, 95,
                      [](double share) {
                          return pose_at({-0.3e-3, 0.5e-3 - 0.95e-3 * share, -0.4e-3});
                      }),
           "tip down");
    const Asset &standing = asset("standing cone", h, [] {
        return moved(cone(3e-3, 9e-3), [](const Point &p) {
            return Point{0.5e-3 + p[0], 0.5e-3 - p[1], 0.5e-3 - p[2]};
        });
    });
    Touch up(standing,
             asset("slab", h,
                   [] {
                       return solids::box({-8e-3, 0, -8e-3}, {8e-3, 4e-3, 8e-3});
                   }),
             pair, m);
    m.note(worst_jump(up, m, 95,
                      [](double share) {
                          return pose_at({0, 1e-3 - 0.95e-3 * share, 0});
                      }),
           "slab onto the tip");
}

} // namespace

// The bound: the project's bar, no jump over 5 % from tick to tick. A step of h/100 to a depth of 0.95 h is a
// jump of 1 % where force is linear in depth, 2 % for an edge or a ball, 3 % for a tip.
extern const Case cone_tip{"cone_tip",
                           "a cone's tip into a floor, and a slab onto a cone's tip, by h/100 a step",
                           "jump of the force, of the largest",
                           0.05,
                           all,
                           run};

} // namespace hard
