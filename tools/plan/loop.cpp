// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/loop.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace voxshell {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double pi = std::numbers::pi;

/// e^(j angle) - 1 and e^(j angle) + 1 without cancellation.
std::complex<double> z_minus_one(double angle)
{
    const double s = std::sin(angle / 2);
    return {-2 * s * s, std::sin(angle)};
}
std::complex<double> z_plus_one(double angle)
{
    const double c = std::cos(angle / 2);
    return {2 * c * c, std::sin(angle)};
}

/// Angles from far below the slowest filter (0.05 Hz at 100 kHz) to half the rate: 300 a decade, close
/// together at the upper end too.
const std::vector<double> &grid()
{
    static const std::vector<double> angles = [] {
        std::vector<double> out;
        for (double decade = -7.5; decade < std::log10(pi); decade += 1.0 / 300) {
            out.push_back(std::pow(10.0, decade));
        }
        for (int n = 100; n >= 0; --n) {
            out.push_back(pi * (1 - 0.002 * n / 100));
        }
        std::sort(out.begin(), out.end());
        return out;
    }();
    return angles;
}

/// Where f changes sign between two angles.
template<class F>
double root(double low, double high, F f)
{
    const bool rises = f(low) < 0;
    for (int n = 0; n < 60 && low < high; ++n) {
        const double middle = 0.5 * (low + high);
        ((f(middle) < 0) == rises ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

} // namespace

Loop::Loop(const vxs_simulated_config &device, const vxs_coupling_config &coupling)
    : sample_time_(device.sample_time), mass_(device.profile.mass + device.arm.mass),
      viscosity_(device.profile.viscosity + device.arm.viscosity), stiffness_(device.arm.stiffness),
      delay_(device.delay_samples), g_(0), damping_(coupling.damping), filter_gain_(1)
{
    // One substep of the simulated device, friction and hand at rest: v' = (v + m (F - k x)) / drag, x' = x +
    // h v'.
    const double h = sample_time_ / device.substeps, mobility = h / mass_;
    const double drag = 1 + mobility * (viscosity_ + h * stiffness_);
    const double step[2][2] = {{1 / drag - 1, -mobility * stiffness_ / drag},
                               {h / drag, -h * mobility * stiffness_ / drag}};
    const double push[2] = {mobility / drag, h * mobility / drag};
    for (std::uint32_t n = 0; n < device.substeps; ++n) {
        double next[2][2], pushed[2];
        for (int i = 0; i < 2; ++i) { // (1 + S)(1 + M) - 1 = M + S + S M
            for (int j = 0; j < 2; ++j) {
                next[i][j] =
                    motion_[i][j] + step[i][j] + step[i][0] * motion_[0][j] + step[i][1] * motion_[1][j];
            }
            pushed[i] = push_[i] + step[i][0] * push_[0] + step[i][1] * push_[1] + push[i];
        }
        std::copy(&next[0][0], &next[0][0] + 4, &motion_[0][0]);
        std::copy(pushed, pushed + 2, push_);
    }
    if (coupling.kind == VXS_COUPLING_PT2) {
        g_ = coupling.omega0 * sample_time_ / 2;
        g_ = coupling.prewarp ? std::tan(g_) : g_;
        filter_gain_ = coupling.gain;
    }
}

std::complex<double> Loop::filter(double angle) const
{
    if (g_ == 0) {
        return 1;
    }
    const std::complex<double> m = z_minus_one(angle), p = z_plus_one(angle);
    return filter_gain_ * g_ * g_ * p * p / (m * m + 2 * damping_ * g_ * m * p + g_ * g_ * p * p);
}

std::complex<double> Loop::gain(double angle) const
{
    const std::complex<double> z = z_minus_one(angle);
    const std::complex<double> vv = z - motion_[0][0], xx = z - motion_[1][1];
    const std::complex<double> position =
        (motion_[1][0] * push_[0] + vv * push_[1]) / (vv * xx - motion_[0][1] * motion_[1][0]);
    return position * filter(angle) * std::polar(1.0, -static_cast<double>(delay_) * angle);
}

double Loop::damping_needed(double angle) const
{
    const std::complex<double> held = -std::conj(z_minus_one(angle)); // 1 - 1/z
    const double s = std::sin(angle / 2);
    return sample_time_ / (4 * s * s) *
           (held * filter(angle) * std::polar(1.0, -static_cast<double>(delay_) * angle)).real();
}

std::complex<double> Loop::impedance(double angle, double stiffness) const
{
    const std::complex<double> s(0, angle / sample_time_);
    const std::complex<double> held = -std::conj(z_minus_one(angle)) / (s * sample_time_);
    const std::complex<double> wall =
        stiffness * held * filter(angle) * std::polar(1.0, -static_cast<double>(delay_) * angle);
    return s * mass_ + viscosity_ + (stiffness_ + wall) / s;
}

double Loop::largest_stiffness() const
{
    if (viscosity_ <= 0) {
        return 0; // a mass on a delayed spring only: it gains energy at any stiffness
    }
    double largest = infinity;
    double before = 0, before_angle = 0;
    for (const double angle : grid()) {
        const std::complex<double> g = gain(angle);
        if (before_angle > 0 && (before < 0) != (g.imag() < 0)) {
            const double at = root(before_angle, angle, [this](double a) { return gain(a).imag(); });
            if (const double real = gain(at).real(); real < 0) {
                largest = std::min(largest, -1 / real);
            }
        }
        before = g.imag();
        before_angle = angle;
    }
    if (const double real = gain(pi).real(); real < 0) {
        largest = std::min(largest, -1 / real);
    }
    return largest;
}

double Loop::damping_to_be_passive(double stiffness) const
{
    double most = 0;
    for (const double angle : grid()) {
        most = std::max(most, damping_needed(angle));
    }
    return stiffness * most;
}

double Loop::passive_stiffness() const
{
    const double needed = damping_to_be_passive(1);
    return needed > 0 ? viscosity_ / needed : infinity;
}

Margins Loop::margins(double stiffness) const
{
    const double largest = largest_stiffness();
    Margins out{20 * std::log10(largest / stiffness), infinity, infinity};
    double before = 0, before_angle = 0;
    for (const double angle : grid()) {
        const double size = stiffness * std::abs(gain(angle)) - 1;
        if (before_angle > 0 && (before < 0) != (size < 0)) {
            const double at =
                root(before_angle, angle, [&](double a) { return stiffness * std::abs(gain(a)) - 1; });
            double phase = pi + std::arg(gain(at)); // 0 .. 2 pi: of a stable loop what is left
            phase = phase > pi ? phase - 2 * pi : phase;
            out.phase_deg = std::min(out.phase_deg, 180 / pi * std::abs(phase));
            out.delay_s = std::min(out.delay_s, (phase > 0 ? phase : phase + 2 * pi) / at * sample_time_);
        }
        before = size;
        before_angle = angle;
    }
    if (!(largest > stiffness)) {
        out.phase_deg = -out.phase_deg;
        out.delay_s = std::numeric_limits<double>::quiet_NaN();
    }
    return out;
}

double Loop::bandwidth_hz() const
{
    const double half = std::sqrt(0.5) * filter_gain_;
    double before = 0;
    for (const double angle : grid()) {
        if (std::abs(filter(angle)) < half) {
            return root(before, angle, [&](double a) { return std::abs(filter(a)) - half; }) /
                   (2 * pi * sample_time_);
        }
        before = angle;
    }
    return 0.5 / sample_time_;
}

double seen_stiffness(const vxs_coupling_config &coupling, double contact)
{
    if (coupling.kind != VXS_COUPLING_QUASI_STATIC) {
        return contact;
    }
    return std::isinf(contact) ? coupling.stiffness
                               : coupling.stiffness * contact / (coupling.stiffness + contact);
}

double hunting_stiffness(const vxs_simulated_config &device, const vxs_coupling_config &coupling)
{
    vxs_simulated_config damped = device;
    const double own = device.profile.viscosity + device.arm.viscosity;
    double least = infinity;
    for (int doublings = 0; doublings <= (device.profile.friction > 0 ? 12 : 0); ++doublings) {
        damped.profile.viscosity = own * std::ldexp(1.0, doublings) - device.arm.viscosity;
        least = std::min(least, Loop(damped, coupling).largest_stiffness());
    }
    return least;
}

double quantisation_limit(const vxs_simulated_config &device)
{
    const auto &profile = device.profile;
    const double by_damping = 2 * profile.viscosity / device.sample_time;
    return profile.resolution > 0 ? std::min(by_damping, 2 * profile.friction / profile.resolution)
                                  : by_damping;
}

} // namespace voxshell
