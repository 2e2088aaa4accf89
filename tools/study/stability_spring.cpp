// SPDX-License-Identifier: GPL-3.0-or-later
// The quasi-static coupling in the map: what hangs on a spring is felt no stiffer than the spring, so that
// not the contact but the spring ends the loop's stability.
#include "plan/design.hpp"
#include "plan/time_domain.hpp"
#include "study/stability_run.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr double hard_contact = 1e6; ///< [N/m]: above every spring that is looked for
constexpr double settle_seconds = 8, look_seconds = 2, width = 1.3, tolerance = 0.01, periods = 40;
constexpr double contacts[] = {1, 10, 100, 1e3, 1e4, 1e5, 1e6}; ///< [N/m]

vxs_coupling_config hung(const LoopKey &key, double spring)
{
    vxs_coupling_config config = key.coupling();
    config.kind = VXS_COUPLING_QUASI_STATIC;
    config.stiffness = spring;
    return config;
}

SpringMap run_spring(const LoopKey &key, double designed, Progress &progress)
{
    const vxs_simulated_config device = key.device();
    const Loop loop(device, key.coupling());
    SpringMap map{key, designed, loop.largest_stiffness(), 0, 0, {}};
    map.foretold = 1 / (1 / map.largest - 1 / hard_contact);
    const long ticks = ticks_of_onset(loop, map.largest, periods);
    map.found = onset(map.foretold, width, tolerance, [&](double spring) {
        progress.check();
        return growth(device, hung(key, spring), hard_contact, ticks) > 0;
    });
    for (const double k : contacts) {
        progress.check();
        TimeDomain real(device, hung(key, designed), kick_way);
        real.run(k, std::lround(settle_seconds / device.sample_time));
        map.amplitude.push_back(real.run(k, std::lround(look_seconds / device.sample_time)).amplitude());
    }
    return map;
}

} // namespace

std::size_t SpringMap::swinging() const
{
    return static_cast<std::size_t>(
        std::count_if(amplitude.begin(), amplitude.end(), [&](double a) { return is_swing(key, a); }));
}

std::vector<SpringMap> run_springs(std::span<const LoopMap> loops, Progress &progress)
{
    std::vector<LoopKey> keys;
    for (const LoopMap &map : loops) {
        if (map.key.hertz == 0) keys.push_back(map.key);
    }
    std::vector<SpringMap> springs(keys.size());
    progress.stage("springs", keys.size());
    tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t n) {
        DesignInput input;
        input.device = keys[n].device();
        input.stiffness = hard_contact;
        input.coupling = hung(keys[n], 1);
        input.automatic = true;
        springs[n] = run_spring(keys[n], design_coupling(input).coupling.stiffness, progress);
        progress.advance(1);
    });
    return springs;
}

} // namespace voxshell
