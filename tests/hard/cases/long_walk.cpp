// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace hard {
namespace {

std::uint32_t next(std::uint32_t &state)
{
    state ^= state << 13;
    state ^= state >> 17;
    return state ^= state << 5;
}

bool is_denormal(double x)
{
    return std::fpclassify(x) == FP_SUBNORMAL;
}

/// In and out of contact, turning; then free, where all must come to rest. A hash of every row.
std::uint64_t walk(const Pair &pair, long ticks, Measured &m)
{
    Loop loop(pair, m);
    vxs_device_arm(loop.device);
    std::uint64_t hash = 14695981039346656037u;
    std::uint32_t random = 2463534242u;
    Point target{0, 6e-3, 0};
    double q[4] = {1, 0, 0, 0};
    long touched = 0;
    for (long n = 0; n < ticks; ++n) {
        for (int i = 0; i < 3; ++i) {
            target[i] += ((next(random) >> 16) - 32767.5) * 1e-9;
            q[i + 1] = 0.999 * (q[i + 1] + ((next(random) >> 16) - 32767.5) * 1e-7);
        }
        target = {0.9995 * target[0], target[1] + 2e-3 * (5.2e-3 - target[1]), 0.9995 * target[2]};
        const std::uint32_t flags = loop.tick(target, q);
        touched += loop.row.points > 0;
        m.must(!(flags & (VXS_SERVO_FAULT | VXS_SERVO_MISSED | VXS_SERVO_TELEPORT | VXS_SERVO_DEVICE_LOST)),
               "flags " + std::to_string(flags) + " in tick " + std::to_string(n));
        for (int i = 0; i < 3; ++i)
            m.must(!is_denormal(loop.row.output.force[i]) && !is_denormal(loop.row.output.torque[i]),
                   "a denormal number in tick " + std::to_string(n));
        const auto *byte = reinterpret_cast<const unsigned char *>(&loop.row);
        for (std::size_t k = 0; k < sizeof loop.row; ++k) hash = (hash ^ byte[k]) * 1099511628211u;
    }
    m.must(touched > ticks / 20 && touched < ticks, "it touched in " + std::to_string(touched) + " ticks");
    for (int n = 0; n < 4000; ++n) loop.tick({0, 9e-3, 0}, q);
    m.note(length(loop.command.wrench.force) + length(loop.command.wrench.torque) / 5e-3);
    return hash;
}

void run(const Pair &pair, const Options &options, Measured &m)
{
    walk(pair, options.ticks, m);
    const long again = std::min(options.ticks, 20'000L);
    m.must(walk(pair, again, m) == walk(pair, again, m), "another trace when run again");
}

} // namespace

// The bound: (1 + w t) e^(-w t) of the filter's w = 2 pi 5 Hz after t = 4 s, of 1 kN that no collision
// reaches.
extern const Case long_walk{"long_walk",
                            "a random walk in and out of contact (--ticks), then 4 s free: no drift, no "
                            "denormal number, the same bits again",
                            "force left after it [N]",
                            3e-50,
                            all,
                            run};

} // namespace hard
