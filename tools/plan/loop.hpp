// SPDX-License-Identifier: GPL-3.0-or-later
// One axis of the haptic loop, sampled, exactly as the simulated device and the coupling run it: the device's
// mass, viscosity and arm in their implicit substeps under a zero-order hold, delay_samples, the contact as a
// spring K, the coupling's biquad. Encoder steps, friction, slew limit and clamp are left out: what is said
// holds for small motions that are larger than an encoder's step.
//
//     x(k+1) = A x(k) + B c(k - delay),   c(k) = -K H x(k),   L(z) = K C (z - A)^-1 B H(z) z^-delay
//
// Sources: Colgate and Schenkel 1997 (passivity of a sampled wall: b > T/2 / (1 - cos wT) Re{(1 - e^-jwT) K H
// e^-jwD} for all w below half the rate), Abbott and Okamura 2005 (quantisation).
#pragma once

#include "voxshell/coupling.h"
#include "voxshell/simulated.h"

#include <complex>

namespace voxshell {

/// How far a stable loop is from the end of its stability. Infinity where nothing ends it.
struct Margins {
    double gain_db;   ///< the stiffness may grow by so much; below 0: unstable
    double phase_deg; ///< at the worst of the frequencies at which the loop gain is 1
    double delay_s;   ///< that the loop bears on top of what it has; NaN if unstable
};

class Loop {
  public:
    /// device: profile, arm, sample_time, delay_samples and substeps count. coupling: none, pt2, or
    /// quasi-static (in balance it is none at the stiffness that the spring leaves: see seen_stiffness()).
    /// Its sample time is the device's.
    Loop(const vxs_simulated_config &device, const vxs_coupling_config &coupling);

    /// Loop gain per contact stiffness [m/N] at the angle w T, 0 < angle <= pi.
    std::complex<double> gain(double angle) const;
    /// The coupling alone: force out per force in.
    std::complex<double> filter(double angle) const;
    /// Damping that the device and the arm must have at this frequency to be passive, per contact stiffness
    /// [s].
    double damping_needed(double angle) const;
    /// Driving-point impedance at the tip with a contact of this stiffness, base band [N s/m].
    std::complex<double> impedance(double angle, double stiffness) const;

    double largest_stiffness() const; ///< K_max [N/m]: stable below; infinity if nothing ends it
    double passive_stiffness() const; ///< [N/m]: passive below, with device and arm damping
    double damping_to_be_passive(double stiffness) const; ///< [N s/m] of device and arm together
    Margins margins(double stiffness) const;
    double bandwidth_hz() const; ///< of the coupling, -3 dB; half the rate if it never falls so low
    double viscosity() const { return viscosity_; } ///< of device and arm [N s/m]
    double sample_time() const { return sample_time_; }

  private:
    double sample_time_, mass_, viscosity_, stiffness_;
    unsigned delay_;
    double motion_[2][2]{};            ///< A - 1 on (velocity, position): keeps its digits at low frequencies
    double push_[2]{};                 ///< B
    double g_, damping_, filter_gain_; ///< of the PT2: half a sample of w0 (pre-warped); g_ = 0: no filter
};

/// Stiffness that the device feels of a contact: all of it, or with quasi-static its series with the spring.
double seen_stiffness(const vxs_coupling_config &coupling, double contact);

/// K [N/m] below which Coulomb friction cannot keep the loop hunting either. To a motion of amplitude a
/// friction f is a damper of 4 f / (pi a w) more (its describing function): large motions feel little of it,
/// small ones any amount. So this is the least K_max of the loop with the damping that it has, and with twice
/// to 4096 times as much. Fast filters gain by damping; slow ones, which live on the arm's spring, lose by
/// it: such a loop may be stable and hunt by millimetres.
double hunting_stiffness(const vxs_simulated_config &device, const vxs_coupling_config &coupling);

/// Abbott and Okamura: min(2 b / T, 2 f / step) of the device alone [N/m]; beyond, encoder steps can feed the
/// loop.
double quantisation_limit(const vxs_simulated_config &device);

} // namespace voxshell
