// SPDX-License-Identifier: GPL-3.0-or-later
// The automatic design: what it picks holds in the time domain, nothing faster would, and it says what does
// not.
//     test_design full      a million ticks for each design
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include "cli/failure.hpp"
#include "plan/design.hpp"
#include "plan/scene_coupling.hpp"
#include "plan/simulated_device.hpp"
#include "plan/time_domain.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <numbers>

using namespace voxshell;

namespace {

long ticks = 20'000;

DesignInput input_of(std::uint32_t profile, std::vector<std::string> assume, double stiffness,
                     std::uint32_t kind = VXS_COUPLING_PT2)
{
    DesignInput input;
    vxs_simulated_config_default(&input.device, vxs_simulated_profile_at(profile));
    input.assume = std::move(assume);
    input.stiffness = stiffness > 0 ? stiffness : input.device.profile.max_stiffness;
    vxs_coupling_config_default(&input.coupling);
    input.coupling.kind = kind;
    input.automatic = true;
    return input;
}

bool says(const Design &design, const std::string &text)
{
    return std::any_of(design.advice.begin(), design.advice.end(),
                       [&](const std::string &advice) { return advice.find(text) != std::string::npos; });
}

vxs_simulated_config held_by(vxs_simulated_config device, const std::string &arm)
{
    device.arm = *vxs_simulated_arm_named(arm.c_str());
    return device;
}

vxs_simulated_config unclamped(vxs_simulated_config device)
{
    device.profile.peak_force = 1e30;
    return device;
}

std::string refusal(const DesignInput &input, ExitCode code)
{
    try {
        design_coupling(input);
    } catch (const Failure &failure) {
        CHECK(failure.code == code);
        return failure.what();
    }
    return "accepted";
}

/// At a speed into a linear contact, the hand's target so far on as it says.
Push push_of(const vxs_simulated_config &device, double speed, double on, double stiffness, double wall)
{
    Push push{{}, {}, 1e-4, speed, wall, wall / 2};
    for (double way = -0.02; way < 0.1; way += speed * device.sample_time)
        push.hand.push_back(std::min(way, on));
    while (static_cast<double>(push.hand.size()) * device.sample_time < 1.5) push.hand.push_back(on);
    for (double depth = 0; depth < wall; depth += push.step) push.force.push_back(stiffness * depth);
    return push;
}

} // namespace

TEST_CASE("what is stable by design stays so")
{
    int designs = 0, refused = 0;
    double worst = 0;
    for (std::uint32_t p = 0; const auto *profile = vxs_simulated_profile_at(p); ++p) {
        for (std::uint32_t a = 0; const auto *arm = vxs_simulated_arm_at(a); ++a) {
            vxs_coupling_config none;
            vxs_coupling_config_default(&none);
            none.kind = VXS_COUPLING_NONE;
            vxs_simulated_config device;
            vxs_simulated_config_default(&device, profile);
            none.sample_time = device.sample_time;
            const double half = 0.5 * Loop(held_by(device, arm->name), none).largest_stiffness();
            for (const double stiffness : {profile->max_stiffness, half, half / 8}) {
                const Design d = design_coupling(input_of(p, {arm->name}, stiffness));
                CAPTURE(profile->name);
                CAPTURE(arm->name);
                CAPTURE(stiffness);
                refused += d.refused;
                if (d.refused) continue;
                ++designs;
                CHECK(d.worst.gain_db > 0);
                TimeDomain ideal(small_motions(held_by(device, arm->name)), d.coupling),
                    real(unclamped(held_by(device, arm->name)), d.coupling);
                ideal.run(d.seen, ticks);
                CHECK(ideal.run(d.seen, 1000).rms < 0.7e-3); // it began 1 mm off
                // With friction and encoder it comes to rest where friction holds it, or moves by a few
                // steps.
                real.run(d.seen, ticks);
                const double stuck = profile->friction / d.seen;
                const double end = real.run(d.seen, 5000).rms;
                CHECK(end <= 2 * stuck + 3 * profile->resolution);
                worst = std::max(worst, (end - stuck) / profile->resolution);
            }
        }
    }
    std::printf("%d designs stable in %ld ticks, %d refused; with friction and encoder at the end up to %.2f "
                "steps beyond where friction holds\n",
                designs, ticks, refused, worst);
    CHECK(designs > 80);
}

TEST_CASE("a slow filter that lives on the arm's spring is stable, and friction keeps it hunting: it is not "
          "taken for stable")
{
    DesignInput input = input_of(5, {"hand"}, 2500);
    input.automatic = false;
    input.coupling.omega0 = 2 * std::numbers::pi * 0.68;
    input.coupling.damping = 0.7071;
    const Design slow = design_coupling(input);
    CHECK(slow.arms[2].largest_stiffness > 3000);
    CHECK(slow.arms[2].hunting_stiffness < 2500);
    CHECK(slow.refused);
    CHECK(says(slow, "stable, but friction can keep it hunting, with a hand"));
    TimeDomain ideal(small_motions(held_by(input.device, "hand")), slow.coupling),
        real(unclamped(held_by(input.device, "hand")), slow.coupling);
    ideal.run(3000, 60'000);
    CHECK(ideal.run(3000, 5000).rms < 1e-9);
    real.run(3000, 60'000);
    CHECK(real.run(3000, 5000).rms > 1e-3); // of millimetres
    input.automatic = true;
    CHECK(design_coupling(input).bandwidth_hz > 100);
}

TEST_CASE("margins are as stated, and no filter of the form is faster")
{
    for (const std::uint32_t p : {3u, 5u, 6u, 9u}) {
        const DesignInput input = input_of(p, {"hand"}, p == 5 ? 1000 : 0);
        const Design d = design_coupling(input);
        CAPTURE(input.device.profile.name);
        REQUIRE(d.margins_held);
        CHECK(d.worst.gain_db >= least_gain_db);
        CHECK(d.worst.delay_s >= least_delay_samples * input.device.sample_time);
        CHECK_FALSE(d.refused);
        for (double hertz = VXS_COUPLING_MAX_RATE / input.device.sample_time; hertz > 0.3; hertz /= 1.3) {
            for (const double damping : {std::numbers::sqrt2 / 2, 1.0, 2.0}) {
                vxs_coupling_config other = d.coupling;
                other.omega0 = 2 * std::numbers::pi * hertz;
                other.damping = damping;
                const Loop loop(held_by(input.device, "hand"), other);
                const vxs_simulated_config held = held_by(input.device, "hand");
                if (loop.bandwidth_hz() < 1.15 * d.bandwidth_hz) continue; // within the candidates' steps
                CAPTURE(hertz);
                const Margins m = loop.margins(input.stiffness);
                const double hunts_db = 20 * std::log10(hunting_stiffness(held, other) / input.stiffness);
                CHECK((std::min(m.gain_db, hunts_db) < least_gain_db ||
                       !(m.delay_s >= least_delay_samples * input.device.sample_time)));
            }
        }
    }
}

TEST_CASE("a spring that holds against any contact")
{
    for (std::uint32_t p = 0; vxs_simulated_profile_at(p); ++p) {
        const Design d = design_coupling(input_of(p, {}, 1e6, VXS_COUPLING_QUASI_STATIC));
        CHECK_FALSE(d.refused);
        CHECK(d.margins_held);
        CHECK(d.seen < d.coupling.stiffness);
        CHECK(d.coupling.stiffness <= d.input.device.profile.max_stiffness);
        for (const ArmDesign &arm : d.arms) {
            CHECK(arm.largest_stiffness > 1.9 * d.coupling.stiffness);
        }
    }
}

TEST_CASE("through a quasi-static spring the device feels the series of spring and contact")
{
    for (const std::uint32_t p : {0u, 3u, 6u, 9u}) {
        for (const char *arm : {"free", "hand"}) {
            DesignInput input = input_of(p, {arm}, 0, VXS_COUPLING_QUASI_STATIC);
            input.device.arm = *vxs_simulated_arm_named(arm);
            input.coupling.sample_time = input.device.sample_time;
            const double largest = Loop(input.device, input.coupling).largest_stiffness();
            CAPTURE(input.device.profile.name);
            CAPTURE(arm);
            for (const double wall : {0.3, 1.0, 30.0, 1e3}) { // of the spring
                CAPTURE(wall);
                for (const double share : {0.95, 1.05}) {
                    input.coupling.stiffness = share * largest * (1 + wall) / wall;
                    const double contact = wall * input.coupling.stiffness;
                    CHECK(seen_stiffness(input.coupling, contact) == doctest::Approx(share * largest));
                    const double rate = growth(input.device, input.coupling, contact, 30'000);
                    CHECK((rate > 0) == (share > 1));
                }
            }
        }
    }
}

TEST_CASE("5 Hz is no passive coupling with the hand off, and the design says what would be")
{
    DesignInput input = input_of(3, {}, 100);
    input.automatic = false; // the paper's filter
    const Design paper = design_coupling(input);
    CHECK(paper.refused);
    CHECK_FALSE(paper.arms[0].stable());
    CHECK_FALSE(paper.arms[0].passive());
    CHECK_FALSE(paper.arms[2].passive());
    CHECK(paper.arms[2].largest_stiffness > 600);
    CHECK(says(paper, "unstable with the hand off: carries 1.599 N/m, is to carry 100 N/m"));
    CHECK(says(paper, "no filter of this form is passive with the hand off"));
    CHECK(says(paper, "0.05 N s/m more damping in the device")); // 100 N/m x 1.5 ms less 0.1
    CHECK(says(paper, "1.5 kHz and no filter"));
    CHECK(says(paper, "passivity controller"));
    CHECK(paper.unfiltered.passive_stiffness == doctest::Approx(66.67).epsilon(1e-3));

    const Design robot = design_coupling(input_of(9, {}, 1000));
    CHECK_FALSE(robot.refused);
    CHECK(robot.arms[0].passive());
    CHECK(robot.advice.empty());

    // Damping, rate and stiffness that it names do make it passive.
    input.device.profile.viscosity += paper.unfiltered.damping_missing * 1.001;
    input.coupling.kind = VXS_COUPLING_NONE;
    CHECK(design_coupling(input).arms[0].passive());
    input = input_of(3, {}, 100, VXS_COUPLING_NONE);
    input.device.sample_time = 1 / (paper.unfiltered.rate_needed * 1.001);
    CHECK(design_coupling(input).arms[0].passive());
    input = input_of(3, {}, paper.arms[0].passive_stiffness * 0.999);
    input.automatic = false;
    CHECK(design_coupling(input).arms[0].passive());
}

TEST_CASE("a scene is refused where nothing is stable, unless the hand is assumed")
{
    SceneFile scene;
    scene.path = "cup.scene.json";
    scene.design = true;
    const vxs_simulated_config device = simulated_device(scene.device, scene.rate);
    const SceneContact wall{[] { return ContactStiffness{800, "stated"}; }, {}};
    try {
        scene_coupling(scene, device, wall);
        FAIL("accepted");
    } catch (const Failure &failure) {
        CHECK(failure.code == ExitCode::requirement);
        CHECK(std::string(failure.what())
                  .find("with the hand off: it carries 51.89 N/m, contact has 800 N/m (stated)") !=
              std::string::npos);
    }
    scene.assume = "hand";
    const SceneCoupling held = scene_coupling(scene, device, wall);
    CHECK(held.config.kind == VXS_COUPLING_PT2);
    CHECK(held.text == "pt2 490 Hz (auto)");
    REQUIRE(held.design);
    CHECK(held.config.omega0 == held.design->coupling.omega0);
    scene.assume.clear();
    scene.coupling = CouplingKind::quasi_static;
    CHECK(scene_coupling(scene, device, wall).config.stiffness < 40);
    scene.coupling = CouplingKind::pt2;
    scene.rate = 10; // slower than the paper's filter
    scene.assume = "hand";
    const SceneContact foam{[] { return ContactStiffness{5, "stated"}; }, {}};
    CHECK(scene_coupling(scene, simulated_device(scene.device, scene.rate), foam).design->margins_held);
    scene.rate = 1000;
    // What the scene says itself needs no stiffness.
    scene.design = false;
    scene.coupling = CouplingKind::pt2;
    const SceneContact silent{[]() -> ContactStiffness { throw std::runtime_error("asked"); }, {}};
    CHECK(scene_coupling(scene, device, silent).text == "pt2 5 Hz");
    scene.by_impedance = scene.physical_gain = true;
    scene.spring_stiffness = 200;
    scene.viscosity = 4;
    scene.mass = 0.5;
    const vxs_coupling_config physical = scene_coupling(scene, device, wall).config;
    CHECK(physical.gain == doctest::Approx(1.0 / 200));
    CHECK(physical.omega0 == doctest::Approx(20));
    CHECK(physical.damping == doctest::Approx(0.2));
}

TEST_CASE("a push is stopped where statics and energy say")
{
    DesignInput input = input_of(3, {"hand"}, 1000);
    vxs_simulated_config device = held_by(input.device, "hand");
    device.profile.friction = 0;
    vxs_coupling_config none = input.coupling;
    none.kind = VXS_COUPLING_NONE;
    // Slowly: the hand's spring against the contact.
    const Push slow = push_of(device, 0.02, 0.008, 1000, 0.05);
    const double balance = 0.008 * device.arm.stiffness / (device.arm.stiffness + 1000);
    CHECK(stop_push(slow, device, none).device ==
          doctest::Approx(balance).epsilon(0.25)); // it overshoots a little
    CHECK(stop_push(slow, device, none).device > balance * 0.99);
    CHECK(stop_push(slow, device, none).body == stop_push(slow, device, none).device);
    // A body on a spring: contact holds it where spring and contact have the same force.
    vxs_coupling_config spring = none;
    spring.kind = VXS_COUPLING_QUASI_STATIC;
    spring.stiffness = 400;
    const Stopped held = stop_push(slow, device, spring);
    CHECK(held.body == doctest::Approx(held.device * 400 / 1400).epsilon(0.01));
    // Through a wall that is thinner than that: nothing stands behind it.
    CHECK(stop_push(push_of(device, 0.02, 0.008, 10, 0.004), device, none).device > 0.0078);
    // The peak force at once takes the hand's and the device's energy in peak less what the hand pushes, and
    // a sample or two more.
    const Push fast = push_of(device, 0.3, 0.1, 1000, 0.2);
    const double best = stop_at_best(fast, device), mass = device.profile.mass + device.arm.mass;
    CHECK(best > 0.5 * mass * 0.09 / (device.profile.peak_force + 5));
    CHECK(best < stop_push(fast, device, none).device);
}

TEST_CASE("a design without a kind takes pt2 where that stops the push, else what cannot be pushed through")
{
    DesignInput input = input_of(3, {"hand"}, 1000);
    input.any_kind = true;
    const vxs_simulated_config device = held_by(input.device, "hand");
    input.pushes = {push_of(device, 0.1, 0.008, 1000, 0.05), push_of(device, 0.05, 0.008, 1000, 0.05)};
    const Design block = design_coupling(input);
    CHECK(block.coupling.kind == VXS_COUPLING_PT2);
    CHECK(block.margins_held);
    REQUIRE(block.push);
    CHECK(block.push->holds());
    CHECK(block.push->speed == 0.1); // the one that comes deeper
    CHECK(block.push->arm == "hand");
    CHECK(block.chosen.starts_with("pt2, since it stops a push at 0.1 m/s into 50 mm after"));

    input.pushes.push_back(push_of(device, 0.1, 0.008, 1000, 0.003));
    const Design plate = design_coupling(input);
    CHECK(plate.coupling.kind == VXS_COUPLING_QUASI_STATIC);
    CHECK(plate.chosen.starts_with("quasi-static, since with pt2 a push at 0.1 m/s into 3 mm comes"));
    CHECK_FALSE(plate.push->holds()); // contact is as soft as the spring
    CHECK(says(plate, "stiffen the contact"));

    input.pushes = {push_of(device, 0.1, 0.008, 1e5, 0.003)};
    input.stiffness = 1e5;
    const Design stiff = design_coupling(input);
    CHECK(stiff.coupling.kind == VXS_COUPLING_QUASI_STATIC);
    CHECK(stiff.chosen == "quasi-static, since no pt2 is stable with contact of 1e+05 N/m");
    CHECK(stiff.push->holds());
    CHECK_FALSE(stiff.refused);

    input.stiffness = 1000;
    input.pushes.clear();
    CHECK(design_coupling(input).chosen ==
          "quasi-static, since nothing is known of what pt2 would have to stop");

    SceneFile scene;
    scene.design = true;
    scene.coupling = CouplingKind::designed;
    scene.assume = "hand";
    const SceneContact thick{[] {
                                 return ContactStiffness{1000, "stated"};
                             },
                             [&] { return std::vector{push_of(device, 0.1, 0.008, 1000, 0.05)}; }};
    CHECK(scene_coupling(scene, input.device, thick).config.kind == VXS_COUPLING_PT2);
    const SceneContact thin{thick.stiffness,
                            [&] { return std::vector{push_of(device, 0.1, 0.008, 1000, 0.003)}; }};
    CHECK(scene_coupling(scene, input.device, thin).text.starts_with("quasi-static 800 N/m (auto)"));
}

TEST_CASE("refusals")
{
    DesignInput input = input_of(3, {"foot"}, 0);
    CHECK(refusal(input, ExitCode::usage) == "no arm 'foot'; there are free, pen, hand and arm");
    input = input_of(3, {}, 0, VXS_COUPLING_SPRING_DAMPER);
    CHECK(refusal(input, ExitCode::unsupported) ==
          "coupling spring-damper has no design: none, pt2 and quasi-static have");
    input = input_of(3, {}, 0);
    input.stiffness = 0;
    CHECK(refusal(input, ExitCode::usage) == "the contact's stiffness must be above zero");
    input = input_of(3, {}, 0);
    input.automatic = false;
    input.coupling.omega0 = 1e6;
    CHECK(refusal(input, ExitCode::invalid).starts_with("coupling: "));
    CHECK_THROWS_AS(simulated_device("sim:none"), Failure);
    CHECK_THROWS_AS(simulated_device("omega-3"), Failure);
}

int main(int argc, char **argv)
{
    if (argc > 1 && std::strcmp(argv[1], "full") == 0) ticks = 1'000'000;
    doctest::Context context;
    return context.run();
}
