// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    const Asset &slab = asset("slab", h, [] { return solids::box({-8e-3, 0, -8e-3}, {8e-3, 4e-3, 8e-3}); });
    for (const double top : {0.0, 0.25e-3, 0.5e-3, 0.75e-3}) {
        Touch touch(asset("block to " + number(top), h, [&] { return block(top); }), slab, pair, m);
        double onset = NAN;
        for (int n = 100; n >= -100 && std::isnan(onset); --n)
            if (length(touch.at(pose_at({0.3e-3, top + n * 1e-5, 0.2e-3})).wrench.force) > 0)
                onset = n * 1e-5;
        m.must(!std::isnan(onset), "no force within a cell of the top");
        m.note(std::abs(onset) / h, "top at " + number(top) + " m");
    }
}

} // namespace

// The bound: the middle of the surface cells is at most half a cell off the wall; looked for in steps of
// 0.01.
extern const Case grid_planes{"grid_planes",
                              "a floor whose top is a grid plane, or between two: where force begins",
                              "off the top [cells]",
                              0.51,
                              all,
                              run};

} // namespace hard
