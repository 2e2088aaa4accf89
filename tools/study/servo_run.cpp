// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/servo_run.hpp"

#include "plan/memory.hpp"
#include "study/simulated_loop.hpp"

#include "cli/failure.hpp"

#include "voxshell/servo_thread.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <thread>

namespace voxshell {
namespace {

double length(const double v[3])
{
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

/// Adds up what happens, tick by tick.
class Account {
  public:
    Account(ServoRun &run, const RunOptions &options) : run_(run), options_(options) {}

    void add(const vxs_servo_trace &row, double t, const Point &hand)
    {
        const double collision = length(row.collision.force), output = length(row.command.force);
        run_.collision_peak = std::max(run_.collision_peak, collision);
        run_.output_peak = std::max(run_.output_peak, output);
        run_.points_most = std::max(run_.points_most, row.points);
        run_.probed_most = std::max(run_.probed_most, row.probed);
        run_.level_most = std::max(run_.level_most, row.level);
        run_.depth_most = std::max(run_.depth_most, row.depth);
        const double *force = row.command.force;
        const double step[3] = {force[0] - last_[0], force[1] - last_[1], force[2] - last_[2]};
        if (row.tick == next_) run_.step_most = std::max(run_.step_most, length(step));
        std::copy(force, force + 3, last_);
        next_ = row.tick + 1;
        run_.energy_least = std::min(run_.energy_least, row.energy);
        const double ahead[3] = {hand[0] - row.pose.position[0], hand[1] - row.pose.position[1],
                                 hand[2] - row.pose.position[2]};
        run_.reach_most = std::max(run_.reach_most, length(ahead));
        if (row.points > 0) {
            ++run_.contact_ticks;
            sum_ += output;
            run_.output_mean = sum_ / static_cast<double>(run_.contact_ticks);
        }
        run_.flags |= row.flags;
        for (unsigned bit = 0; bit < run_.flag_ticks.size(); ++bit) {
            run_.flag_ticks[bit] += row.flags >> bit & 1u;
        }
        ++run_.ticks;
        if (options_.keep_recording) run_.recording.push_back(row);
        if (options_.keep_rows) {
            const auto point = [](const double v[3]) { return Point{v[0], v[1], v[2]}; };
            run_.rows.push_back({t, point(row.pose.position), hand, point(row.body.position),
                                 point(row.collision.force), point(row.collision.torque),
                                 point(row.command.force), row.points, row.flags, row.energy});
        }
    }

  private:
    ServoRun &run_;
    const RunOptions &options_;
    double sum_ = 0;
    double last_[3] = {0, 0, 0};
    std::uint64_t next_ = 0; ///< rows that were dropped leave a gap
};

Durations durations_of(const vxs_servo_thread_histogram &histogram)
{
    std::uint64_t total = 0;
    for (const std::uint64_t count : histogram.bins) {
        total += count;
    }
    const auto at = [&](double share) {
        std::uint64_t seen = 0;
        for (unsigned bin = 0; bin < VXS_SERVO_THREAD_BINS; ++bin) {
            seen += histogram.bins[bin];
            if (static_cast<double>(seen) >= share * static_cast<double>(total)) {
                return std::min(1e3 * std::ldexp(1.0, static_cast<int>(bin)),
                                static_cast<double>(histogram.max_ns));
            }
        }
        return static_cast<double>(histogram.max_ns);
    };
    return {at(0.5), at(0.99), at(0.999), static_cast<double>(histogram.max_ns)};
}

/// The device that is run, and whether the plan's hand moves it.
struct Held {
    vxs_device *device;
    bool is_simulated;
};

Point place_of(const vxs_servo_trace &row)
{
    return {row.pose.position[0], row.pose.position[1], row.pose.position[2]};
}

void run_virtual(const PlannedServo &planned, const Held &held, vxs_servo *servo, std::uint64_t ticks,
                 ServoRun &run, Account &account, Progress &progress)
{
    std::vector<float> ns;
    ns.reserve(ticks);
    vxs_device_state state{};
    vxs_device_command command{};
    vxs_servo_trace row{};
    for (std::uint64_t n = 0; n < ticks; ++n) {
        const double t = static_cast<double>(n) / planned.rate;
        const Pose hand = planned.hand.at(t);
        if (held.is_simulated) move_hand(held.device, hand);
        const auto begin = Clock::now();
        vxs_device_exchange(held.device, &command, &state, nullptr);
        vxs_servo_tick(servo, &state, &command, &row);
        ns.push_back(ns_since(begin));
        account.add(row, t, held.is_simulated ? hand.position : place_of(row));
        progress.advance(1);
        if (n % 256 == 0) {
            progress.check();
        }
    }
    run.tick = durations(ns);
}

/// What the servo thread needs to move the hand without computing: the whole path, made before.
struct Hands {
    vxs_device *device;
    std::vector<Pose> poses;
};

extern "C" void move_to_tick(void *user, std::uint64_t tick)
{
    const auto *hands = static_cast<const Hands *>(user);
    move_hand(hands->device, hands->poses[std::min<std::size_t>(tick, hands->poses.size() - 1)]);
}

/// A file for other processes, while this lives.
class Live {
  public:
    explicit Live(const std::string &path)
    {
        if (path.empty()) return;
        if (const vxs_result result = vxs_live_create(&live_, path.c_str()); result != VXS_OK)
            throw Failure(ExitCode::system, path, fmt::format("live: {}", vxs_result_text(result)));
    }
    ~Live() { vxs_live_close(&live_); }
    Live(const Live &) = delete;
    Live &operator=(const Live &) = delete;
    vxs_live *get() { return live_.memory ? &live_ : nullptr; }

  private:
    vxs_live live_{};
};

void run_realtime(const PlannedServo &planned, const Held &held, vxs_servo *servo, std::uint64_t ticks,
                  const RunOptions &options, ServoRun &run, Account &account, Progress &progress)
{
    Hands hands{held.device, {}};
    hands.poses.reserve(ticks);
    for (std::uint64_t n = 0; n < ticks; ++n) {
        hands.poses.push_back(planned.hand.at(static_cast<double>(n) / planned.rate));
    }
    constexpr std::uint32_t ring_rows = 1 << 14;
    const Memory ring(vxs_trace_memory(ring_rows)), room(vxs_servo_thread_memory());
    vxs_servo_thread_config config;
    vxs_servo_thread_config_default(&config);
    config.rate_hz = planned.rate;
    config.max_ticks = ticks;
    Live live(options.live);
    config.device = held.device;
    config.servo = servo;
    config.live = live.get();
    config.on_tick = held.is_simulated ? move_to_tick : nullptr;
    config.user = &hands;
    require_ok(vxs_trace_init(ring.get(), ring.size(), ring_rows, &config.trace), "trace");
    vxs_servo_thread *thread = nullptr;
    require_ok(vxs_servo_thread_start(room.get(), room.size(), &config, &thread), "--realtime");

    struct Stop {
        vxs_servo_thread *thread;
        ~Stop() { vxs_servo_thread_stop(thread); }
    };
    std::vector<vxs_servo_trace> rows(1024);
    vxs_servo_thread_status status{};
    {
        const Stop stop{thread};
        for (bool running = true; running;) {
            vxs_servo_thread_get(thread, &status);
            running = status.running; // asked first: what it left in the ring is drained once more
            for (std::size_t count; (count = vxs_trace_drain(config.trace, rows.data(), rows.size())) > 0;) {
                for (std::size_t n = 0; n < count; ++n) {
                    const std::size_t tick = std::min<std::size_t>(rows[n].tick, hands.poses.size() - 1);
                    account.add(rows[n], static_cast<double>(rows[n].tick) / planned.rate,
                                held.is_simulated ? hands.poses[tick].position : place_of(rows[n]));
                }
                progress.advance(count);
            }
            progress.check();
            std::this_thread::sleep_for(std::chrono::milliseconds(running ? 20 : 0));
        }
        vxs_servo_thread_get(thread, &status);
    }
    run.tick = durations_of(status.work);
    run.realtime = {status.scheduling_text, status.memory_text, status.missed,
                    vxs_trace_dropped(config.trace), durations_of(status.lateness)};
}

/// Hardware's middle is where the hand's path begins, and no more is asked of it than it has.
void fit(vxs_servo_config &config, const PlannedServo &planned, const vxs_device_caps &caps)
{
    const Point start = planned.hand.at(0).position;
    std::ranges::copy(start, config.mount.position);
    if (caps.peak_force > 0) config.max_force = std::min(config.max_force, caps.peak_force);
    if (caps.peak_torque > 0) config.max_torque = std::min(config.max_torque, caps.peak_torque);
}

constexpr const char *without_guards = "has motors, and the scene lists its guards without start-inside or "
                                       "without soft-start: a hand could be hit at the "
                                       "start; add both to \"guards\", or leave the key out";

} // namespace

ServoRun run_servo(const PlannedServo &planned, const RunOptions &options, Progress &progress)
{
    const std::uint64_t ticks = ticks_of(planned, options.seconds);
    std::optional<Simulated> simulated;
    if (!options.device) simulated.emplace(planned);
    const Held held{options.device ? options.device->get() : simulated->device, !options.device};
    ServoRun run;
    vxs_servo_config config = planned.config;
    if (options.device && options.device->is_hardware()) fit(config, planned, held.device->caps);
    const Servo servo(config);
    const std::string &name = options.device ? options.device->settings().name : planned.device;
    if (vxs_servo_may_drive(servo.servo, &held.device->caps) != VXS_OK)
        throw Failure(ExitCode::requirement, name, without_guards);
    require_ok(vxs_device_arm(held.device), name);
    progress.stage("servo", ticks);
    run.budget_points = config.contact.most_points;
    Account account(run, options);
    if (options.realtime)
        run_realtime(planned, held, servo.servo, ticks, options, run, account, progress);
    else
        run_virtual(planned, held, servo.servo, ticks, run, account, progress);
    if (options.device) {
        vxs_device_state state{};
        vxs_device_exchange(held.device, nullptr, &state, nullptr);
        run.device_end = device_state_name(state.state);
        if (state.fault) run.device_end += fmt::format(", {}", device_fault_name(state.fault));
        vxs_device_disarm(held.device);
    }
    return run;
}

std::string flag_name(unsigned bit)
{
    switch (1u << bit) {
    case VXS_CONTACT_DEEP:
        return "deep";
    case VXS_CONTACT_MEAN_CANCELLED:
        return "mean-cancelled";
    case VXS_CONTACT_OUT_OF_MAP:
        return "out-of-map";
    case VXS_CONTACT_OVERFLOW:
        return "overflow";
    case VXS_CONTACT_INVALID:
        return "invalid";
    case VXS_CONTACT_WRONG_SKIP:
        return "wrong-skip";
    case VXS_CONTACT_OVER_BUDGET:
        return "over-budget";
    case VXS_CONTACT_SOFTENED:
        return "softened";
    case VXS_SERVO_OFF:
        return "off";
    case VXS_SERVO_RAMPING:
        return "ramping";
    case VXS_SERVO_START_IN_CONTACT:
        return "start-in-contact";
    case VXS_SERVO_SLEWED:
        return "slewed";
    case VXS_SERVO_SATURATED:
        return "saturated";
    case VXS_SERVO_DEVICE_STALE:
        return "stale";
    case VXS_SERVO_MISSED:
        return "missed";
    case VXS_SERVO_DEVICE_LOST:
        return "lost";
    case VXS_SERVO_FAULT:
        return "fault";
    case VXS_SERVO_DAMPED:
        return "damped";
    case VXS_SERVO_TELEPORT:
        return "teleport";
    default:
        return "";
    }
}

} // namespace voxshell
