// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    const Asset &floor = asset("block", h, [] { return block(); });
    const double reach =
        std::sqrt(3.0) * (pair.field == 1 ? h / 2 : 4.5 * h); // no point is deeper in its field
    const auto look = [&](const Asset &moving, double y) {
        Touch touch(floor, moving, pair, m);
        const vxs_contact_result &result = touch.at(pose_at({0.1e-3, y, 0.2e-3}));
        m.must(result.points + result.deep_points >= moving.shell.point_count, "not all points inside");
        m.note(length(result.wrench.force) / (stiffness * moving.area * reach), "at y = " + number(y));
    };
    look(asset("leaf", h, [] { return solids::box({-5e-3, -0.1e-3, -5e-3}, {5e-3, 0.1e-3, 5e-3}); }), 0.3e-3);
    look(asset("small ball", h, [] { return ball(1.6e-3); }), -3.5e-3);
}

} // namespace

// The bound: by definition, no point pushes from deeper than its field reaches.
extern const Case all_points{
    "all_points",
    "a leaf within one layer of cells, and a ball deep inside a block: every point collides or is deep",
    "force, of stiffness x area x the field's reach",
    1,
    all,
    run};

} // namespace hard
