// SPDX-License-Identifier: GPL-3.0-or-later
// What runs in a tick, and what each stage of it costs: in time, and in instructions.
#pragma once

#include "cli/progress.hpp"
#include "study/durations.hpp"
#include "study/planned_servo.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace voxshell {

/// A part of the loop, measured alone along the hand's path.
struct LoopPart {
    std::string name, what;
    Durations ns;
    std::optional<double> instructions; ///< mean
};

/// A stage of the tick: of an effect (its own stage, and what it changes in others: with it less without) or
/// always there (without what the plan's effects change in it; `around`: what is in no stage).
struct StageCost {
    std::string name, reads, changes;
    bool is_effect = false, is_in = false;
    std::optional<double> ns, instructions; ///< nothing: this scene cannot have it, or not counted
    std::string why_not;                    ///< it is not here
    std::vector<std::pair<std::string, double>> elsewhere; ///< instructions of these in other stages
};

struct TickCosts {
    std::vector<LoopPart> parts;     ///< exchange, contact, coupling, tick
    std::vector<StageCost> stages;   ///< in order of execution, also those that the plan does not ask for
    std::uint32_t counted_ticks = 0; ///< over which instructions are a mean
    std::string not_counted;         ///< why instructions are missing; empty: they are there
};

/// The states of a run of so many seconds (its last 5000 ticks at most) go through servos with and without
/// each effect; what is not in the plan is as by default. Each stage is looked at by itself
/// (study/watched_servo.hpp). Times: the least of several passes for each tick. Instructions: of some of
/// these ticks, spread evenly, stepped through one by one (study/instructions.hpp); of one where ticks are
/// heavy.
TickCosts tick_costs(const PlannedServo &planned, double seconds, Progress &progress);

} // namespace voxshell
