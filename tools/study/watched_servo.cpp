// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/watched_servo.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

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
    left[ByStage::around] -= trace;
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

TickShares WatchedServo::shares() const
{
    TickShares out;
    std::copy(taken_.begin(), taken_.end(), out.taken.of.begin());
    std::copy(told_.begin(), told_.end(), out.told.of.begin());
    std::copy(held_.begin(), held_.end(), out.held.of.begin());
    return out;
}

TickShares WatchedServo::time(const vxs_device_state &state)
{
    begin(nullptr, ByStage::none);
    since_ = now();
    vxs_servo_tick(servo_.servo, &state, &command_, nullptr);
    turn_to(0);
    return shares();
}

TickShares WatchedServo::count(const vxs_device_state &state, InstructionCount &counter,
                               std::uint32_t passed_over)
{
    vxs_servo_trace row{};
    begin(&counter, passed_over);
    since_ = 0;
    const std::uint64_t all = counter.of([&] { vxs_servo_tick(servo_.servo, &state, &command_, &row); });
    taken_[ByStage::around] += all - since_;
    TickShares out = shares();
    out.body = row.body;
    return out;
}

namespace {

/// A servo with torque on the hand and nothing else, whose stage does nothing itself; watched, and as it is.
class Idle {
  public:
    explicit Idle(const vxs_servo_config &config)
        : config_(only_torque(config)), plain_(config_), watched(config_)
    {
    }

    void plain_tick(const vxs_device_state &state, vxs_servo_trace *row)
    {
        vxs_servo_tick(plain_.servo, &state, &command_, row);
    }

    /// shares: of a watched tick; plain: the same without.
    static WatchCost cost(const TickShares &shares, double plain)
    {
        const std::uint32_t idle = stage_named("torque");
        const auto sum = [](const ByStage &of) { return std::accumulate(of.of.begin(), of.of.end(), 0.0); };
        WatchCost out;
        out.inside = shares.taken[idle] / shares.told[idle];
        out.around = std::max((sum(shares.taken) - plain) / sum(shares.told) - out.inside, 0.0);
        return out;
    }

  private:
    vxs_servo_config only_torque(vxs_servo_config config)
    {
        vxs_effect_default(VXS_EFFECT_TORQUE, &torque_);
        config.effects = &torque_;
        config.effect_count = 1;
        return config;
    }

    vxs_effect torque_{};
    const vxs_servo_config config_;
    Servo plain_;
    vxs_device_command command_{};

  public:
    WatchedServo watched;
};

} // namespace

WatchCost watch_cost(const vxs_servo_config &config, const vxs_device_state &state, InstructionCount &counter)
{
    Idle idle(config);
    vxs_servo_trace row{};
    const auto plain_count = [&](vxs_servo_trace *traced) {
        return static_cast<double>(counter.of([&] { idle.plain_tick(state, traced); }));
    };
    const double traced = plain_count(&row);
    WatchCost out = Idle::cost(idle.watched.count(state, counter, ByStage::none), traced);
    out.trace = plain_count(&row) - plain_count(nullptr);
    return out;
}

WatchCost watch_cost_ns(const vxs_servo_config &config, const vxs_device_state &state)
{
    constexpr int repeats = 1000;
    Idle idle(config);
    TickShares least;
    least.taken.of.fill(std::numeric_limits<double>::infinity());
    double plain = std::numeric_limits<double>::infinity();
    for (int n = 0; n < repeats; ++n) {
        const auto begin = Clock::now();
        idle.plain_tick(state, nullptr);
        plain = std::min(plain, double{ns_since(begin)});
        const TickShares shares = idle.watched.time(state);
        least.told = shares.told;
        for (std::uint32_t stage = 0; stage <= ByStage::most; ++stage)
            least.taken[stage] = std::min(least.taken[stage], shares.taken[stage]);
    }
    return Idle::cost(least, plain);
}

} // namespace voxshell
