// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    Touch plain(asset("block", h, [] { return block(); }), asset("ball", h, [] { return ball(); }), pair, m);
    for (const int power : {-14, 15}) { // the ball is 0.6 um or 330 m wide
        const double s = std::exp2(power);
        const std::string name = " times 2^" + std::to_string(power);
        Touch other(asset("block" + name, s * h, [&] { return scaled(block(), s); }),
                    asset("ball" + name, s * h, [&] { return scaled(ball(), s); }), pair, m);
        Comparison same(m, 5e-3);
        for (int n = 0; n <= 100; ++n) {
            const Point p{1e-4 * n, 5.6e-3 - 5e-6 * n, 3e-5 * n};
            vxs_wrench wrench = other.at(pose_at({s * p[0], s * p[1], s * p[2]})).wrench;
            for (double &f : wrench.force) f /= s * s * s;
            for (double &t : wrench.torque) t /= s * s * s * s;
            same.add(plain.at(pose_at(p)).wrench, wrench, name + ", step " + std::to_string(n));
        }
    }
}

} // namespace

// The bound: a power of two changes exponents only, of every number on the way.
extern const Case any_scale{
    "any_scale",
    "a block of 2.4 um and one of 1.3 km, scaled by a power of two: the same wrench, scaled",
    "wrench off the scaled one",
    0,
    all,
    run};

} // namespace hard
