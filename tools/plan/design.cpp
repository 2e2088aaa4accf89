// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/design.hpp"

#include "cli/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace voxshell {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double two_pi = 2 * std::numbers::pi;
/// No candidate has a resonance of its own: from 1/sqrt(2) on the filter's response falls throughout.
constexpr double dampings[] = {std::numbers::sqrt2 / 2, 0.8, 1, 1.4, 2};

bool counts(const DesignInput &input, const std::string &arm)
{
    return input.assume.empty() ||
           std::find(input.assume.begin(), input.assume.end(), arm) != input.assume.end();
}

/// The device in each arm that there is, or in those that count.
std::vector<vxs_simulated_config> held(const DesignInput &input, bool all)
{
    std::vector<vxs_simulated_config> out;
    for (std::uint32_t n = 0; const auto *arm = vxs_simulated_arm_at(n); ++n) {
        if (all || counts(input, arm->name)) {
            out.push_back(input.device);
            out.back().arm = *arm;
        }
    }
    return out;
}

double decibels(double ratio)
{
    return 20 * std::log10(ratio);
}

bool holds(const Margins &margins, double sample_time)
{
    return margins.gain_db >= least_gain_db && margins.delay_s >= least_delay_samples * sample_time;
}

/// The least of each over the arms that count, without friction.
Margins worst_of(const DesignInput &input, const vxs_coupling_config &coupling)
{
    Margins worst{infinity, infinity, infinity};
    for (const vxs_simulated_config &device : held(input, false)) {
        const Margins m = Loop(device, coupling).margins(seen_stiffness(coupling, input.stiffness));
        worst.gain_db = std::min(worst.gain_db, m.gain_db);
        worst.phase_deg = std::min(worst.phase_deg, m.phase_deg);
        worst.delay_s = m.delay_s < worst.delay_s || std::isnan(m.delay_s) ? m.delay_s : worst.delay_s;
    }
    return worst;
}

/// The gain that is left until friction keeps it hunting, with the arms that count.
double hunting_gain_db(const DesignInput &input, const vxs_coupling_config &coupling)
{
    double least = infinity;
    for (const vxs_simulated_config &device : held(input, false)) {
        least = std::min(least, hunting_stiffness(device, coupling));
    }
    return decibels(least / seen_stiffness(coupling, input.stiffness));
}

/// The filter of the highest force bandwidth whose margins hold; if none does, the one with the largest gain
/// margin.
vxs_coupling_config fastest_filter(const DesignInput &input)
{
    const double rate = 1 / input.device.sample_time;
    vxs_coupling_config best = input.coupling, least_bad = input.coupling;
    double best_bandwidth = -1, least_bad_gain = -infinity;
    for (double hertz = VXS_COUPLING_MAX_RATE * rate; hertz >= least_bandwidth_hz; hertz /= 1.12) {
        // A lower corner is no better: the fastest candidate of this one is its least damped.
        if (best_bandwidth > 0 && hertz < best_bandwidth) break;
        for (const double damping : dampings) {
            vxs_coupling_config candidate = input.coupling;
            candidate.omega0 = two_pi * hertz;
            candidate.damping = damping;
            const double bandwidth = Loop(input.device, candidate).bandwidth_hz();
            if (bandwidth < least_bandwidth_hz || bandwidth <= best_bandwidth) continue;
            Margins m = worst_of(input, candidate);
            if (m.gain_db > std::min(least_gain_db, least_bad_gain)) {
                m.gain_db = std::min(m.gain_db, hunting_gain_db(input, candidate));
            }
            if (holds(m, input.device.sample_time)) {
                best = candidate;
                best_bandwidth = bandwidth;
            }
            if (m.gain_db > least_bad_gain) {
                least_bad = candidate;
                least_bad_gain = m.gain_db;
            }
        }
    }
    return best_bandwidth > 0 ? best : least_bad;
}

/// The stiffest spring that the loop carries with the margins alone, whatever the contact, within what the
/// device's makers recommend.
double stiffest_spring(const DesignInput &input)
{
    vxs_coupling_config spring = input.coupling;
    double most = infinity;
    for (const vxs_simulated_config &device : held(input, false)) {
        most = std::min(most, hunting_stiffness(device, spring));
    }
    most *= std::pow(10, -least_gain_db / 20);
    const double recommended = input.device.profile.max_stiffness;
    most = recommended > 0 ? std::min(most, recommended) : most;
    DesignInput hard = input;
    hard.stiffness = infinity;
    for (int n = 0; n < 60; ++n, most *= 0.97) {
        spring.stiffness = most;
        if (holds(worst_of(hard, spring), input.device.sample_time)) break;
    }
    return most;
}

std::optional<PushDesign> worst_push(const DesignInput &input, const vxs_coupling_config &coupling)
{
    std::optional<PushDesign> worst;
    for (const Push &push : input.pushes) {
        for (const vxs_simulated_config &device : held(input, false)) {
            const PushDesign found{push.speed,
                                   push.wall,
                                   push.middle,
                                   device.arm.name,
                                   stop_push(push, device, coupling),
                                   stop_at_best(push, device)};
            if (!worst || found.stopped.body * worst->middle > worst->stopped.body * found.middle)
                worst = found;
        }
    }
    return worst;
}

void check(const DesignInput &input)
{
    if (!(input.stiffness > 0) || !std::isfinite(input.stiffness)) {
        throw Failure(ExitCode::usage, "", "the contact's stiffness must be above zero");
    }
    for (const std::string &arm : input.assume) {
        if (!vxs_simulated_arm_named(arm.c_str())) {
            throw Failure(ExitCode::usage, "", "no arm '" + arm + "'; there are free, pen, hand and arm");
        }
    }
    const std::uint32_t kind = input.coupling.kind;
    if (kind != VXS_COUPLING_NONE && kind != VXS_COUPLING_PT2 && kind != VXS_COUPLING_QUASI_STATIC) {
        const char *name = vxs_coupling_kind_name(kind);
        throw Failure(
            ExitCode::unsupported, "",
            fmt::format("coupling {} has no design: none, pt2 and quasi-static have", name ? name : "?"));
    }
}

std::string article(const std::string &arm)
{
    return (arm == "arm" ? "an " : "a ") + arm;
}

std::string newtons(double stiffness)
{
    return std::isinf(stiffness) ? "any stiffness" : fmt::format("{:.4g} N/m", stiffness);
}

std::vector<std::string> advice_of(const Design &d)
{
    std::vector<std::string> out;
    const double rate = 1 / d.input.device.sample_time;
    for (const ArmDesign &arm : d.arms) {
        if (!arm.stable()) {
            const bool hunts = arm.largest_stiffness > d.seen;
            out.push_back(fmt::format("{} {}: carries {}, is to carry {}{}",
                                      hunts ? "stable, but friction can keep it hunting," : "unstable",
                                      arm.arm == "free" ? "with the hand off" : "with " + article(arm.arm),
                                      newtons(hunts ? arm.hunting_stiffness : arm.largest_stiffness),
                                      newtons(d.seen), arm.counts ? "" : " (not assumed)"));
        }
    }
    if (!d.refused && !d.margins_held) {
        out.push_back(fmt::format("stable, but with less than {} dB or less than {} sample of delay to spare",
                                  least_gain_db, least_delay_samples));
    }
    const ArmDesign &free = d.arms.front();
    if (!free.passive()) {
        if (d.unfiltered.damping_missing > 0) {
            out.push_back(fmt::format(
                "no filter of this form is passive with the hand off: even none at all is so only up to {}",
                newtons(d.unfiltered.passive_stiffness)));
            out.push_back(fmt::format(
                "passive would be: {:.3g} N s/m more damping in the device, and no filter ({:.3g} with this "
                "one); or {:.4g} kHz and no filter; "
                "or contact up to {} (with this filter {}); or the passivity controller",
                d.unfiltered.damping_missing, free.damping_missing, d.unfiltered.rate_needed / 1e3,
                newtons(d.unfiltered.passive_stiffness), newtons(free.passive_stiffness)));
        } else {
            out.push_back(fmt::format("not passive with the hand off: {:.3g} N s/m more damping, contact up "
                                      "to {}, a faster filter, "
                                      "or the passivity controller would make it so",
                                      free.damping_missing, newtons(free.passive_stiffness)));
        }
    }
    if (d.seen > d.quantisation) {
        out.push_back(fmt::format(
            "beyond the quantisation limit of {}: steps of {:.3g} um at {:.4g} Hz can keep it humming",
            newtons(d.quantisation), 1e6 * d.input.device.profile.resolution, rate));
    }
    if (d.push && !d.push->holds()) {
        out.push_back(fmt::format("a push as on the hand's path goes through: what feels contact comes "
                                  "{:.2g} mm in, past the middle of the {:.2g} mm that stand in its way{}",
                                  1e3 * d.push->stopped.body, 1e3 * d.push->wall,
                                  d.coupling.kind == VXS_COUPLING_QUASI_STATIC
                                      ? "; stiffen the contact"
                                      : "; quasi-static may hold it"));
    }
    const double recommended = d.input.device.profile.max_stiffness;
    if (recommended > 0 && d.seen > recommended) {
        out.push_back(
            fmt::format("stiffer than the {} that is recommended for the device", newtons(recommended)));
    }
    return out;
}

Design design_of_kind(const DesignInput &given)
{
    check(given);
    Design d;
    d.input = given;
    d.input.coupling.sample_time = given.device.sample_time;
    d.coupling = d.input.coupling;
    if (given.automatic && d.coupling.kind == VXS_COUPLING_PT2) {
        d.coupling = fastest_filter(d.input);
    } else if (given.automatic && d.coupling.kind == VXS_COUPLING_QUASI_STATIC) {
        d.coupling.stiffness = stiffest_spring(d.input);
    }
    if (const vxs_result result = vxs_coupling_config_check(&d.coupling); result != VXS_OK) {
        throw Failure(ExitCode::invalid, "", std::string("coupling: ") + vxs_result_text(result));
    }
    d.seen = seen_stiffness(d.coupling, given.stiffness);
    d.worst = worst_of(d.input, d.coupling);
    for (const vxs_simulated_config &device : held(d.input, true)) {
        const Loop loop(device, d.coupling);
        ArmDesign arm{
            device.arm.name,          counts(d.input, device.arm.name),
            loop.largest_stiffness(), hunting_stiffness(device, d.coupling),
            loop.passive_stiffness(), std::max(0.0, loop.damping_to_be_passive(d.seen) - loop.viscosity()),
            loop.margins(d.seen)};
        arm.margins.gain_db = decibels(arm.hunting_stiffness / d.seen);
        d.worst.gain_db = arm.counts ? std::min(d.worst.gain_db, arm.margins.gain_db) : d.worst.gain_db;
        d.bandwidth_hz = loop.bandwidth_hz();
        d.arms.push_back(arm);
    }
    d.refused = !(d.worst.gain_db > 0);
    d.margins_held = holds(d.worst, given.device.sample_time);
    d.quantisation = quantisation_limit(given.device);

    vxs_coupling_config none = d.coupling;
    none.kind = VXS_COUPLING_NONE;
    const Loop unfiltered(held(d.input, true).front(), none);
    const double needed = unfiltered.damping_to_be_passive(d.seen);
    d.unfiltered = {unfiltered.passive_stiffness(), std::max(0.0, needed - unfiltered.viscosity()),
                    needed / unfiltered.viscosity() /
                        given.device.sample_time}; // damping needed is in samples
    d.push = worst_push(d.input, d.coupling);
    d.advice = advice_of(d);
    return d;
}

std::string push_text(const PushDesign &push)
{
    return fmt::format("a push at {:.3g} m/s into {:.2g} mm", push.speed, 1e3 * push.wall);
}

/// Why not pt2; empty if nothing speaks against it.
std::string against_pt2(const Design &d)
{
    if (d.refused) {
        return "no pt2 is stable with contact of " + newtons(d.input.stiffness);
    }
    if (!d.margins_held) {
        return fmt::format("no pt2 leaves {} dB and {} sample of delay", least_gain_db, least_delay_samples);
    }
    if (!d.push) {
        return "nothing is known of what pt2 would have to stop";
    }
    return d.push->holds() ? ""
                           : fmt::format("with pt2 {} comes {:.2g} mm in", push_text(*d.push),
                                         1e3 * d.push->stopped.body);
}

} // namespace

Design design_coupling(const DesignInput &given)
{
    if (!given.any_kind) return design_of_kind(given);
    DesignInput input = given;
    input.automatic = true;
    input.coupling.kind = VXS_COUPLING_PT2;
    Design shaped = design_of_kind(input);
    const std::string against = against_pt2(shaped);
    if (against.empty()) {
        shaped.chosen = fmt::format("pt2, since it stops {} after {:.2g} mm", push_text(*shaped.push),
                                    1e3 * shaped.push->stopped.body);
        return shaped;
    }
    input.coupling.kind = VXS_COUPLING_QUASI_STATIC;
    Design still = design_of_kind(input);
    still.chosen = "quasi-static, since " + against;
    return still;
}

} // namespace voxshell
