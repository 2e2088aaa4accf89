// SPDX-License-Identifier: GPL-3.0-or-later
// The loop's model against three others: the real device and coupling in the time domain, the eigenvalues of
// the closed loop, and the figures of the literature.
//     test_loop full        the onset of 200 cases by bisection, as a table
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "plan/loop.hpp"
#include "plan/time_domain.hpp"

#include <Eigen/Eigenvalues>

#include <cstdio>
#include <cstring>
#include <limits>
#include <numbers>

using namespace voxshell;

namespace {

constexpr double pi = std::numbers::pi;
constexpr double frequencies[] = {0, 5, 20, 50, 200}; // 0: none
bool full = false;

vxs_simulated_config device_of(std::uint32_t profile, std::uint32_t arm)
{
    vxs_simulated_config config;
    vxs_simulated_config_default(&config, vxs_simulated_profile_at(profile));
    config.arm = *vxs_simulated_arm_at(arm);
    return config;
}

vxs_coupling_config coupling_of(double hertz, double damping, double sample_time)
{
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = hertz > 0 ? VXS_COUPLING_PT2 : VXS_COUPLING_NONE;
    config.omega0 = 2 * pi * hertz;
    config.damping = damping;
    config.sample_time = sample_time;
    return config;
}

template<class F>
void each_case(F f)
{
    for (std::uint32_t p = 0; vxs_simulated_profile_at(p); ++p) {
        for (std::uint32_t a = 0; vxs_simulated_arm_at(a); ++a) {
            for (const double hertz : frequencies) {
                const vxs_simulated_config device = device_of(p, a);
                f(device, coupling_of(hertz, 1, device.sample_time), hertz);
            }
        }
    }
}

/// Largest |eigenvalue| of the closed loop, from states and matrices written down on their own: substep by
/// substep, the delay as a shift register, the biquad in its direct form.
double spectral_radius(const vxs_simulated_config &d, const vxs_coupling_config &c, double stiffness)
{
    const double h = d.sample_time / d.substeps, m = d.profile.mass + d.arm.mass, k = d.arm.stiffness;
    const double b = d.profile.viscosity + d.arm.viscosity, drag = 1 + h / m * (b + h * k);
    Eigen::Matrix3d one; // velocity, position, force held
    one << 1 / drag, -h / m * k / drag, h / m / drag, h / drag, 1 - h * h / m * k / drag, h * h / m / drag, 0,
        0, 1;
    Eigen::Matrix3d sample = Eigen::Matrix3d::Identity();
    for (std::uint32_t n = 0; n < d.substeps; ++n) {
        sample = one * sample;
    }
    vxs_coupling_coefficients f{1, 0, 0, 0, 0};
    if (c.kind == VXS_COUPLING_PT2) {
        REQUIRE(vxs_coupling_design(&c, &f) == VXS_OK);
    }
    // State: v, x, delay_samples commands on their way (the oldest first), two states of the filter
    // (transposed form).
    const int n = 2 + static_cast<int>(d.delay_samples) + 2, s = n - 2;
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    a.block(0, 0, 2, 2) = sample.block(0, 0, 2, 2);
    a.block(0, 2, 2, 1) = sample.block(0, 2, 2, 1);
    for (int i = 2; i + 1 < s; ++i) {
        a(i, i + 1) = 1;
    }
    // u = -K x; y = b0 u + s1 goes in as the newest command; s1' = b1 u - a1 y + s2; s2' = b2 u - a2 y.
    const auto row = [&](int to, double of_u, double of_y) {
        a(to, 1) += -stiffness * (of_u + of_y * f.b0);
        a(to, s) += of_y;
    };
    row(s - 1, 0, 1);
    row(s, f.b1, -f.a1);
    a(s, s + 1) += 1;
    row(s + 1, f.b2, -f.a2);
    return a.eigenvalues().cwiseAbs().maxCoeff();
}

} // namespace

TEST_CASE("the oscillation sets in within 5 % of the stiffness foretold, on the real device and coupling")
{
    double lowest = 1e9, highest = 0;
    int cases = 0;
    each_case([&](const vxs_simulated_config &device, const vxs_coupling_config &coupling, double hertz) {
        const Loop loop(device, coupling);
        const double largest = loop.largest_stiffness();
        const long ticks = ticks_of_onset(loop, largest);
        CAPTURE(device.profile.name);
        CAPTURE(device.arm.name);
        CAPTURE(hertz);
        CAPTURE(largest);
        ++cases;
        if (!full) {
            CHECK(growth(device, coupling, 0.95 * largest, ticks) < 0);
            CHECK(growth(device, coupling, 1.05 * largest, ticks) > 0);
            return;
        }
        const double found =
            onset(largest, 2, 0.0005, [&](double k) { return growth(device, coupling, k, 3 * ticks) > 0; });
        const double ratio = largest / found;
        lowest = std::min(lowest, ratio);
        highest = std::max(highest, ratio);
        std::printf("%-20s %-5s %4g Hz  foretold %10.4g N/m  found %10.4g N/m  ratio %.4f\n",
                    device.profile.name, device.arm.name, hertz, largest, found, ratio);
        CHECK(std::abs(ratio - 1) < 0.05);
    });
    CHECK(cases == 200);
    if (full) {
        std::printf("%d cases: foretold / found from %.4f to %.4f\n", cases, lowest, highest);
    }
}

TEST_CASE("the closed loop's eigenvalues reach the unit circle at that stiffness")
{
    each_case([&](const vxs_simulated_config &device, const vxs_coupling_config &coupling, double hertz) {
        CAPTURE(device.profile.name);
        CAPTURE(device.arm.name);
        CAPTURE(hertz);
        for (const std::uint32_t delay : {1u, 4u}) {
            vxs_simulated_config delayed = device;
            delayed.delay_samples = delay;
            const double largest = Loop(delayed, coupling).largest_stiffness();
            for (const double share : {0.02, 0.2, 0.5, 0.9, 0.999}) {
                CHECK(spectral_radius(delayed, coupling, share * largest) < 1);
            }
            CHECK(spectral_radius(delayed, coupling, 1.001 * largest) > 1);
        }
    });
    // Filters of every shape, pre-warped too, on one device.
    for (const double hertz : {0.05, 0.5, 5.0, 80.0, 300.0, 490.0}) {
        for (const double damping : {0.05, 0.3, 0.7, 3.0, 50.0}) {
            for (const std::uint32_t prewarp : {0u, 1u}) {
                for (std::uint32_t arm = 0; arm < 4; ++arm) {
                    const vxs_simulated_config device = device_of(3, arm);
                    vxs_coupling_config coupling = coupling_of(hertz, damping, device.sample_time);
                    coupling.prewarp = prewarp;
                    const double largest = Loop(device, coupling).largest_stiffness();
                    CAPTURE(hertz);
                    CAPTURE(damping);
                    CAPTURE(arm);
                    CHECK(spectral_radius(device, coupling, 0.99 * largest) < 1 + 1e-9);
                    CHECK(spectral_radius(device, coupling, 1.01 * largest) > 1 - 1e-9);
                }
            }
        }
    }
}

TEST_CASE("published figures: Phantom Premium 1.5 at 1 kHz with one sample of delay")
{
    const auto largest = [](std::uint32_t arm, double hertz) {
        vxs_simulated_config device = device_of(3, arm);
        device.substeps = 1000; // nearly the continuous device, without the damping of its coarser substeps
        return Loop(device, coupling_of(hertz, 1, device.sample_time)).largest_stiffness();
    };
    CHECK(largest(0, 0) == doctest::Approx(66.7).epsilon(0.002));
    CHECK(largest(0, 5) == doctest::Approx(1.6).epsilon(0.003));
    CHECK(largest(2, 0) == doctest::Approx(3424).epsilon(0.002));
    CHECK(largest(2, 5) == doctest::Approx(674).epsilon(0.002));
    double worst = 1e9, at = 0;
    for (double hertz = 2; hertz < 400; hertz *= 1.02) {
        if (const double k = largest(2, hertz); k < worst) {
            worst = k;
            at = hertz;
        }
    }
    CHECK(largest(2, 20) == doctest::Approx(432).epsilon(0.002));
    CHECK(worst == doctest::Approx(395).epsilon(0.002)); // lower than at 20 Hz
    CHECK(at == doctest::Approx(12.9).epsilon(0.03));
}

TEST_CASE("Colgate's condition")
{
    // No filter: b > K (T/2 + delay), reached at low frequencies. With one: K (T/2 + delay + 2 d / w0).
    for (std::uint32_t p = 0; vxs_simulated_profile_at(p); ++p) {
        vxs_simulated_config device = device_of(p, 0);
        for (const std::uint32_t delay : {1u, 3u}) {
            device.delay_samples = delay;
            const double t = device.sample_time, lag = t / 2 + delay * t;
            const Loop plain(device, coupling_of(0, 1, t)), slow(device, coupling_of(30, 1, t));
            CHECK(plain.passive_stiffness() == doctest::Approx(device.profile.viscosity / lag).epsilon(1e-3));
            CHECK(plain.damping_to_be_passive(100) == doctest::Approx(100 * lag).epsilon(1e-3));
            CHECK(slow.passive_stiffness() ==
                  doctest::Approx(device.profile.viscosity / (lag + 2 / (2 * pi * 30))).epsilon(1e-3));
            // What is passive is stable with any arm.
            for (std::uint32_t a = 0; a < 4; ++a) {
                vxs_simulated_config held = device;
                held.arm = *vxs_simulated_arm_at(a);
                CHECK(Loop(held, coupling_of(30, 1, t)).largest_stiffness() > slow.passive_stiffness());
            }
            // The real part of the base band's impedance is b less what the wall takes, at low frequencies.
            const double angle = 1e-3;
            CHECK(plain.impedance(angle, 50).real() ==
                  doctest::Approx(device.profile.viscosity - 50 * plain.damping_needed(angle)).epsilon(1e-4));
        }
    }
}

TEST_CASE("margins end where the loop does")
{
    for (const double hertz : {0.0, 5.0, 50.0}) {
        for (std::uint32_t arm = 0; arm < 4; ++arm) {
            const vxs_simulated_config device = device_of(3, arm);
            const vxs_coupling_config coupling = coupling_of(hertz, 1, device.sample_time);
            const Loop loop(device, coupling);
            const double largest = loop.largest_stiffness();
            CAPTURE(hertz);
            CAPTURE(arm);
            CHECK(loop.margins(largest / 2).gain_db == doctest::Approx(20 * std::log10(2)));
            const Margins beyond = loop.margins(1.3 * largest);
            CHECK(beyond.gain_db < 0);
            CHECK(beyond.phase_deg <= 0);
            CHECK(std::isnan(beyond.delay_s));
            // The delay margin: so many samples more are stable, one more is not.
            const double stiffness = 0.3 * largest;
            const Margins left = loop.margins(stiffness);
            if (std::isfinite(left.delay_s) && left.delay_s < 0.05) {
                vxs_simulated_config later = device;
                later.delay_samples += static_cast<std::uint32_t>(left.delay_s / device.sample_time);
                CHECK(spectral_radius(later, coupling, stiffness) < 1);
                later.delay_samples += 1;
                CHECK(spectral_radius(later, coupling, stiffness) > 1);
            } else {
                CHECK(left.phase_deg > 0);
            }
        }
    }
}

TEST_CASE("friction and encoder steps together keep going what neither does alone")
{
    vxs_simulated_config device;
    vxs_simulated_config_default(&device, vxs_simulated_profile_named("desktop"));
    device.arm = *vxs_simulated_arm_named("pen");
    const vxs_coupling_config coupling = coupling_of(2, 1, device.sample_time);
    const double stiffness = 1000;
    CHECK(stiffness < hunting_stiffness(device, coupling));
    CHECK(stiffness > quantisation_limit(device));
    const auto swing = [&](bool friction, bool steps) {
        vxs_simulated_config other = device;
        if (!friction) other.profile.friction = 0;
        if (!steps) other.profile.resolution = 0;
        TimeDomain loop(other, coupling, 0.005);
        loop.run(stiffness, 30'000);
        return loop.run(stiffness, 2'000).amplitude();
    };
    CHECK(swing(true, true) > 10 * device.profile.resolution);
    CHECK(swing(true, false) < device.profile.resolution);
    CHECK(swing(false, true) < device.profile.resolution);
}

TEST_CASE("limits")
{
    vxs_simulated_config device = device_of(3, 0);
    CHECK(quantisation_limit(device) == doctest::Approx(200)); // 2 b / T; 2 f / step is 2667
    device.profile.friction = 0.0015;
    CHECK(quantisation_limit(device) == doctest::Approx(100));
    device.profile.viscosity = 0;
    CHECK(Loop(device, coupling_of(0, 1, 0.001)).largest_stiffness() == 0);
    vxs_coupling_config spring;
    vxs_coupling_config_default(&spring);
    spring.kind = VXS_COUPLING_QUASI_STATIC;
    spring.stiffness = 300;
    CHECK(seen_stiffness(spring, 600) == doctest::Approx(200));
    CHECK(seen_stiffness(spring, std::numeric_limits<double>::infinity()) == 300);
    const Loop fast(device_of(3, 0), coupling_of(0, 1, 0.001)),
        slow(device_of(3, 0), coupling_of(5, 1 / std::sqrt(2.0), 0.001));
    CHECK(fast.bandwidth_hz() == 500);
    CHECK(slow.bandwidth_hz() == doctest::Approx(5).epsilon(1e-3));
}

int main(int argc, char **argv)
{
    full = argc > 1 && std::strcmp(argv[1], "full") == 0;
    doctest::Context context;
    return context.run();
}
