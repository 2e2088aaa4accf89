// SPDX-License-Identifier: GPL-3.0-or-later
// The virtual coupling for a device, a range of arms and a contact stiffness: what is stable, by how much,
// and which filter is the fastest that is stable enough.
#pragma once

#include "plan/loop.hpp"
#include "plan/push.hpp"

#include <optional>
#include <string>
#include <vector>

namespace voxshell {

/// What an automatic design leaves: the stiffness may double, and one more sample of delay is borne (that is
/// the phase margin asked for: the crossover's angle w T).
constexpr double least_gain_db = 6;
constexpr double least_delay_samples = 1;
/// And no filter slower than a hand moves (people act at 2 to 10 Hz) is taken for a coupling.
constexpr double least_bandwidth_hz = 2;

struct DesignInput {
    vxs_simulated_config device;     ///< its arm is not looked at
    std::vector<std::string> assume; ///< arms that must hold; empty: all of free, pen, hand and arm
    double stiffness = 0;            ///< largest of the contact [N/m]
    vxs_coupling_config coupling;    ///< kind none, pt2 or quasi-static; sample_time is set from the device
    bool automatic = false;          ///< pt2: pick omega0 and damping; quasi-static: pick stiffness
    /// Pick the kind as well, pt2 or quasi-static: pt2 if its margins hold and every push of the arms that
    /// count ends before the wall's middle.
    bool any_kind = false;
    std::vector<Push> pushes; ///< along which the hand comes in; none: not known
};

/// The push that comes nearest to the far side, with the arm that pushes so far.
struct PushDesign {
    double speed, wall, middle; ///< of the Push
    std::string arm;
    Stopped stopped;
    double at_best; ///< the device, with its peak force at once [m]
    bool holds() const { return stopped.body < middle; }
};

struct ArmDesign {
    std::string arm;
    bool counts;              ///< is in the range that must hold
    double largest_stiffness; ///< K_max [N/m] that the device may feel
    double hunting_stiffness; ///< [N/m], at most that: from here on friction can keep it moving
    double passive_stiffness; ///< [N/m]
    double damping_missing;   ///< to be passive at this stiffness [N s/m], 0 where it is
    Margins margins;          ///< gain: of the lower of these two; phase and delay: without friction
    bool stable() const { return margins.gain_db > 0; }
    bool passive() const { return damping_missing <= 0; }
};

struct Design {
    DesignInput input;
    vxs_coupling_config coupling; ///< as given, or picked
    double seen;                  ///< stiffness that the device feels [N/m]
    double bandwidth_hz;          ///< of the force, -3 dB
    std::vector<ArmDesign> arms;  ///< free, pen, hand, arm
    Margins worst;                ///< of the arms that count
    bool margins_held;            ///< of the arms that count: least_gain_db and least_delay_samples
    bool refused;                 ///< unstable or hunting with an arm that counts
    double quantisation;          ///< [N/m], quantisation_limit()
    struct Unfiltered { ///< the free device without any filter: what no filter of this form can better
        double passive_stiffness; ///< [N/m]
        double damping_missing;   ///< [N s/m]; 0: some filter of this form is passive
        double rate_needed;       ///< to be passive at the device's own damping [Hz]
    } unfiltered;
    std::optional<PushDesign> push;  ///< where pushes were given
    std::string chosen;              ///< with any_kind: why this kind
    std::vector<std::string> advice; ///< sentences: what does not hold, and what would make it hold
};

/// Throws Failure: usage (an arm or a stiffness that is none), unsupported (a kind that has no linear model
/// here: spring-damper), invalid (a coupling that the rate does not carry).
Design design_coupling(const DesignInput &input);

} // namespace voxshell
