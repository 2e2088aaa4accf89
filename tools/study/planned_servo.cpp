// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/planned_servo.hpp"

#include "cli/failure.hpp"
#include "plan/scene_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace voxshell {
namespace {

[[noreturn]] void refuse(vxs_result result, const vxs_plan_issue &issue, const vxs_plan &plan,
                         const std::string &name)
{
    const auto hash = [](const std::uint8_t(&bytes)[32]) {
        Sha256 value;
        std::ranges::copy(bytes, value.begin());
        return hex(value);
    };
    if (result == VXS_PLAN) {
        throw Failure(
            ExitCode::invalid, name,
            fmt::format("was made for {} with content {}, and this one has {}; convert the scene again",
                        text_of(plan.assets[issue.entry].name), hash(issue.expected), hash(issue.found)));
    }
    if (issue.is_effect) {
        throw Failure(
            result == VXS_UNSUPPORTED ? ExitCode::unsupported : ExitCode::invalid, name,
            fmt::format("effect {}: {}", text_of(plan.effects[issue.entry].kind), vxs_result_text(result)));
    }
    throw Failure(ExitCode::invalid, name, vxs_result_text(result));
}

/// How many points contact can look at in so many seconds on this machine, at least one.
std::uint32_t points_for(double budget, const vxs_pointshell &shell)
{
    const Memory room(vxs_contact_memory(&shell, 1));
    vxs_contact *contact = nullptr;
    if (vxs_contact_init(room.get(), room.size(), &shell, 1, &contact) != VXS_OK)
        throw Failure(ExitCode::bug, "", "contact");
    return static_cast<std::uint32_t>(std::clamp(budget / vxs_contact_point_cost(contact), 1.0, 4e9));
}

} // namespace

PlannedServo::PlannedServo(const PlanFile &file, std::span<const vxs_asset> assets, const std::string &name)
    : device(text_of(file.info.device)), arm(text_of(file.info.arm)), rate(file.info.rate),
      hand(hand_of(file.hand))
{
    if (hand.keyframes.empty()) throw Failure(ExitCode::invalid, name, "has no hand: nothing would move");
    const std::vector<std::uint8_t> bytes = plan_bytes(file);
    bytes_.emplace(bytes.size());
    std::memcpy(bytes_->get(), bytes.data(), bytes.size());
    vxs_plan plan;
    if (assets.size() != file.assets.size() ||
        vxs_asset_from_memory(bytes_->get(), bytes.size(), nullptr, &asset_, nullptr) != VXS_OK ||
        vxs_plan_open(&asset_, &plan) != VXS_OK) {
        throw Failure(ExitCode::bug, name, "a plan that was checked is refused");
    }
    room_.emplace(vxs_plan_memory(&plan));
    vxs_plan_issue issue;
    const vxs_result result =
        vxs_plan_load(&plan, assets.data(), room_->get(), room_->size(), &config, &issue);
    if (result != VXS_OK) refuse(result, issue, plan, name);
    if (file.info.budget > 0) {
        const unsigned evaluations =
            config.coupling.kind == VXS_COUPLING_QUASI_STATIC ? config.coupling.evaluations : 1;
        config.contact.most_points = points_for(file.info.budget / evaluations, shell());
    }
    coupling = coupling_text(config.coupling, file.info.flags & VXS_PLAN_FLAG_DESIGNED);
}

} // namespace voxshell
