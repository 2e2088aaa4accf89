// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/plan_facts.hpp"

#include "voxshell/coupling.h"
#include "voxshell/effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace voxshell {
namespace {

std::string pose_text(const double position[3], const double orientation[4])
{
    return fmt::format("at ({}, {}, {}) m, w x y z ({}, {}, {}, {})", position[0], position[1], position[2],
                       orientation[0], orientation[1], orientation[2], orientation[3]);
}

std::string coupling_text(const vxs_plan_info &info)
{
    std::string text = vxs_coupling_kind_name(info.coupling);
    const auto add = [&](const char *name, double value, const char *unit) {
        if (value != 0) text += fmt::format(", {} {}{}", name, value, unit);
    };
    add("omega0", info.omega0, " rad/s");
    add("damping", info.damping, "");
    add("gain", info.gain, "");
    add("stiffness", info.coupling_stiffness, " N/m");
    add("radius", info.radius, " m");
    add("mass", info.mass, " kg");
    add("evaluations", info.evaluations, "");
    if (info.prewarp) text += ", prewarped";
    if (info.flags & VXS_PLAN_FLAG_DESIGNED) text += " (auto)";
    return text;
}

std::string effect_text(const vxs_plan_effect &effect)
{
    std::uint32_t known = 0;
    const vxs_effect_constant *constants =
        vxs_effect_constants(vxs_effect_kind_named(text_of(effect.kind).c_str()), &known);
    std::string text;
    for (std::uint32_t n = 0; n < effect.constant_count; ++n) {
        text += n ? ", " : "";
        text += n < known ? fmt::format("{} {}{}{}", constants[n].name, effect.constants[n],
                                        *constants[n].unit ? " " : "", constants[n].unit)
                          : fmt::format("{}", effect.constants[n]);
    }
    return text.empty() ? "no constant" : text;
}

} // namespace

const char *law_name(std::uint32_t law)
{
    constexpr const char *names[] = {"original", "average", "gradient", "patch"};
    return names[law - 1];
}

const char *field_name(std::uint32_t field)
{
    constexpr const char *names[] = {"surface", "layers", "distance"};
    return names[field - 1];
}

const char *weighting_name(std::uint32_t weighting)
{
    constexpr const char *names[] = {"count", "count-capped", "area"};
    return names[weighting - 1];
}

std::vector<PlanFact> plan_facts(const PlanFile &plan)
{
    const vxs_plan_info &info = plan.info;
    std::vector<PlanFact> facts;
    facts.push_back({"device", fmt::format("{}, held by {}", text_of(info.device), text_of(info.arm))});
    facts.push_back({"rate", fmt::format("{} Hz", info.rate)});
    std::string contact = fmt::format("law {}, field {}, weighting {}, {} {}", law_name(info.law),
                                      field_name(info.field), weighting_name(info.weighting), info.stiffness,
                                      info.weighting == VXS_PLAN_WEIGHT_AREA ? "N/m^3" : "N/m");
    if (info.most_stiffness > 0) contact += fmt::format(", {} N/m at most", info.most_stiffness);
    if (info.budget > 0) contact += fmt::format(", in {} s", info.budget);
    facts.push_back({"contact", contact});
    facts.push_back({"coupling", coupling_text(info)});
    facts.push_back(
        {"limits", fmt::format("{} N, {} Nm, {} m/s; held {} s, gone after {} s more", info.max_force,
                               info.max_torque, info.max_speed, info.hold_time, info.decay_time)});
    facts.push_back(
        {"mount",
         fmt::format("{}, scale {}", pose_text(info.mount_position, info.mount_orientation), info.scale)});
    facts.push_back({"grip", pose_text(info.grip_position, info.grip_orientation)});
    for (std::size_t n = 0; n < plan.assets.size(); ++n) {
        const vxs_plan_asset &asset = plan.assets[n];
        Sha256 hash;
        std::ranges::copy(asset.content_hash, hash.begin());
        facts.push_back({asset.role == VXS_PLAN_ROLE_DYNAMIC ? "dynamic" : fmt::format("static {}", n),
                         fmt::format("{} {}, {}", text_of(asset.name), hex(hash),
                                     pose_text(asset.position, asset.orientation))});
    }
    for (std::size_t n = 0; n < plan.effects.size(); ++n) {
        facts.push_back({fmt::format("effect {}", text_of(plan.effects[n].kind)),
                         fmt::format("{}: {}", n, effect_text(plan.effects[n]))});
    }
    std::string hand;
    for (const vxs_plan_keyframe &k : plan.hand) {
        hand +=
            fmt::format("{}{} s {}", hand.empty() ? "" : "; ", k.time, pose_text(k.position, k.orientation));
        if (k.move == VXS_PLAN_MOVE_TURN) {
            hand +=
                fmt::format(" by {} rad about ({}, {}, {}) along ({}, {}, {})", k.turn_angle, k.turn_about[0],
                            k.turn_about[1], k.turn_about[2], k.turn_axis[0], k.turn_axis[1], k.turn_axis[2]);
        }
    }
    facts.push_back({"hand", hand.empty() ? "none" : hand});
    std::string moves;
    for (const vxs_plan_motion &m : plan.moves) {
        moves += fmt::format("{}static {} {} s {}", moves.empty() ? "" : "; ", m.asset, m.time,
                             pose_text(m.position, m.orientation));
    }
    if (!moves.empty()) facts.push_back({"motion", moves});
    return facts;
}

} // namespace voxshell
