// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>

namespace hard {
namespace {

void run(const Pair &pair, const Options &, Measured &m)
{
    for (int missed = 1; missed <= 24; ++missed) {
        Loop loop(pair, m);
        vxs_device_arm(loop.device);
        for (int n = 0; n < 1500; ++n) loop.tick({0, n < 100 ? 6e-3 : 4.6e-3, 0});
        const double before = length(loop.command.wrench.force);
        m.must(before > 0.01, "no force to lose");
        double rendered = before;
        for (int n = 0; n < missed; ++n) { // the first hands the last command over, the others bring nothing
            vxs_device_exchange(loop.device, n ? nullptr : &loop.command, &loop.state, &loop.report);
            const double now = length(loop.report.rendered.force);
            m.must(n < 2 || now <= rendered * (1 + 1e-12),
                   "more force without a tick"); // a command is on its way
            rendered = now;
            if (n > 13)
                m.note(now, std::to_string(n) + " samples late"); // two full, ten to decay, one on its way
        }
        const std::uint32_t flags = loop.tick_on(loop.state);
        m.must(missed < 2 || flags & VXS_SERVO_MISSED, "the flag is missing after " + std::to_string(missed));
        const double share = missed > 2 ? std::max(0.0, 1 - (missed - 2) / 10.0) : 1;
        m.must(loop.row.gain <= std::min(1.0, share + 0.002 + 1e-9),
               "the ramp begins above what was felt, after " + std::to_string(missed));
    }
}

} // namespace

extern const Case missed_ticks{"missed_ticks",
                               "1 to 24 ticks that do not come while a floor is pressed: the device lets go, "
                               "the ramp goes on from there",
                               "force after hold, decay and delay [N]",
                               0,
                               all,
                               run};

} // namespace hard
