// SPDX-License-Identifier: GPL-3.0-or-later
// What a force signal is worth: against the force that ought to be (one scale left free), along its normal
// and across, in time and in frequency; and how a coupling answers.
#pragma once

#include "import/scene.hpp"

#include <cstdint>
#include <vector>

namespace voxshell {

/// One tick. All in a frame that goes with the contact: [0] along the normal out of what stands, [1] and [2]
/// across.
struct ForceSample {
    Point force{}, torque{};              ///< [N], [N m] about the moving object's middle
    Point ideal_force{}, ideal_torque{};  ///< what ought to be, but for one factor on both
    std::uint32_t points = 0;             ///< colliding
    bool deep = false, cancelled = false; ///< flags of the contact
};

/// Shares are of the mean normal force. NaN where there is nothing to measure.
struct ForceMetrics {
    double normal = 0;                                   ///< mean along the normal [N]
    double ripple = 0;                                   ///< its standard deviation, a share
    double across_rms = 0, across_peak = 0;              ///< tangential force, shares
    double across_bias = 0;                              ///< size of its mean vector, a share
    double across_noise = 0;                             ///< rms of what is left without that mean, a share
    double angle_mean = 0, angle_p95 = 0, angle_max = 0; ///< off the ideal direction [degrees]
    double size = 0, torque_size = 0;                    ///< mean |force| and |torque| / radius [N]
    double torque_error = 0;                             ///< rms |torque - ideal| / (mean |F| radius)
    double wrench_error =
        0; ///< rms of force and torque / radius off the ideal by the best factor, of that ideal's rms
    double magnitude_error =
        0; ///< rms of |force| off that of the ideal by the best factor for forces alone, of that ideal's rms
    double points_min = 0, points_mean = 0, points_max = 0;
    double jump = 0; ///< largest change of the force from tick to tick, a share
    double above_10 = 0, above_30 = 0, above_100 = 0; ///< shares of the fluctuation's power above so many Hz
    double swing_above_10 = 0; ///< rms of the fluctuation above 10 Hz, a share of the mean normal force
    double at_crossing = 0;    ///< and within 5 % of the cell-crossing frequency
    double touching = 0, deep = 0, cancelled = 0; ///< shares of the ticks
    bool degenerate = false; ///< no force, or nothing across it at all: no law is to be judged by it
};

/// rate [Hz]; radius of the moving object [m]; crossing [Hz], 0: none; periodic: the samples are whole turns,
/// so that the spectrum needs no window.
ForceMetrics force_metrics(const std::vector<ForceSample> &samples, double rate, double radius,
                           double crossing, bool periodic);

/// Powers of a real signal's frequencies 0 .. n/2 (times rate / n), scaled so that their sum is the mean
/// square.
std::vector<double> power_spectrum(const std::vector<double> &signal);

/// Powers of short pieces of the error of force and torque / radius (off their ideal by the best factor), in
/// all directions together: of each `window` ticks by Hann's window, one every `hop`.
struct ShortTimeSpectrum {
    double step_s = 0, step_hz = 0, first_s = 0; ///< of pieces, of frequencies; middle of the first piece
    std::vector<std::vector<double>> power;      ///< [piece][frequency], shares of the ideal's mean square
};
ShortTimeSpectrum error_spectrum(const std::vector<ForceSample> &samples, double rate, double radius,
                                 std::size_t window, std::size_t hop);

/// How an output follows its input, both along one direction.
struct ResponseMetrics {
    double steady = 0;      ///< output's mean over the last 0.3 s [N]
    double rise = 0;        ///< 10 % to 90 % of that [s]
    double overshoot = 0;   ///< a share of it
    double settling = 0;    ///< from the first input on, until it stays within 5 % of it [s]; NaN: never
    double lag = 0;         ///< at the largest cross-correlation, 0 to 0.3 s [s]
    double oscillation = 0; ///< peak to peak in the last 0.3 s [N]
};

ResponseMetrics response_metrics(const std::vector<double> &input, const std::vector<double> &output,
                                 double rate);

/// Energy taken from the hand [J] and its least: a force commanded at tick k acts from tick k + delay on,
/// over the way to the next.
double least_energy(const std::vector<Point> &positions, const std::vector<Point> &forces, unsigned delay);

struct MeanAndSpread {
    double mean = 0, deviation = 0, least = 0, most = 0;
    std::size_t count = 0; ///< of finite values; NaN for the rest where there are none
};
MeanAndSpread mean_and_spread(const std::vector<double> &values);

} // namespace voxshell
