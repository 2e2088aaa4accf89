// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/servo_run.hpp"

#include "plan/memory.hpp"
#include "study/simulated_loop.hpp"

#include "voxshell/servo_thread.h"

#include <algorithm>
#include <chrono>
#include <cmath>
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
    Account(ServoRun &run, bool keep_rows) : run_(run), keep_rows_(keep_rows) {}

    void add(const vxs_servo_trace &row, double t, const Point &hand)
    {
        const double collision = length(row.collision.force), output = length(row.command.force);
        run_.collision_peak = std::max(run_.collision_peak, collision);
        run_.output_peak = std::max(run_.output_peak, output);
        run_.points_most = std::max(run_.points_most, row.points);
        run_.probed_most = std::max(run_.probed_most, row.probed);
        run_.level_most = std::max(run_.level_most, row.level);
        run_.depth_most = std::max(run_.depth_most, row.depth);
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
        if (keep_rows_) {
            const auto point = [](const double v[3]) { return Point{v[0], v[1], v[2]}; };
            run_.rows.push_back({t, point(row.pose.position), hand, point(row.body.position),
                                 point(row.collision.force), point(row.collision.torque),
                                 point(row.command.force), row.points, row.flags, row.energy});
        }
    }

  private:
    ServoRun &run_;
    bool keep_rows_;
    double sum_ = 0;
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

void run_virtual(const PlannedServo &planned, vxs_device *device, vxs_servo *servo, std::uint64_t ticks,
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
        move_hand(device, hand);
        const auto begin = Clock::now();
        vxs_device_exchange(device, &command, &state, nullptr);
        vxs_servo_tick(servo, &state, &command, &row);
        ns.push_back(ns_since(begin));
        account.add(row, t, hand.position);
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

void run_realtime(const PlannedServo &planned, vxs_device *device, vxs_servo *servo, std::uint64_t ticks,
                  ServoRun &run, Account &account, Progress &progress)
{
    Hands hands{device, {}};
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
    config.device = device;
    config.servo = servo;
    config.on_tick = move_to_tick;
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
                                hands.poses[tick].position);
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

} // namespace

ServoRun run_servo(const PlannedServo &planned, const RunOptions &options, Progress &progress)
{
    const std::uint64_t ticks = ticks_of(planned, options.seconds);
    const Simulated simulated(planned);
    ServoRun run;
    const Servo servo(planned.config);
    require_ok(vxs_device_arm(simulated.device), planned.device);
    progress.stage("servo", ticks);
    run.budget_points = planned.config.contact.most_points;
    Account account(run, options.keep_rows);
    (options.realtime ? run_realtime : run_virtual)(planned, simulated.device, servo.servo, ticks, run,
                                                    account, progress);
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
