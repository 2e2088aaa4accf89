// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/stability_run.hpp"

#include "plan/time_domain.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace voxshell {
namespace {

constexpr double settle_seconds = 8, look_seconds = 2, patience_seconds = 60, onset_tolerance = 0.01,
                 onset_width = 1.3, onset_periods = 40;
constexpr double calm_steps = 2; ///< an encoder's own rounding moves what hangs on it by about one

constexpr double all_filters[] = {2, 5, 10, 20, 50, 100, 200, 0}, few_filters[] = {5, 10, 20, 50, 100, 0};
constexpr std::string_view few_devices[] = {"phantom-premium-1.5", "dlr-lwr"};

std::vector<LoopKey> keys_of(bool quick)
{
    std::vector<LoopKey> keys;
    for (std::uint32_t p = 0; const auto *profile = vxs_simulated_profile_at(p); ++p) {
        if (quick && std::ranges::find(few_devices, profile->name) == std::end(few_devices)) continue;
        for (std::uint32_t a = 0; const auto *arm = vxs_simulated_arm_at(a); ++a) {
            for (const double hertz :
                 quick ? std::span<const double>(few_filters) : std::span<const double>(all_filters))
                keys.push_back({profile, arm, hertz});
        }
    }
    return keys;
}

LoopMap run_loop(const LoopKey &key, const std::vector<double> &stiffness, Progress &progress)
{
    const vxs_simulated_config device = key.device();
    const vxs_coupling_config coupling = key.coupling();
    const Loop loop(device, coupling);
    LoopMap map{key,
                loop.largest_stiffness(),
                hunting_stiffness(device, coupling),
                loop.passive_stiffness(),
                quantisation_limit(device),
                loop.margins(key.profile->max_stiffness),
                loop.bandwidth_hz(),
                0,
                {},
                {}};
    const long ticks = ticks_of_onset(loop, map.largest, onset_periods);
    map.found = onset(map.largest, onset_width, onset_tolerance, [&](double k) {
        progress.check();
        return growth(device, coupling, k, ticks) > 0;
    });
    const auto in = [&](double seconds) { return std::lround(seconds / device.sample_time); };
    for (const double k : stiffness) {
        progress.check();
        TimeDomain real(device, coupling, kick_way);
        real.run(k, in(settle_seconds));
        map.amplitude.push_back(real.run(k, in(look_seconds)).amplitude());
        if (k < map.largest && map.oscillates(map.amplitude.size() - 1)) {
            real.run(k, in(patience_seconds));
            map.amplitude.back() = real.run(k, in(look_seconds)).amplitude();
            if (k < map.hunting && map.oscillates(map.amplitude.size() - 1)) {
                const auto without = [&](double vxs_simulated_profile::*what) {
                    progress.check();
                    vxs_simulated_config other = device;
                    other.profile.*what = 0;
                    TimeDomain changed(other, coupling, kick_way);
                    changed.run(k, in(settle_seconds + look_seconds + patience_seconds));
                    return changed.run(k, in(look_seconds)).amplitude();
                };
                map.odd.push_back({k, map.amplitude.back(), without(&vxs_simulated_profile::resolution),
                                   without(&vxs_simulated_profile::friction)});
            }
        }
    }
    return map;
}

} // namespace

vxs_simulated_config LoopKey::device() const
{
    vxs_simulated_config config;
    vxs_simulated_config_default(&config, profile);
    config.arm = *arm;
    return config;
}

vxs_coupling_config LoopKey::coupling() const
{
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = hertz > 0 ? VXS_COUPLING_PT2 : VXS_COUPLING_NONE;
    config.omega0 = 2 * std::numbers::pi * hertz;
    config.damping = 1;
    config.sample_time = device().sample_time;
    return config;
}

std::string LoopKey::filter() const
{
    return hertz > 0 ? fmt::format("PT2 {:g} Hz", hertz) : "none";
}

bool is_swing(const LoopKey &key, double amplitude)
{
    return amplitude > calm_steps * key.profile->resolution;
}

bool LoopMap::oscillates(std::size_t stiffness) const
{
    return is_swing(key, amplitude[stiffness]);
}

StabilityRuns run_stability(bool quick, Progress &progress)
{
    StabilityRuns runs;
    const int steps = quick ? 2 : 4; // a decade
    for (int n = 0; n <= 5 * steps; ++n)
        runs.stiffness.push_back(std::pow(10.0, static_cast<double>(n) / steps));
    const std::vector<LoopKey> keys = keys_of(quick);
    runs.loops.resize(keys.size());
    progress.stage("loops", keys.size());
    tbb::parallel_for(std::size_t{0}, keys.size(), [&](std::size_t n) {
        runs.loops[n] = run_loop(keys[n], runs.stiffness, progress);
        progress.advance(1);
    });
    runs.springs = run_springs(runs.loops, progress);
    runs.contacts = run_contact_onsets(runs.loops, quick, progress);
    return runs;
}

} // namespace voxshell
