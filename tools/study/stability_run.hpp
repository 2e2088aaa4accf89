// SPDX-License-Identifier: GPL-3.0-or-later
// Where the loop of device, arm, filter and contact begins to oscillate: foretold, and run with the runtime's
// own device, coupling and contact.
#pragma once

#include "cli/progress.hpp"
#include "plan/loop.hpp"

#include <span>
#include <string>
#include <vector>

namespace voxshell {

/// A device in somebody's hand, with a PT2 of damping 1 or (0 Hz) no filter.
struct LoopKey {
    const vxs_simulated_profile *profile;
    const vxs_simulated_arm *arm;
    double hertz;
    vxs_simulated_config device() const;
    vxs_coupling_config coupling() const;
    std::string filter() const; ///< "none", "PT2 5 Hz"
};

/// What swings though it is foretold to calm down, after the minute more too; and what becomes of it, ten
/// seconds and that minute again, without the device's encoder steps, and without its friction [m].
struct OddSwing {
    double stiffness, amplitude, without_steps, without_friction;
};

/// One of them against a spring.
struct LoopMap {
    LoopKey key;
    double largest, hunting, passive, quantisation; ///< foretold (loop.hpp) [N/m]
    Margins margins;                                ///< at the stiffness that the device's makers recommend
    double bandwidth;                               ///< [Hz]
    double found; ///< where small motions begin to grow in the time domain [N/m]
    /// Of the limit cycle at each stiffness, the device as it is: friction, encoder steps, clamp [m]. Let go
    /// kick_way off the spring's middle; over two seconds after eight, or after another minute where it is
    /// foretold to calm down and has not yet.
    std::vector<double> amplitude;
    std::vector<OddSwing> odd; ///< below hunting
    bool oscillates(std::size_t stiffness) const;
};

/// One of them pressed against a floor by the real contact, bounded by most_stiffness: the bound at which
/// small motions begin to grow.
struct ContactOnset {
    LoopKey key;
    std::string body;      ///< "flat", "ball"
    double largest, found; ///< [N/m]
};

/// More than two encoder steps.
bool is_swing(const LoopKey &key, double amplitude);

/// A device in somebody's hand with a quasi-static coupling.
struct SpringMap {
    LoopKey key;
    double designed;        ///< spring that `design` takes for the device in any hand or none [N/m]
    double largest;         ///< K_max of the loop without a filter [N/m]
    double foretold, found; ///< spring at which small motions begin to grow on a contact of 1e6 N/m [N/m]
    std::vector<double> amplitude; ///< as LoopMap's, spring as designed, contacts of 1 to 1e6 N/m [m]
    std::size_t swinging() const;
};

struct StabilityRuns {
    std::vector<double> stiffness; ///< [N/m]
    std::vector<LoopMap> loops;    ///< by device, arm and filter; no filter last
    std::vector<ContactOnset> contacts;
    std::vector<SpringMap> springs; ///< by device and arm
};

inline constexpr double kick_way = 0.005; ///< [m]

/// quick: the paper's two devices, and fewer filters and stiffnesses. The same numbers for any number of
/// threads.
StabilityRuns run_stability(bool quick, Progress &progress);

/// For run_stability().
std::vector<SpringMap> run_springs(std::span<const LoopMap> loops, Progress &progress);
std::vector<ContactOnset> run_contact_onsets(std::span<const LoopMap> loops, bool quick, Progress &progress);

} // namespace voxshell
