// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace hard {
namespace {

constexpr double play = 0.1e-3, wall = 5.5e-3, height = 24e-3;

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch touch(
        asset("frame", h, [] { return frame(12e-3, wall, height); }),
        asset("peg", h,
              [] {
                  return solids::box({play - wall, -20e-3, play - wall}, {wall - play, 20e-3, wall - play});
              }),
        pair, m);
    const double foundation = stiffness * 2 * (wall - play) * height, deepest = 0.4e-3;
    for (int way = 0; way < 2; ++way)
        for (int n = -50; n <= 50; ++n) {
            const double x = n * 1e-5, z = way ? 0.6 * x : 0;
            const auto push = [&](double offset) {
                return -std::copysign(foundation * std::max(0.0, std::abs(offset) - play), offset);
            };
            const double exact[3] = {push(x), 0, push(z)};
            m.note(apart(touch.at(pose_at({x, 0, z})).wrench.force, exact) / (foundation * deepest),
                   "at x = " + number(x));
        }
}

} // namespace

// The bound: the project's bar, within 10 % of the analytic elastic foundation. With surface no claim: a
// corner of the peg is one point for two faces and pushes once, aslant, with the area of both and the depth
// that the layer has along that slant; and a wall's cells reach up to a cell past its rim (4 % here).
extern const Case peg_in_hole{
    "peg_in_hole",
    "a square peg with 0.1 mm of play, moved sideways in its hole: walls opposed to each other",
    "force off the elastic foundation's, of the largest",
    0.1,
    [](const Pair &pair) { return keeps_opposed(pair) && !reads_surface(pair); },
    run};

} // namespace hard
