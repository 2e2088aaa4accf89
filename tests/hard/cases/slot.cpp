// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

constexpr double wall = 5.5e-3, half = 5.7e-3; // 0.2 mm of interference on either side

void run(const Pair &pair, const Options &, Measured &m)
{
    const std::vector<std::array<double, 2>> chain{{-12e-3, 0.5e-3}, {-wall, 0.5e-3}, {-wall, -9.5e-3},
                                                   {wall, -9.5e-3},  {wall, 0.5e-3},  {12e-3, 0.5e-3}};
    Touch touch(asset("slot", h, [&] { return under(chain, -14e-3, 40e-3); }),
                asset("plate", h,
                      [] {
                          return solids::box({-half, -8e-3, -10e-3}, {half, 10e-3, 10e-3});
                      }),
                pair, m);
    const double foundation = stiffness * 20e-3 * 8.5e-3, most = 0.15e-3;
    for (int n = -30; n <= 30; ++n) {
        const double x = n * most / 30, exact[3] = {-2 * foundation * x, 0, 0};
        m.note(apart(touch.at(pose_at({x, 0, 0})).wrench.force, exact) / (2 * foundation * most),
               "at x = " + number(x));
    }
}

} // namespace

// The bound: the project's bar, within 10 % of the analytic elastic foundation. Claimed with distance only:
// cells do not end where a wall does, its last one reaches half a cell past the rim here (6 % of the wall's
// height), and a point on the plate's edges stands for both faces and pushes with the area of both (12 % more
// than the side has). A law cannot take that back: no point says how much of its area is whose.
extern const Case slot{
    "slot",
    "a plate 0.2 mm too thick on either side, moved sideways in its slot: both walls push at once",
    "force off the elastic foundation's, of the largest",
    0.1,
    keeps_slanted,
    run};

} // namespace hard
