// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    const Point away{10'000, -10'000 + 3 * h, 10'000 - 7 * h}; // whole cells
    const Asset &here = asset("block", h, [] { return block(); }),
                &moving = asset("ball", h, [] { return ball(); });
    Touch near(here, moving, pair, m), posed(here, moving, pair, m);
    Touch there(asset("far block", h,
                      [&] {
                          return moved(block(), [&](const Point &p) {
                              return Point{p[0] + away[0], p[1] + away[1], p[2] + away[2]};
                          });
                      }),
                moving, pair, m);
    const vxs_pose place = pose_at(away);
    posed.statics.pose = &place;
    Comparison by_pose(m, 5e-3), by_vertices(m, 5e-3);
    for (int n = 0; n <= 100; ++n) {
        const Point p{1e-4 * n, 5.6e-3 - 5e-6 * n, 3e-5 * n};
        const vxs_wrench wrench = near.at(pose_at(p)).wrench;
        const vxs_pose far = pose_at({p[0] + away[0], p[1] + away[1], p[2] + away[2]});
        by_pose.add(wrench, posed.at(far).wrench, "by its pose, step " + std::to_string(n));
        by_vertices.add(wrench, there.at(far).wrench, "by its vertices, step " + std::to_string(n));
    }
}

} // namespace

// The bound: 17 km in double are off by 2e-12 m, of a mean depth of 0.2 h 1e-8; depths and normals of
// channels are rounded to float32, 6e-8 each; force and torque once, in each of the two places.
extern const Case far_away{
    "far_away",
    "a floor and a ball 10 km from the origin on each axis, by pose and by vertices: the same as here",
    "wrench off the one here",
    3e-7,
    all,
    run};

} // namespace hard
