// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch touch(asset("hollow box", h,
                      [] {
                          return solids::join(solids::box({-15e-3, -15e-3, -15e-3}, {15e-3, 15e-3, 15e-3}),
                                              solids::turned_inside_out(
                                                  solids::box({-9e-3, -9e-3, -9e-3}, {9e-3, 9e-3, 9e-3})));
                      }),
                asset("ball", h, [] { return ball(); }), pair, m);
    for (const Point &place : {Point{0, 0, 0},
                               {2.5e-3, -2.5e-3, 1e-3},
                               {0, 25e-3, 0},
                               {21.5e-3, 21.5e-3, 0},
                               {1e3, -1e3, 1e3},
                               {1e12, 0, 0}}) {
        const vxs_contact_result &result = touch.at(pose_at(place));
        m.must(result.points == 0 && result.deep_points == 0, "touched at " + number(place[0]));
        m.note(length(result.wrench.force) + length(result.wrench.torque), "at x = " + number(place[0]));
    }
}

} // namespace

extern const Case no_point{"no_point",
                           "in a cavity, beside the part, a kilometre and a million kilometres away",
                           "force and torque [N, N m]",
                           0,
                           all,
                           run};

} // namespace hard
