// SPDX-License-Identifier: GPL-3.0-or-later
// A plan and its assets, loaded by the runtime: what a run is made from, whether a scene or a .plan was
// given.
#pragma once

#include "plan/memory.hpp"
#include "plan/plan_file.hpp"
#include "scene/scene_file.hpp"

#include "voxshell/plan.h"

#include <optional>
#include <span>
#include <string>

namespace voxshell {

class PlannedServo {
  public:
    /// assets: open, in the plan's order; they must outlive this. name: of the plan, for refusals. Throws
    /// Failure: invalid (assets of another plan, with both hashes; numbers that the runtime refuses; no
    /// hand), unsupported (an effect that this build does not know).
    PlannedServo(const PlanFile &plan, std::span<const vxs_asset> assets, const std::string &name);
    PlannedServo(const PlannedServo &) = delete;
    PlannedServo &operator=(const PlannedServo &) = delete;

    const vxs_pointshell &shell() const { return *config.shell; }
    const vxs_voxmap &map() const { return *config.statics[0].map; }

    vxs_servo_config config; ///< with what the plan's budget buys on this machine; borrows from this
    std::string device, arm; ///< "sim:NAME", "hand"
    std::string coupling;    ///< "pt2 5 Hz"
    double rate;             ///< [Hz]
    HandPath hand;

  private:
    std::optional<Memory> bytes_, room_;
    vxs_asset asset_{};
};

} // namespace voxshell
