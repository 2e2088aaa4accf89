// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch touch(asset("block", h, [] { return block(); }), asset("ball", h, [] { return ball(); }), pair, m);
    double least = INFINITY, most = 0, sum = 0;
    constexpr int steps = 600;
    for (int n = 0; n < steps; ++n) {
        const double along = 6e-3 * n / steps - 3e-3;
        const vxs_contact_result &result = touch.at(pose_at({along, 5.1e-3, 0.37 * along}));
        const double size = length(result.wrench.force);
        least = std::min(least, size);
        most = std::max(most, size);
        sum += size / steps;
    }
    m.must(sum > 0, "no force at all");
    m.note(sum > 0 ? (most - least) / sum : 0);
}

} // namespace

// The bound: the project's bar, a ripple of 5 % at most.
extern const Case cell_borders{"cell_borders",
                               "a ball 0.4 h deep slides over six cells of a floor along the grid",
                               "ripple of the force, of its mean",
                               0.05,
                               has_common_normal,
                               run};

} // namespace hard
