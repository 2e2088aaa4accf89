// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/scene_effects.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace voxshell {
namespace {

/// Number of a constant in its kind's table.
#define CONSTANT(member)                                                                                     \
    static_cast<std::uint32_t>((offsetof(vxs_effect, as.member) - offsetof(vxs_effect, as)) / sizeof(double))

void passivity(const SceneEffect &said, const EffectContext &context, vxs_effect &effect)
{
    const vxs_device_caps &caps = context.caps;
    auto &as = effect.as.passivity;
    if (!said.says(CONSTANT(passivity.most_damping)) && caps.max_damping > 0)
        as.most_damping = caps.max_damping;
    if (!said.says(CONSTANT(passivity.delay))) as.delay = caps.delay_samples;
    constexpr double hand = 0.03; // [m], a turn of the hand counts as so much way
    if (!said.says(CONSTANT(passivity.radius))) as.radius = hand;
    if (!(caps.peak_torque > 0)) as.radius = 0;
}

/// count constants from the first on, unless the scene says one of them.
void take(const SceneEffect &said, std::uint32_t first, std::span<const double> from, vxs_effect &effect)
{
    for (std::uint32_t n = 0; n < from.size(); ++n) {
        if (said.says(first + n)) return;
    }
    std::ranges::copy(from, effect.as.constants + first);
}

void gravity(const SceneEffect &said, const EffectContext &context, vxs_effect &effect)
{
    if (!context.mass) return;
    take(said, CONSTANT(gravity.mass), std::span(&context.mass->mass, 1), effect);
    take(said, CONSTANT(gravity.com), context.mass->com, effect);
}

/// The tensor goes with the mass: a scene that says a mass gets the shape's tensor for that mass.
void inertia(const SceneEffect &said, const EffectContext &context, vxs_effect &effect)
{
    if (!context.mass) return;
    take(said, CONSTANT(inertia.mass), std::span(&context.mass->mass, 1), effect);
    take(said, CONSTANT(inertia.com), context.mass->com, effect);
    std::array<double, 6> tensor = context.mass->inertia;
    if (said.says(CONSTANT(inertia.mass))) {
        for (double &moment : tensor) moment *= effect.as.inertia.mass / context.mass->mass;
    }
    take(said, CONSTANT(inertia.inertia), tensor, effect);
}

/// Kinds whose constants are not all their own affair, and what they need of assets.
const struct {
    std::uint32_t kind;
    void (*resolve)(const SceneEffect &said, const EffectContext &context, vxs_effect &effect);
    bool weighs;                               ///< takes its mass from the object
    double (*distances)(const vxs_effect &of); ///< how far it looks into the distance channel [m]
} needs[] = {
    {VXS_EFFECT_PASSIVITY, passivity, false, nullptr},
    {VXS_EFFECT_GRAVITY, gravity, true, nullptr},
    {VXS_EFFECT_INERTIA, inertia, true, nullptr},
    {VXS_EFFECT_PROXIMITY, nullptr, false, [](const vxs_effect &of) { return of.as.proximity.reach; }},
};

} // namespace

std::vector<vxs_effect> scene_effects(const SceneFile &scene, const EffectContext &context)
{
    std::vector<vxs_effect> effects;
    for (std::uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; ++n) {
        const auto said = std::find_if(scene.effects.begin(), scene.effects.end(),
                                       [&](const SceneEffect &e) { return e.effect.kind == kind; });
        if (said == scene.effects.end()) {
            if (kind == VXS_EFFECT_TORQUE && context.caps.peak_torque > 0)
                vxs_effect_default(kind, &effects.emplace_back());
            continue;
        }
        if (kind == VXS_EFFECT_TORQUE && !(context.caps.peak_torque > 0)) {
            throw Failure(ExitCode::invalid, scene.path.string(),
                          said->place + ": " + context.caps.name +
                              " renders no torque: take \"torque\" out, or another device");
        }
        vxs_effect effect = said->effect;
        for (const auto &each : needs) {
            if (each.kind == kind && each.resolve) each.resolve(*said, context, effect);
        }
        static const vxs_effect_keyframe somewhere{0, vxs_pose_identity(), 0, 0};
        const bool goes = kind == VXS_EFFECT_MOTION; // its keyframes are the plan's
        if (goes) effect.keyframes = &somewhere, effect.keyframe_count = 1;
        const vxs_result checked = vxs_effect_check(&effect);
        if (goes) effect.keyframes = nullptr, effect.keyframe_count = 0;
        if (checked != VXS_OK) {
            throw Failure(ExitCode::invalid, scene.path.string(),
                          said->place + ": " + vxs_result_text(checked));
        }
        effects.push_back(effect);
    }
    return effects;
}

bool asks_for_mass(const SceneFile &scene)
{
    return scene.dynamic.density > 0 && std::ranges::any_of(scene.effects, [](const SceneEffect &effect) {
               return std::ranges::any_of(
                   needs, [&](const auto &each) { return each.kind == effect.effect.kind && each.weighs; });
           });
}

double distance_reach(const SceneFile &scene)
{
    double reach = 0;
    for (const SceneEffect &effect : scene.effects) {
        for (const auto &each : needs) {
            if (each.kind == effect.effect.kind && each.distances)
                reach = std::max(reach, each.distances(effect.effect));
        }
    }
    return reach;
}

} // namespace voxshell
