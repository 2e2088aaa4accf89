// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    const std::vector<std::array<double, 2>> chain{{-1.25e-3, -9e-3}, {-0.5e-3, -0.5e-3}, {0.25e-3, -9e-3}};
    const Asset &floor = asset("block", h, [] { return block(); }), &knife = asset("knife", h, [&] {
        return moved(under(chain, -10e-3, 20e-3), [](const Point &p) { return Point{-p[0], -p[1], p[2]}; });
    });
    Touch down(floor, knife, pair, m);
    m.note(worst_jump(down, m, 95,
                      [](double share) {
                          return pose_at({-0.3e-3, 0.5e-3 - 0.95e-3 * share, 0});
                      }),
           "edge down");
    Touch askew(floor, knife, pair, m);
    m.note(worst_jump(askew, m, 95,
                      [](double share) {
                          return turned({-0.3e-3, 0.5e-3 - 0.95e-3 * share, 0}, {1, 0.3, 2}, 0.3);
                      }),
           "askew");
}

} // namespace

// The bound: the project's bar, no jump over 5 % from tick to tick. A step of h/100 to a depth of 0.95 h is a
// jump of 1 % where force is linear in depth, 2 % for an edge or a ball, 3 % for a tip.
extern const Case knife_edge{"knife_edge",
                             "a knife of 10 degrees into a floor, by h/100 a step, edge down and askew",
                             "jump of the force, of the largest",
                             0.05,
                             keeps_slanted,
                             run};

} // namespace hard
