// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch touch(asset("block", h, [] { return block(); }),
                asset("blunt cone", h,
                      [] {
                          return cone(3e-3, 4e-3, {0.5e-3, 0.5e-3, 0.5e-3});
                      }),
                pair, m);
    bool is_seen = false;
    for (int n = 0; n <= 150; ++n) {
        const double y = 0.5e-3 - 1e-5 * n;
        const vxs_contact_result &result = touch.at(pose_at({0.3e-3, y, 0.2e-3}));
        const double size = length(result.wrench.force);
        if (result.points != 1 || size == 0) continue;
        is_seen = true;
        m.note(180 / std::numbers::pi * std::acos(std::min(1.0, result.wrench.force[1] / size)),
               "at y = " + number(y));
    }
    m.must(is_seen, "one point alone never gave a force");
}

} // namespace

// The bound: normals are float32; a distance channel of 4 cells has steps of 4/32767 h, over a cell on either
// side the gradient leans by at most two of them.
extern const Case one_point{"one_point",
                            "the tip of a cone on a floor, as long as one point touches",
                            "force off the vertical [degrees]",
                            180 / std::numbers::pi * 2 * 4 / 32767,
                            all,
                            run};

} // namespace hard
