// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace hard {
namespace {

constexpr double step = 1e-5; ///< of the way in a tick [m]: 10 mm/s at 1 kHz

/// In at one place, along, out at another, corner by corner.
std::vector<Point> way(bool is_back)
{
    std::vector<Point> corners{
        {-2e-3, 5.8e-3, 1e-3}, {-2e-3, 5.05e-3, 1e-3}, {1.3e-3, 5.05e-3, -0.7e-3}, {1.3e-3, 5.8e-3, -0.7e-3}};
    if (is_back) std::reverse(corners.begin(), corners.end());
    std::vector<Point> out;
    for (std::size_t n = 0; n + 1 < corners.size(); ++n) {
        const Point &a = corners[n], &b = corners[n + 1];
        const int steps = static_cast<int>(std::ceil(apart(a.data(), b.data()) / step));
        for (int k = 0; k < steps; ++k) {
            const double share = static_cast<double>(k) / steps;
            out.push_back(tilted(
                {a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])}));
        }
    }
    return out;
}

/// Leads the device's tip along the way, whatever it commands; the energy that its commands, each held over
/// a sample, gave beyond what they took, at most [J].
double given(const Pair &pair, bool is_back, bool is_guarded, double &bound, Measured &m)
{
    const Asset &floor = asset("tilted block", h, [] { return moved(block(), tilted); });
    const vxs_contact_static statics{&floor.map, nullptr};
    vxs_effect guard;
    vxs_effect_default(VXS_EFFECT_PASSIVITY, &guard);
    guard.as.passivity.most_damping = 1e12; // no cap
    guard.as.passivity.least_speed = 0;
    guard.as.passivity.delay = 0; // a command acts over the sample that follows
    Loop loop(pair, m, [&](vxs_servo_config &config, vxs_simulated_config &) {
        config.statics = &statics;
        config.coupling.kind = VXS_COUPLING_NONE;
        config.effects = &guard;
        config.effect_count = is_guarded;
        config.max_force = 1e9;
    });
    vxs_device_arm(loop.device);
    double taken = 0, least = 0, most_force = 0, most_bend = 0;
    Point before{}, last{};
    int n = 0;
    for (const Point &p : way(is_back)) {
        const double *f = loop.command.wrench.force;
        if (n > 0) taken -= f[0] * (p[0] - last[0]) + f[1] * (p[1] - last[1]) + f[2] * (p[2] - last[2]);
        if (n > 1) {
            const double bend[3] = {p[0] - 2 * last[0] + before[0], p[1] - 2 * last[1] + before[1],
                                    p[2] - 2 * last[2] + before[2]};
            most_bend = std::max(most_bend, length(bend));
        }
        least = std::min(least, taken);
        vxs_device_exchange(loop.device, &loop.command, &loop.state, &loop.report);
        std::copy(p.begin(), p.end(), loop.state.pose.position);
        loop.tick_on(loop.state);
        most_force = std::max(most_force, length(loop.command.wrench.force));
        before = std::exchange(last, p);
        ++n;
    }
    m.must(most_force > 0, "no force on the way");
    bound = most_force * most_bend; // effect.h: F A T^2, without a delay
    return -least;
}

void run(const Pair &pair, const Options &, Measured &m)
{
    for (const bool is_back : {false, true}) {
        double bound, unguarded;
        const double free = given(pair, is_back, false, unguarded, m);
        const double held = given(pair, is_back, true, bound, m);
        m.note(held / bound, (is_back ? "the other way, " : "one way, ") + number(1e6 * held) +
                                 " uJ, without the guard " + number(1e6 * free));
    }
}

} // namespace

// The bound is the guard's own (effect.h): what it cannot know, motion that bends within the sample to come.
extern const Case energy_guarded{
    "energy_guarded",
    "the same path with the passivity guard on, led at 10 mm/s: what the commands give beyond what they took",
    "energy created, of the guard's stated bound",
    1,
    all,
    run};

} // namespace hard
