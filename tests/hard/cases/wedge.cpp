// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    const std::vector<std::array<double, 2>> groove{
        {-12e-3, 8.5e-3}, {-8e-3, 8.5e-3}, {0, 0.5e-3}, {8e-3, 8.5e-3}, {12e-3, 8.5e-3}},
        edge{{-5e-3, -5e-3}, {0, 0}, {5e-3, -5e-3}};
    Touch touch(asset("groove", h, [&] { return under(groove, -6e-3, 40e-3); }),
                asset("wedge", h,
                      [&] {
                          return moved(under(edge, -8e-3, 20e-3), [](const Point &p) {
                              return Point{-p[0], -p[1], p[2]};
                          });
                      }),
                pair, m);
    const double face = stiffness * 5e-3 * std::sqrt(2.0) * 20e-3, most = 0.4e-3;
    for (int n = -20; n <= 20; ++n) {
        const double x = n * 0.5e-5,
                     down = most - std::abs(n) * 1e-5; // deeper on one side, then on the other
        const double left = face * (down - x) / 2, right = face * (down + x) / 2,
                     exact[3] = {left - right, left + right, 0};
        m.note(apart(touch.at(pose_at({x, 0.5e-3 - down, 0})).wrench.force, exact) / (face * most),
               "at x = " + number(x));
    }
}

} // namespace

// The bound: the project's bar, within 10 % of the analytic elastic foundation. The gradient's direction
// turns from one face's to the other's within a cell of the valley, that is for one in seven of the wedge's
// points: no claim.
extern const Case wedge{"wedge",
                        "a right-angled wedge in its groove, deeper on one side than on the other",
                        "force off the elastic foundation's, of the largest",
                        0.1,
                        [](const Pair &pair) { return keeps_slanted(pair) && !is_conservative(pair); },
                        run};

} // namespace hard
