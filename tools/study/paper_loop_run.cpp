// SPDX-License-Identifier: GPL-3.0-or-later
// Contact through a coupling: at a prescribed pose (figure 11), and with a device that a hand holds (figure
// 12, walls).
#include "plan/memory.hpp"
#include "plan/scene_contact.hpp"
#include "plan/scene_plan.hpp"
#include "plan/simulated_device.hpp"
#include "study/bodies.hpp"
#include "study/open_part.hpp"
#include "study/paper_path.hpp"
#include "study/paper_run.hpp"
#include "study/servo_run.hpp"

#include "voxshell/servo.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace voxshell {
namespace {

constexpr double pi = std::numbers::pi, nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double rest_seconds = 0.5, clear_way = 0.02, hold_seconds = 1.5, slide_seconds = 4;
constexpr double settle_seconds = 0.5; ///< of the approach, not counted in what is felt along the path

/// Outwards, where the object meets what stands first; and a point of the surface there.
struct Place {
    Point out, at;
};

Place place_of(const Scenario &scenario, const Draw &draw)
{
    const double e = scenario.voxel;
    if (scenario.stands == Stands::plate) {
        return {tilted({0, 0, 1}), tilted({e * draw.offset[1], e * draw.offset[2], 0})};
    }
    const double turn = 2 * pi * draw.offset[0];
    const Point out{std::cos(turn), std::sin(turn), 0};
    return {out, {cup_outer * out[0], cup_outer * out[1], cup_height / 2 + e * draw.offset[1]}};
}

/// How deep a ball at `middle` is [m].
double depth_of(const Scenario &scenario, const Point &middle)
{
    const double high = scenario.stands == Stands::plate ? dot(middle, tilted({0, 0, 1}))
                                                         : std::hypot(middle[0], middle[1]) - cup_outer;
    return scenario.radius - high;
}

HandPath hand_path(const Scenario &scenario, const Place &place, const Draw &draw, double speed)
{
    const auto pose = [&](double high) {
        Pose p;
        for (std::size_t i = 0; i < 3; ++i)
            p.position[i] = place.at[i] + (scenario.radius + high) * place.out[i];
        p.rotation = {draw.orientation[1], draw.orientation[2], draw.orientation[3], draw.orientation[0]};
        return p;
    };
    const double depth = scenario.motion == Motion::push ? push_depth : slide_depth;
    const double clear = std::max(clear_way, 0.1 * speed);
    HandPath path;
    path.keyframes.push_back({0, pose(clear), {}});
    path.keyframes.push_back({rest_seconds, pose(clear), {}});
    const double there = rest_seconds + (clear + depth) / speed;
    path.keyframes.push_back({there, pose(-depth), {}});
    if (scenario.motion == Motion::push) {
        path.keyframes.push_back({there + hold_seconds, pose(-depth), {}});
    } else {
        const double angle = speed * slide_seconds / (cup_outer + scenario.radius - depth);
        path.keyframes.push_back(
            {there + slide_seconds, pose(-depth), HandPath::Keyframe::Turn{{0, 0, 0}, {0, 0, 1}, angle}});
    }
    return path;
}

ContactLaw law_of(std::uint32_t law)
{
    return law == VXS_CONTACT_ORIGINAL  ? ContactLaw::original
           : law == VXS_CONTACT_AVERAGE ? ContactLaw::average
           : law == VXS_CONTACT_PATCH   ? ContactLaw::patch
                                        : ContactLaw::gradient;
}

/// As a scene file would say it, without a hand.
SceneFile scene_of(const RunKey &key)
{
    const Scenario &scenario = *key.scenario;
    const Variant &how = key.how();
    SceneFile scene;
    scene.path = scenario.id;
    scene.voxel = scenario.voxel;
    scene.law = law_of(how.method.law);
    scene.field = how.method.field == VXS_CONTACT_LAYERS     ? ContactField::layers
                  : how.method.field == VXS_CONTACT_DISTANCE ? ContactField::distance
                                                             : ContactField::surface;
    scene.stiffness = 1 / scenario.voxel;
    scene.device = scenario.device;
    scene.assume = "hand";
    scene.effects = read_effects({}, {});
    scene.radius = 0.02;
    switch (how.coupled.kind) {
    case Coupled::none:
        scene.coupling = CouplingKind::none;
        break;
    case Coupled::spring_damper:
        scene.coupling = CouplingKind::spring_damper;
        scene.damping = 0.7;
        break;
    case Coupled::pt2:
        scene.frequency = how.coupled.hertz;
        break;
    case Coupled::automatic:
        scene.coupling = CouplingKind::designed;
        scene.design = true;
        break;
    }
    return scene;
}

double carried(const vxs_simulated_config &device, const vxs_coupling_config &coupling)
{
    if (coupling.kind != VXS_COUPLING_PT2 && coupling.kind != VXS_COUPLING_NONE) return nothing;
    vxs_simulated_config held = device;
    held.arm = *vxs_simulated_arm_named("hand");
    return hunting_stiffness(held, coupling);
}

PlannedAsset planned(const vxs_asset &asset, const char *name)
{
    PlannedAsset out{name, {}};
    std::ranges::copy(vxs_asset_header(&asset)->content_hash, out.content_hash.begin());
    return out;
}

LoopRun empty(const RunKey &key)
{
    LoopRun run{};
    run.key = key;
    run.contact_stiffness = run.largest_stiffness = run.bound = run.energy = run.deepest = run.flagged_deep =
        nothing;
    return run;
}

bool is_drawn(const RunKey &key)
{
    return key.seed == 1 && std::string(key.scenario->group) != "wall";
}

} // namespace

LoopRun run_coupled(const RunKey &key, const OpenPart &stands, const OpenPart &moves)
{
    const vxs_pointshell &shell = moves.shell;
    const Scenario &scenario = *key.scenario;
    const Path path(scenario, key.level_value(), key.seed);
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = key.how().method.law;
    config.field = key.how().method.field;
    config.stiffness = 1 / scenario.voxel;
    config.most_stiffness = std::numeric_limits<double>::max(); // bounds nothing, and is told
    const Memory room(vxs_contact_memory(&shell, 1)), other(vxs_contact_memory(&shell, 1)),
        filter(vxs_coupling_memory());
    vxs_contact *direct = nullptr, *contact = nullptr;
    vxs_contact_init(room.get(), room.size(), &shell, 1, &direct);
    vxs_contact_init(other.get(), other.size(), &shell, 1, &contact);
    const vxs_contact_static statics{&stands.map, nullptr};
    LoopRun run = empty(key);
    std::vector<double> input, output;
    run.contact_stiffness = 0;
    for (std::size_t tick = 0; tick < path.ticks(); ++tick) {
        const Path::Step step = path.at(tick);
        vxs_contact_result result;
        vxs_contact_evaluate(direct, &statics, 1, &step.pose, &config, &result);
        input.push_back(along(step, result.wrench.force)[0]);
        run.contact_stiffness = std::max(run.contact_stiffness, result.stiffness);
    }
    const vxs_simulated_config device = simulated_device(scenario.device, study_rate);
    const SceneContact known{[&] {
                                 return ContactStiffness{run.contact_stiffness, "along the path"};
                             },
                             [] { return std::vector<Push>(); }};
    const SceneCoupling coupled = scene_coupling(scene_of(key), device, known);
    run.coupling = coupled.text;
    run.largest_stiffness = carried(device, coupled.config);
    vxs_coupling *coupling = nullptr;
    if (vxs_coupling_init(filter.get(), filter.size(), &coupled.config, &coupling) != VXS_OK)
        throw Failure(ExitCode::bug, scenario.id, "no coupling");
    const vxs_pose start = path.at(0).pose;
    vxs_coupling_reset(coupling, &start);
    config.most_stiffness = 0;
    std::vector<ForceSample> felt;
    for (std::size_t tick = 0; tick < path.ticks(); ++tick) {
        const Path::Step step = path.at(tick);
        vxs_contact_result result;
        do {
            vxs_pose object;
            vxs_coupling_pose(coupling, &step.pose, &object);
            vxs_contact_evaluate(contact, &statics, 1, &object, &config, &result);
        } while (vxs_coupling_refine(coupling, &result.wrench, result.depth, &step.pose));
        vxs_wrench out;
        vxs_coupling_step(coupling, &result.wrench, &step.pose, &out);
        const Point force = along(step, out.force), collision = along(step, result.wrench.force);
        output.push_back(force[0]);
        run.collision_peak = std::max(run.collision_peak, std::sqrt(dot(collision, collision)));
        run.output_peak = std::max(run.output_peak, std::sqrt(dot(force, force)));
        if (step.progress >= approach_seconds + settle_seconds) {
            felt.push_back({force,
                            along(step, out.torque),
                            {1, 0, 0},
                            {},
                            result.points,
                            (result.flags & VXS_CONTACT_DEEP) != 0,
                            false});
        }
        if (is_drawn(key)) run.time.push_back(step.progress);
    }
    run.response = response_metrics(input, output, study_rate);
    run.felt = force_metrics(felt, study_rate, path.radius(), path.crossing_hz(), false);
    if (is_drawn(key)) {
        run.collision = std::move(input);
        run.output = std::move(output);
    }
    return run;
}

LoopRun run_loop(const RunKey &key, const OpenPart &stands, const OpenPart &moves)
{
    const Scenario &scenario = *key.scenario;
    const Draw d = draw(key.seed);
    const Place place = place_of(scenario, d);
    SceneFile scene = scene_of(key);
    scene.hand = hand_path(scenario, place, d, key.speed_value());
    LoopRun run = empty(key);
    vxs_simulated_config device = simulated_device(scenario.device, study_rate);
    device.arm = *vxs_simulated_arm_named(scene.arm.c_str());
    run.contact_stiffness = contact_stiffness(scene, stands.map, moves.shell).value;
    if (key.how().coupled.bounded) {
        scene.most_stiffness = run.bound =
            carried(device, scene_coupling(scene, device, {}).config) / 2; // of a pt2 that is given
    }
    const PlannedAsset standing = planned(stands.map_file(), "stands.voxmap");
    const PlanFile plan = scene_plan(scene, scene.device, std::span(&standing, 1),
                                     planned(moves.shell_file(), "moves.pointshell"),
                                     scene_contact(scene, stands.map, moves.shell), {});
    const vxs_asset assets[] = {stands.map_file(), moves.shell_file()};
    const PlannedServo loop(plan, assets, scenario.id);
    run.coupling = loop.coupling;
    run.largest_stiffness = carried(device, loop.config.coupling);

    RunOptions options;
    options.seconds = scene.hand.keyframes.back().t;
    options.keep_rows = true;
    Progress silent;
    const ServoRun servo = run_servo(loop, options, silent);
    run.collision_peak = servo.collision_peak;
    run.output_peak = servo.output_peak;
    run.tick = servo.tick;
    const auto bit = [&](std::uint32_t flag) {
        return static_cast<double>(servo.flag_ticks[static_cast<std::size_t>(std::countr_zero(flag))]);
    };
    run.saturated = bit(VXS_SERVO_SATURATED) / study_rate;
    run.flagged_deep =
        servo.contact_ticks ? bit(VXS_CONTACT_DEEP) / static_cast<double>(servo.contact_ticks) : 0;

    const double thick =
        scenario.stands == Stands::plate ? key.level_value() * scenario.voxel : cup_outer - cup_inner;
    run.deepest = -std::numeric_limits<double>::infinity();
    std::vector<Point> positions, forces;
    std::vector<double> input, output;
    std::vector<ForceSample> felt;
    double touched = -1;
    for (const TraceRow &row : servo.rows) {
        run.deepest = std::max(run.deepest, depth_of(scenario, row.body));
        positions.push_back(row.device);
        forces.push_back(row.output_force);
        input.push_back(std::sqrt(dot(row.collision_force, row.collision_force)));
        output.push_back(std::sqrt(dot(row.output_force, row.output_force)));
        if (touched < 0 && row.contacts > 0) touched = row.t;
        if (touched >= 0 && row.t >= touched + settle_seconds) {
            Point out = place.out, across{-out[1], out[0], 0};
            if (scenario.stands == Stands::cup) {
                const double r = std::hypot(row.device[0], row.device[1]);
                out = r > 0 ? Point{row.device[0] / r, row.device[1] / r, 0} : out;
                across = {-out[1], out[0], 0};
            } else {
                across = tilted({1, 0, 0});
            }
            const Point third{out[1] * across[2] - out[2] * across[1],
                              out[2] * across[0] - out[0] * across[2],
                              out[0] * across[1] - out[1] * across[0]};
            const Point &f = row.output_force;
            felt.push_back({{dot(f, out), dot(f, across), dot(f, third)},
                            {},
                            {1, 0, 0},
                            {},
                            row.contacts,
                            false,
                            false});
        }
        if (is_drawn(key)) run.time.push_back(row.t - rest_seconds);
    }
    run.through = run.deepest > thick;
    run.energy = least_energy(positions, forces, device.delay_samples);
    run.response = response_metrics(input, output, study_rate);
    run.felt = force_metrics(felt, study_rate, scenario.radius, 0, false);
    if (is_drawn(key)) {
        run.collision = std::move(input);
        run.output = std::move(output);
    }
    return run;
}

} // namespace voxshell
