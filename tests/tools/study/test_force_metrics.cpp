// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a force on signals whose figures are known.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "study/force_metrics.hpp"

#include "voxshell/coupling.h"

#include <cmath>
#include <numbers>

using namespace voxshell;
using doctest::Approx;

namespace {

constexpr double pi = std::numbers::pi, rate = 1000;

/// Three seconds: 2 N along the normal and a ripple, a constant and a turning force across, a step in each
/// second.
std::vector<ForceSample> known()
{
    std::vector<ForceSample> samples(3000);
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const double t = static_cast<double>(n) / rate;
        ForceSample &s = samples[n];
        s.force = {2 + 0.2 * std::sin(2 * pi * 20 * t), 0.3 + 0.4 * std::cos(2 * pi * 50 * t),
                   0.4 * std::sin(2 * pi * 50 * t)};
        s.ideal_force = {1, 0, 0};
        s.points = 10 + static_cast<std::uint32_t>(n % 3);
    }
    return samples;
}

} // namespace

TEST_CASE("shares of a known force")
{
    const ForceMetrics m = force_metrics(known(), rate, 0.02, 50, true);
    CHECK(m.normal == Approx(2));
    CHECK(m.ripple == Approx(0.1 / std::numbers::sqrt2));
    CHECK(m.across_bias == Approx(0.15));
    CHECK(m.across_noise == Approx(0.2));
    CHECK(m.across_rms == Approx(0.25));
    CHECK(m.across_peak == Approx(0.35));
    CHECK(m.points_min == 10);
    CHECK(m.points_mean == Approx(11));
    CHECK(m.points_max == 12);
    CHECK(m.touching == Approx(1));
    CHECK_FALSE(m.degenerate);
    // 0.02 W at 20 Hz, 0.16 W at 50 Hz.
    CHECK(m.above_10 == Approx(1));
    CHECK(m.above_30 == Approx(0.16 / 0.18));
    CHECK(m.above_100 == Approx(0).epsilon(1e-9));
    CHECK(m.at_crossing == Approx(0.16 / 0.18));
    CHECK(m.swing_above_10 == Approx(std::sqrt(0.18) / 2));
    CHECK(force_metrics(known(), rate, 0.02, 50, false).swing_above_10 ==
          Approx(std::sqrt(0.18) / 2).epsilon(0.01)); // windowed
    CHECK(m.torque_size == 0);
    // 0.4 N turning by 18 degrees a tick, and the ripple: no more than 0.2 sin(2 pi 0.02).
    CHECK(m.jump >= 0.2 * 2 * std::sin(pi * 50 / rate) - 1e-9);
    CHECK(m.jump <= 0.2 * 2 * std::sin(pi * 50 / rate) + 0.1 * 2 * pi * 20 / rate);
}

TEST_CASE("against the ideal")
{
    std::vector<ForceSample> samples(100);
    for (std::size_t n = 0; n < samples.size(); ++n) {
        const double angle = static_cast<double>(n + 1) * pi / 180 / 10; // 0.1 .. 10 degrees
        samples[n].ideal_force = {1, 0, 0};
        samples[n].force = {5 * std::cos(angle), 5 * std::sin(angle), 0};
        samples[n].torque = {0, 0, 0.05};
    }
    ForceMetrics m = force_metrics(samples, rate, 0.02, 0, false);
    CHECK(m.angle_mean == Approx(5.05));
    CHECK(m.angle_p95 == Approx(9.5));
    CHECK(m.angle_max == Approx(10));
    CHECK(m.torque_error == Approx(0.05 / (5 * 0.02)));
    CHECK(m.torque_size == Approx(0.05 / 0.02));
    CHECK(m.size == Approx(5));
    CHECK(std::isnan(m.at_crossing));
    for (ForceSample &s : samples) { // right but for one factor
        s.ideal_torque = {0, 1, 0};
        s.force = {3, 0, 0};
        s.torque = {0, 3, 0};
    }
    m = force_metrics(samples, rate, 0.02, 0, false);
    CHECK(m.wrench_error == Approx(0).epsilon(1e-9));
    CHECK(m.torque_error == Approx(0).epsilon(1e-9));
    for (std::size_t n = 0; n < samples.size(); ++n) samples[n].force[1] = n % 2 ? 0.3 : -0.3;
    for (ForceSample &s : samples) s.torque = s.ideal_torque = {};
    CHECK(force_metrics(samples, rate, 0.02, 0, false).wrench_error == Approx(0.1));
}

TEST_CASE("nothing to compare by")
{
    std::vector<ForceSample> samples(50);
    CHECK(force_metrics(samples, rate, 0.02, 0, true).degenerate);
    CHECK(std::isnan(force_metrics(samples, rate, 0.02, 0, true).ripple));
    for (ForceSample &s : samples) s.force = {1, 1e-12, 0};
    CHECK(force_metrics(samples, rate, 0.02, 0, true).degenerate);
    for (ForceSample &s : samples) s.force = {1, 1e-3, 0};
    CHECK_FALSE(force_metrics(samples, rate, 0.02, 0, true).degenerate);
    CHECK(force_metrics({}, rate, 0.02, 0, true).degenerate);
}

TEST_CASE("powers add up to the mean square, for lengths of any factors")
{
    for (const std::size_t count : {1u, 2u, 97u, 360u, 1001u}) {
        std::vector<double> signal;
        double square = 0;
        for (std::size_t n = 0; n < count; ++n) {
            signal.push_back(std::sin(0.1 * static_cast<double>(n * n)) + 0.3);
            square += signal.back() * signal.back() / static_cast<double>(count);
        }
        double sum = 0;
        for (const double power : power_spectrum(signal)) sum += power;
        CHECK(sum == Approx(square));
    }
    CHECK(power_spectrum({}).empty());
}

TEST_CASE("a coupling's answer to a step")
{
    // A critically damped PT2: 1 - (1 + w t) exp(-w t); 10 % at w t = 0.5318, 90 % at 3.8897, 5 % at 4.7439.
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    const double w = config.omega0;
    std::vector<double> input(2000), output(2000);
    for (std::size_t n = 200; n < input.size(); ++n) {
        const double t = static_cast<double>(n - 200) / rate;
        input[n] = 2;
        output[n] = 2 * (1 - (1 + w * t) * std::exp(-w * t));
    }
    ResponseMetrics m = response_metrics(input, output, rate);
    CHECK(m.steady == Approx(2).epsilon(1e-6));
    CHECK(m.rise == Approx((3.8897 - 0.5318) / w).epsilon(0.02));
    CHECK(m.settling == Approx(4.7439 / w).epsilon(0.02));
    CHECK(m.overshoot < 1e-6);
    CHECK(m.oscillation < 1e-6);
    // Late by 30 ms, 40 % too high at first, swinging at the end.
    for (std::size_t n = 0; n < input.size(); ++n)
        input[n] = n < 200 ? 0 : 1 + 0.1 * std::sin(0.01 * static_cast<double>(n * n) / 300);
    for (std::size_t n = 0; n < input.size(); ++n) output[n] = n < 30 ? 0 : input[n - 30];
    CHECK(response_metrics(input, output, rate).lag == Approx(0.03));
    for (std::size_t n = 0; n < output.size(); ++n) {
        output[n] = n < 200   ? 0
                    : n < 210 ? 1.4
                              : 1 + 0.2 * std::sin(2 * pi * 10 * static_cast<double>(n) / rate);
    }
    m = response_metrics(input, output, rate);
    CHECK(m.overshoot == Approx(0.4).epsilon(0.01));
    CHECK(m.oscillation == Approx(0.4).epsilon(0.01));
    CHECK(std::isnan(m.settling));
    CHECK(response_metrics({}, {}, rate).steady == 0);
}

TEST_CASE("error against a known force: one factor, size, and its spectrum over time")
{
    // Twice the ideal, and from half of the time on a swing of a tenth along it at 125 Hz; torque as it ought
    // to be.
    constexpr double radius = 0.02;
    std::vector<ForceSample> samples;
    for (int n = 0; n < 2048; ++n) {
        const double swing = n < 1024 ? 0 : 0.2 * std::sin(2 * pi * 125 * n / rate);
        samples.push_back({{2 + swing, 0, 0}, {0, 0.04, 0}, {1, 0, 0}, {0, 0.02, 0}, 1, false, false});
    }
    const ForceMetrics m = force_metrics(samples, rate, radius, 0, true);
    CHECK(m.magnitude_error == Approx(0.1 / 2).epsilon(1e-3)); // a tenth, rms over half of the time
    const ShortTimeSpectrum s = error_spectrum(samples, rate, radius, 128, 128);
    CHECK(s.step_hz == Approx(7.8125));
    CHECK(s.power.size() == 16);
    for (std::size_t piece = 0; piece < s.power.size(); ++piece) {
        double all = 0, near = 0;
        for (std::size_t n = 0; n < s.power[piece].size(); ++n) {
            all += s.power[piece][n];
            if (n >= 15 && n <= 17) near += s.power[piece][n]; // 125 Hz is number 16
        }
        // Of force and torque / radius, both 2 N: half of what it would be of the force alone.
        CHECK(std::abs(all - (piece < 8 ? 0 : 0.01 / 4)) < 1e-6);
        CHECK(std::abs(near - all) < 1e-9);
    }
    for (ForceSample &each : samples) each.ideal_force = each.ideal_torque = {0, 0, 0};
    CHECK(std::isnan(force_metrics(samples, rate, radius, 0, true).magnitude_error));
    CHECK(error_spectrum(samples, rate, radius, 128, 128).power.empty());
}

TEST_CASE("energy of a spring that comes late")
{
    // At once it gives back what it took; a tick late it gives more, by half k times the squares of the
    // steps.
    std::vector<Point> positions, forces;
    for (int n = 0; n <= 200; ++n) {
        const double depth = 0.001 * (n <= 100 ? n : 200 - n);
        positions.push_back({-depth, 0, 0});
        forces.push_back({100 * depth, 0, 0});
    }
    const double least = least_energy(positions, forces, 1);
    CHECK(least < 0);
    // 100 N/m, 100 steps of 1 mm in and out, each force 1.5 steps old on the mean: 2 * 1.5 * 100 * 100 *
    // 1e-6.
    CHECK(least == Approx(-0.03).epsilon(0.03));
    for (Point &f : forces) f = {0, 1, 0};
    CHECK(least_energy(positions, forces, 1) == 0);
}

TEST_CASE("mean and spread leave out what is none")
{
    const MeanAndSpread m = mean_and_spread({1, std::nan(""), 3});
    CHECK(m.count == 2);
    CHECK(m.mean == 2);
    CHECK(m.deviation == Approx(std::numbers::sqrt2));
    CHECK(m.least == 1);
    CHECK(m.most == 3);
    CHECK(std::isnan(mean_and_spread({}).mean));
}
