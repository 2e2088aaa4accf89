// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/scene_effects.hpp"

#include <algorithm>
#include <cstddef>

namespace voxshell {
namespace {

/// Number of a constant in its kind's table.
#define CONSTANT(member) static_cast<std::uint32_t>((offsetof(vxs_effect, as.member) - offsetof(vxs_effect, as)) / sizeof(double))

void passivity(const SceneEffect &said, const vxs_device_caps &caps, vxs_effect &effect)
{
    auto &as = effect.as.passivity;
    if (!said.says(CONSTANT(passivity.most_damping)) && caps.max_damping > 0) as.most_damping = caps.max_damping;
    if (!said.says(CONSTANT(passivity.delay))) as.delay = caps.delay_samples;
    constexpr double hand = 0.03; // [m], a turn of the hand counts as so much way
    if (!said.says(CONSTANT(passivity.radius))) as.radius = hand;
    if (!(caps.peak_torque > 0)) as.radius = 0;
}

/// Kinds whose constants are not all their own affair.
const struct {
    std::uint32_t kind;
    void (*resolve)(const SceneEffect &said, const vxs_device_caps &caps, vxs_effect &effect);
} resolvers[] = {
    {VXS_EFFECT_PASSIVITY, passivity},
};

} // namespace

std::vector<vxs_effect> scene_effects(const SceneFile &scene, const vxs_device_caps &caps)
{
    std::vector<vxs_effect> effects;
    for (std::uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; ++n) {
        const auto said = std::find_if(scene.effects.begin(), scene.effects.end(),
                                       [&](const SceneEffect &e) { return e.effect.kind == kind; });
        if (said == scene.effects.end()) continue;
        vxs_effect effect = said->effect;
        for (const auto &each : resolvers) {
            if (each.kind == kind) each.resolve(*said, caps, effect);
        }
        if (const vxs_result checked = vxs_effect_check(&effect); checked != VXS_OK) {
            throw Failure(ExitCode::invalid, scene.path.string(), said->place + ": " + vxs_result_text(checked));
        }
        effects.push_back(effect);
    }
    return effects;
}

} // namespace voxshell
