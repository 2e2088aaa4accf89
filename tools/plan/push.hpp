// SPDX-License-Identifier: GPL-3.0-or-later
// A hand that pushes against something, along one line: how far in a coupling on a device lets it come.
#pragma once

#include "voxshell/coupling.h"
#include "voxshell/simulated.h"

#include <vector>

namespace voxshell {

/// All along the line on which the body was moving when it touched, [m] from there on inwards.
struct Push {
    std::vector<double> hand;  ///< where the hand wants to be, one a sample, from before it touches on
    std::vector<double> force; ///< of the contact against the body [N], so many deep: 0, step, 2 step ..
    double step;
    double speed; ///< of the hand when it touches [m/s]
    double wall;  ///< how thick what it pushes against is
    /// A body that is so deep is past the middle of the wall: the nearest way out is on the far side.
    double middle;
};

/// Deepest on the way [m].
struct Stopped {
    double device;
    double body; ///< that feels the contact: with pt2 or none the device itself
};

/// Runs the push on the runtime's own simulated device (with its arm, friction, encoder and peak) and
/// coupling; beyond the last of its forces there is none.
Stopped stop_push(const Push &push, const vxs_simulated_config &device, const vxs_coupling_config &coupling);

/// No coupling stops the device sooner: its peak force from the first sample inside on, until it turns round.
double stop_at_best(const Push &push, const vxs_simulated_config &device);

} // namespace voxshell
