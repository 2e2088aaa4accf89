// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/watched_servo.hpp"

#include <algorithm>

namespace voxshell {

std::uint32_t stage_named(std::string_view name)
{
    vxs_servo_stage stage;
    for (std::uint32_t n = 0; vxs_servo_stage_at(n, &stage) == VXS_OK; ++n)
        if (name == stage.name) return n;
    return ByStage::none;
}

ByStage WatchCost::taken_from(const TickShares &shares) const
{
    ByStage left = shares.taken;
    for (std::uint32_t n = 0; n <= ByStage::most; ++n)
        left[n] -= inside * shares.told[n] + around * shares.held[n];
    return left;
}

WatchedServo::WatchedServo(const vxs_servo_config &config) : servo_(config), memory_(vxs_servo_watch_memory())
{
    const vxs_servo_watch watch = {before, after, this};
    require_ok(vxs_servo_watch_stages(servo_.servo, memory_.get(), memory_.size(), &watch), "servo");
}

std::uint64_t WatchedServo::now() const
{
    if (counter_) return counter_->so_far();
    return static_cast<std::uint64_t>(Clock::now().time_since_epoch().count());
}

/// The same few instructions each time, whatever the depth: they are taken away again.
void WatchedServo::turn_to(std::uint32_t depth)
{
    const std::uint64_t at = now();
    taken_[open_[depth_]] += at - since_;
    since_ = at;
    depth_ = depth;
    if (counter_) counter_->stepping(open_[depth] != passed_over_);
}

void WatchedServo::before(void *user, std::uint32_t stage)
{
    auto &watched = *static_cast<WatchedServo *>(user);
    ++watched.told_[stage];
    ++watched.held_[watched.open_[watched.depth_]];
    watched.open_[watched.depth_ + 1] = stage;
    watched.turn_to(watched.depth_ + 1);
}

void WatchedServo::after(void *user, std::uint32_t)
{
    auto &watched = *static_cast<WatchedServo *>(user);
    watched.turn_to(watched.depth_ - 1);
}

void WatchedServo::begin(InstructionCount *counter, std::uint32_t passed_over)
{
    counter_ = counter;
    passed_over_ = passed_over;
    taken_.fill(0);
    told_.fill(0);
    held_.fill(0);
    open_[0] = ByStage::around;
    depth_ = 0;
}

TickShares WatchedServo::shares(const vxs_servo_trace &row) const
{
    TickShares out;
    std::copy(taken_.begin(), taken_.end(), out.taken.of.begin());
    std::copy(told_.begin(), told_.end(), out.told.of.begin());
    std::copy(held_.begin(), held_.end(), out.held.of.begin());
    out.body = row.body;
    return out;
}

TickShares WatchedServo::time(const vxs_device_state &state)
{
    vxs_servo_trace row{};
    begin(nullptr, ByStage::none);
    since_ = now();
    vxs_servo_tick(servo_.servo, &state, &command_, &row);
    turn_to(0);
    return shares(row);
}

TickShares WatchedServo::count(const vxs_device_state &state, InstructionCount &counter,
                               std::uint32_t passed_over)
{
    vxs_servo_trace row{};
    begin(&counter, passed_over);
    since_ = 0;
    const std::uint64_t all = counter.of([&] { vxs_servo_tick(servo_.servo, &state, &command_, &row); });
    taken_[ByStage::around] += all - since_;
    return shares(row);
}

namespace {

/// Torque on the hand is a stage that does nothing itself, and goes with every servo.
std::uint32_t idle_stage(vxs_servo_config &config, vxs_effect &torque)
{
    vxs_effect_default(VXS_EFFECT_TORQUE, &torque);
    config.effects = &torque;
    config.effect_count = 1;
    return stage_named("torque");
}

double sum(const ByStage &shares)
{
    double all = 0;
    for (const double share : shares.of) all += share;
    return all;
}

} // namespace

WatchCost watch_cost(vxs_servo_config config, const vxs_device_state &state, InstructionCount &counter)
{
    vxs_effect torque;
    const std::uint32_t idle = idle_stage(config, torque);
    const Servo plain(config);
    WatchedServo watched(config);
    vxs_device_command command{};
    vxs_servo_trace row{};
    const auto bare =
        static_cast<double>(counter.of([&] { vxs_servo_tick(plain.servo, &state, &command, &row); }));
    const TickShares shares = watched.count(state, counter, ByStage::none);
    WatchCost cost;
    cost.inside = shares.taken[idle] / shares.told[idle];
    cost.around = (sum(shares.taken) - bare) / sum(shares.told) - cost.inside;
    return cost;
}

WatchCost watch_cost_ns(vxs_servo_config config, const vxs_device_state &state)
{
    constexpr int repeats = 1000;
    vxs_effect torque;
    const std::uint32_t idle = idle_stage(config, torque);
    const Servo plain(config);
    WatchedServo watched(config);
    vxs_device_command command{};
    vxs_servo_trace row{};
    double inside = 1e9, around = 1e9, bare = 1e9, told = 1;
    for (int n = 0; n < repeats; ++n) {
        const auto begin = Clock::now();
        vxs_servo_tick(plain.servo, &state, &command, &row);
        bare = std::min(bare, double{ns_since(begin)});
        const TickShares shares = watched.time(state);
        inside = std::min(inside, shares.taken[idle] / shares.told[idle]);
        told = sum(shares.told);
        around = std::min(around, sum(shares.taken));
    }
    return {inside, std::max((around - bare) / told - inside, 0.0)};
}

} // namespace voxshell
