// SPDX-License-Identifier: GPL-3.0-or-later
// A servo that says of each tick how much of it was in which stage: time, or instructions.
#pragma once

#include "study/instructions.hpp"
#include "study/simulated_loop.hpp"

#include <array>
#include <cstdint>
#include <string_view>

namespace voxshell {

/// One figure for each stage by its number (vxs_servo_stage_at()), and one for what is in none.
struct ByStage {
    static constexpr std::uint32_t most = 32, around = most, none = most + 1;
    std::array<double, most + 1> of{};
    double &operator[](std::uint32_t stage) { return of[stage]; }
    double operator[](std::uint32_t stage) const { return of[stage]; }
};

/// The stage of that name; ByStage::none for none such.
std::uint32_t stage_named(std::string_view name);

/// What a tick took, stage by stage: what is within another one (friction within contact) is its own.
struct TickShares {
    ByStage taken;   ///< [ns] or instructions, with what watching takes of both
    ByStage told;    ///< how often each was begun
    ByStage held;    ///< how often another one was begun within it
    vxs_pose body{}; ///< where contact was evaluated last; of a tick that was counted
};

/// What watching adds: to a stage that is told of, and to what is around that.
struct WatchCost {
    double inside = 0, around = 0;
    double trace = 0; ///< of a tick that is counted: the row that tells where the body was
    ByStage taken_from(const TickShares &shares) const;
};

class WatchedServo {
  public:
    explicit WatchedServo(const vxs_servo_config &config);
    WatchedServo(const WatchedServo &) = delete;
    WatchedServo &operator=(const WatchedServo &) = delete;

    /// [ns]
    TickShares time(const vxs_device_state &state);

    /// In instructions. A stage of that number is not stepped through: 0 for it. ByStage::none: all are.
    TickShares count(const vxs_device_state &state, InstructionCount &counter, std::uint32_t passed_over);

  private:
    static void before(void *user, std::uint32_t stage);
    static void after(void *user, std::uint32_t stage);
    std::uint64_t now() const;
    void turn_to(std::uint32_t depth);
    void begin(InstructionCount *counter, std::uint32_t passed_over);
    TickShares shares() const;

    Servo servo_;
    Memory memory_;
    vxs_device_command command_{};
    InstructionCount *counter_ = nullptr; ///< nothing: the clock
    std::uint32_t passed_over_ = ByStage::none;
    std::array<std::uint64_t, ByStage::most + 1> taken_{};
    std::array<std::uint32_t, ByStage::most + 1> told_{}, held_{};
    std::array<std::uint32_t, ByStage::most + 1> open_{}; ///< stages that are begun; first: around
    std::uint32_t depth_ = 0;
    std::uint64_t since_ = 0;
};

/// Found on a stage that does nothing; the same for all servos. Instructions: exact.
WatchCost watch_cost(const vxs_servo_config &config, const vxs_device_state &state,
                     InstructionCount &counter);
WatchCost watch_cost_ns(const vxs_servo_config &config, const vxs_device_state &state);

} // namespace voxshell
