// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/scene_plan.hpp"

#include "plan/memory.hpp"
#include "plan/scene_contact.hpp"
#include "plan/scene_effects.hpp"
#include "plan/simulated_device.hpp"

#include "voxshell/servo.h"
#include "voxshell/simulated.h"

#include <algorithm>

namespace voxshell {
namespace {

vxs_device_caps caps_of(const vxs_simulated_config &config, const std::string &name)
{
    const Memory room(vxs_simulated_memory());
    vxs_device *device = nullptr;
    if (const vxs_result result = vxs_simulated_open(room.get(), room.size(), &config, &device);
        result != VXS_OK) {
        throw Failure(ExitCode::invalid, "", name + ": " + vxs_result_text(result));
    }
    const vxs_device_caps caps = device->caps;
    vxs_device_close(device);
    return caps;
}

void put_pose(const vxs_pose &pose, double position[3], double orientation[4])
{
    std::ranges::copy(pose.position, position);
    std::ranges::copy(pose.orientation, orientation);
}

void put_contact(const vxs_contact_config &contact, vxs_plan_info &info)
{
    info.law = contact.law;
    info.field = contact.field;
    info.weighting = contact.weighting;
    info.stiffness = contact.stiffness;
    info.most_stiffness = contact.most_stiffness;
}

/// Only what the kind has: so one coupling has one sequence of bytes.
void put_coupling(const vxs_coupling_config &coupling, vxs_plan_info &info)
{
    info.coupling = coupling.kind;
    switch (coupling.kind) {
    case VXS_COUPLING_PT2:
        info.prewarp = coupling.prewarp != 0;
        info.omega0 = coupling.omega0;
        info.damping = coupling.damping;
        info.gain = coupling.gain;
        break;
    case VXS_COUPLING_SPRING_DAMPER:
        info.damping = coupling.damping;
        info.coupling_stiffness = coupling.stiffness;
        info.radius = coupling.radius;
        info.mass = coupling.mass;
        break;
    case VXS_COUPLING_QUASI_STATIC:
        info.coupling_stiffness = coupling.stiffness;
        info.radius = coupling.radius;
        info.evaluations = coupling.evaluations;
        break;
    default:
        break;
    }
}

void put_servo(const vxs_device_caps &caps, vxs_plan_info &info)
{
    vxs_servo_config standard;
    vxs_servo_config_default(&standard);
    info.max_force = caps.peak_force;
    info.max_torque = caps.peak_torque > 0 ? caps.peak_torque : standard.max_torque;
    info.max_speed = standard.max_speed;
    info.hold_time = standard.hold_time;
    info.decay_time = standard.decay_time;
    info.scale = standard.scale;
    put_pose(standard.mount, info.mount_position, info.mount_orientation);
    put_pose(standard.grip, info.grip_position, info.grip_orientation);
}

vxs_plan_asset planned(std::uint32_t role, const PlannedAsset &from)
{
    vxs_plan_asset asset{};
    asset.role = role;
    put_pose(vxs_pose_identity(), asset.position, asset.orientation); // assets are made in the scene's frame
    std::ranges::copy(from.content_hash, asset.content_hash);
    put_text(asset.name, from.name);
    return asset;
}

vxs_plan_effect planned(const vxs_effect &from)
{
    vxs_plan_effect effect{};
    put_text(effect.kind, vxs_effect_kind_name(from.kind));
    vxs_effect_constants(from.kind, &effect.constant_count);
    std::copy_n(from.as.constants, effect.constant_count, effect.constants);
    return effect;
}

vxs_plan_keyframe planned(const HandPath::Keyframe &from)
{
    vxs_plan_keyframe keyframe{};
    keyframe.time = from.t + 0.0; // never -0
    put_pose(as_runtime(from.pose), keyframe.position, keyframe.orientation);
    if (from.turn) {
        keyframe.move = VXS_PLAN_MOVE_TURN;
        std::ranges::copy(from.turn->about, keyframe.turn_about);
        std::ranges::copy(from.turn->axis, keyframe.turn_axis);
        keyframe.turn_angle = from.turn->angle;
    }
    return keyframe;
}

vxs_simulated_config device_of(const SceneFile &scene, const std::string &name)
{
    vxs_simulated_config config = simulated_device(name, scene.rate);
    config.arm = *vxs_simulated_arm_named(scene.arm.c_str());
    return config;
}

/// Of the maps after the first.
std::vector<vxs_plan_motion> moves_of(const SceneFile &scene)
{
    std::vector<vxs_plan_motion> moves;
    std::uint32_t map = 0;
    for (const ScenePart &part : scene.statics) {
        if (part.path.empty()) continue;
        ++map;
        for (const ScenePart::Stop &stop : part.path) {
            vxs_plan_motion &move = moves.emplace_back();
            move.time = stop.t;
            put_pose(as_runtime(stop.pose), move.position, move.orientation);
            move.asset = map;
        }
    }
    return moves;
}

Point point(const double v[3])
{
    return {v[0], v[1], v[2]};
}

} // namespace

PlanFile scene_plan(const SceneFile &scene, const std::string &device, std::span<const PlannedAsset> statics,
                    const PlannedAsset &dynamic, const SceneContact &contact,
                    const std::optional<MassProperties> &mass)
{
    const vxs_simulated_config simulated = device_of(scene, device);
    const vxs_device_caps caps = caps_of(simulated, device);
    PlanFile plan;
    vxs_plan_info &info = plan.info;
    info.rate = scene.rate;
    put_contact(contact_of(scene), info);
    info.budget = scene.budget;
    put_coupling(scene_coupling(scene, simulated, contact).config, info);
    info.flags = scene.design ? VXS_PLAN_FLAG_DESIGNED : 0;
    put_servo(caps, info);
    put_text(info.device, device);
    put_text(info.arm, scene.arm);
    for (const PlannedAsset &each : statics) plan.assets.push_back(planned(VXS_PLAN_ROLE_STATIC, each));
    plan.assets.push_back(planned(VXS_PLAN_ROLE_DYNAMIC, dynamic));
    plan.moves = moves_of(scene);
    for (const vxs_effect &effect : scene_effects(scene, {caps, mass ? &*mass : nullptr}))
        plan.effects.push_back(planned(effect));
    for (const HandPath::Keyframe &keyframe : scene.hand.keyframes) plan.hand.push_back(planned(keyframe));
    return plan;
}

std::optional<MassProperties> scene_mass(const SceneFile &scene, const Scene &dynamic)
{
    if (!asks_for_mass(scene)) return std::nullopt;
    return mass_properties(flatten(dynamic), scene.dynamic.density);
}

void check_scene(const SceneFile &scene)
{
    vxs_simulated_config simulated;
    try {
        simulated = device_of(scene, scene.device);
    } catch (const Failure &failure) {
        throw Failure(ExitCode::invalid, scene.path.string(), std::string("/device: ") + failure.what());
    }
    contact_of(scene);
    design_input(scene, simulated, 1);
    scene_effects(scene, {caps_of(simulated, scene.device), nullptr});
}

HandPath hand_of(std::span<const vxs_plan_keyframe> keyframes)
{
    HandPath path;
    for (const vxs_plan_keyframe &from : keyframes) {
        HandPath::Keyframe keyframe{};
        keyframe.t = from.time;
        keyframe.pose.position = point(from.position);
        const double *q = from.orientation;
        keyframe.pose.rotation = {q[1], q[2], q[3], q[0]};
        if (from.move == VXS_PLAN_MOVE_TURN) {
            keyframe.turn =
                HandPath::Keyframe::Turn{point(from.turn_about), point(from.turn_axis), from.turn_angle};
        }
        path.keyframes.push_back(keyframe);
    }
    return path;
}

} // namespace voxshell
