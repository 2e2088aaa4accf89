// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/servo_run.hpp"

#include "plan/design.hpp"
#include "plan/memory.hpp"
#include "plan/plan_facts.hpp"
#include "plan/scene_contact.hpp"

#include "voxshell/servo_thread.h"
#include "voxshell/simulated.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <span>
#include <thread>

namespace voxshell {
namespace {

constexpr std::uint64_t most_ticks = 100'000'000;

double length(const double v[3])
{
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

void check(vxs_result result, const std::string &where)
{
    if (result != VXS_OK) {
        throw Failure(ExitCode::invalid, "", where + ": " + vxs_result_text(result));
    }
}

/// A simulated device at the start of the hand's path.
class Simulated {
  public:
    explicit Simulated(const PlannedServo &planned)
        : config(simulated_device(planned.device, planned.rate)), memory_(vxs_simulated_memory())
    {
        const vxs_simulated_arm *arm = vxs_simulated_arm_named(planned.arm.c_str());
        if (!arm) throw Failure(ExitCode::unsupported, "", "no arm \"" + planned.arm + "\"");
        config.arm = *arm;
        config.start = as_runtime(planned.hand.at(0));
        check(vxs_simulated_open(memory_.get(), memory_.size(), &config, &device), planned.device);
    }
    ~Simulated() { vxs_device_close(device); }
    Simulated(const Simulated &) = delete;
    Simulated &operator=(const Simulated &) = delete;
    vxs_simulated_config config;
    vxs_device *device = nullptr;

  private:
    Memory memory_;
};

class Servo {
  public:
    explicit Servo(const vxs_servo_config &config) : memory_(vxs_servo_memory(&config))
    {
        check(vxs_servo_init(memory_.get(), memory_.size(), &config, &servo), "servo");
    }
    vxs_servo *servo = nullptr;

  private:
    Memory memory_;
};

std::uint64_t ticks_of(const PlannedServo &planned, double seconds)
{
    const double ticks = std::round(seconds * planned.rate);
    if (!(ticks >= 1) || ticks > static_cast<double>(most_ticks)) {
        throw Failure(
            ExitCode::usage, "",
            fmt::format("--seconds must give between 1 and {} ticks at {} Hz", most_ticks, planned.rate));
    }
    return static_cast<std::uint64_t>(ticks);
}

void move_hand(vxs_device *device, const Pose &pose)
{
    const vxs_pose target = as_runtime(pose);
    vxs_simulated_hand(device, target.position, target.orientation);
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

using Clock = std::chrono::steady_clock;

float ns_since(Clock::time_point begin)
{
    return std::chrono::duration<float, std::nano>(Clock::now() - begin).count();
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
    check(vxs_trace_init(ring.get(), ring.size(), ring_rows, &config.trace), "trace");
    vxs_servo_thread *thread = nullptr;
    check(vxs_servo_thread_start(room.get(), room.size(), &config, &thread), "--realtime");

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

/// The device's states in the last ticks of a run.
std::vector<vxs_device_state> states_of(const PlannedServo &planned, std::uint64_t ticks, Progress &progress)
{
    constexpr std::uint64_t most_states = 5000;
    const Simulated simulated(planned);
    const Servo servo(planned.config);
    check(vxs_device_arm(simulated.device), planned.device);
    std::vector<vxs_device_state> states;
    vxs_device_state state{};
    vxs_device_command command{};
    progress.stage("record", ticks);
    for (std::uint64_t n = 0; n < ticks; ++n) {
        move_hand(simulated.device, planned.hand.at(static_cast<double>(n) / planned.rate));
        vxs_device_exchange(simulated.device, &command, &state, nullptr);
        vxs_servo_tick(servo.servo, &state, &command, nullptr);
        if (n + most_states >= ticks) states.push_back(state);
        progress.advance(1);
        if (n % 256 == 0) progress.check();
    }
    return states;
}

vxs_servo_config with_effects(vxs_servo_config config, const std::vector<vxs_effect> &effects)
{
    config.effects = effects.data();
    config.effect_count = static_cast<std::uint32_t>(effects.size());
    return config;
}

/// A tick over these states [ns]. Each pass from rest.
double tick_ns(const vxs_servo_config &config, const std::vector<vxs_device_state> &states)
{
    const Servo servo(config);
    vxs_device_command command{};
    const auto begin = Clock::now();
    for (const vxs_device_state &state : states) vxs_servo_tick(servo.servo, &state, &command, nullptr);
    return double{ns_since(begin)} / static_cast<double>(states.size());
}

double difference(const vxs_servo_config &with, const vxs_servo_config &without,
                  const std::vector<vxs_device_state> &states)
{
    constexpr int passes = 7;
    double least_with = std::numeric_limits<double>::infinity(), least_without = least_with;
    for (int pass = 0; pass < passes; ++pass) { // in turn, so that both meet the same machine
        least_without = std::min(least_without, tick_ns(without, states));
        least_with = std::min(least_with, tick_ns(with, states));
    }
    return least_with - least_without;
}

} // namespace

ServoRun run_servo(const PlannedServo &planned, const RunOptions &options, Progress &progress)
{
    const std::uint64_t ticks = ticks_of(planned, options.seconds);
    const Simulated simulated(planned);
    ServoRun run;
    const Servo servo(planned.config);
    check(vxs_device_arm(simulated.device), planned.device);
    progress.stage("servo", ticks);
    run.budget_points = planned.config.contact.most_points;
    Account account(run, options.keep_rows);
    (options.realtime ? run_realtime : run_virtual)(planned, simulated.device, servo.servo, ticks, run,
                                                    account, progress);
    return run;
}

std::vector<Stage> explain_servo(const PlannedServo &planned, const RunOptions &options, Progress &progress)
{
    const std::uint64_t ticks = std::min<std::uint64_t>(ticks_of(planned, options.seconds), 100'000);
    const Simulated simulated(planned);
    const vxs_servo_config &config = planned.config;
    const vxs_pointshell &shell = planned.shell();
    const Servo servo(config);
    check(vxs_device_arm(simulated.device), planned.device);
    const Memory room(vxs_contact_memory(&shell, config.static_count)), filter(vxs_coupling_memory());
    vxs_contact *engine = nullptr;
    check(vxs_contact_init(room.get(), room.size(), &shell, config.static_count, &engine), "contact");
    const Memory levels(vxs_contact_levels_memory(&shell));
    if (config.contact.most_points)
        check(vxs_contact_add_levels(engine, levels.get(), levels.size()), "levels of detail");
    vxs_coupling *coupling = nullptr;
    check(vxs_coupling_init(filter.get(), filter.size(), &config.coupling, &coupling), "coupling");

    std::vector<float> exchange, contact, couple, whole;
    vxs_device_state state{};
    vxs_device_command command{};
    progress.stage("explain", ticks);
    for (std::uint64_t n = 0; n < ticks; ++n) {
        move_hand(simulated.device, planned.hand.at(static_cast<double>(n) / planned.rate));
        auto begin = Clock::now();
        vxs_device_exchange(simulated.device, &command, &state, nullptr);
        exchange.push_back(ns_since(begin));

        vxs_contact_result result;
        begin = Clock::now();
        vxs_contact_evaluate(engine, config.statics, config.static_count, &state.pose, &config.contact,
                             &result);
        contact.push_back(ns_since(begin));

        vxs_wrench out;
        begin = Clock::now();
        vxs_coupling_step(coupling, &result.wrench, &state.pose, &out);
        couple.push_back(ns_since(begin));

        begin = Clock::now();
        vxs_servo_tick(servo.servo, &state, &command, nullptr);
        whole.push_back(ns_since(begin));
        progress.advance(1);
        if (n % 256 == 0) {
            progress.check();
        }
    }
    std::string guards;
    for (const vxs_effect &effect : std::span(config.effects, config.effect_count)) {
        guards += std::string(", ") + vxs_effect_kind_name(effect.kind);
    }
    return {
        {"exchange", fmt::format("{}: pose and velocity in, the last command out", planned.device),
         durations(exchange)},
        {"contact",
         fmt::format("{} points into cells of {} mm, law {}, field {}", shell.point_count,
                     1e3 * planned.map().voxel, law_name(config.contact.law),
                     field_name(config.contact.field)),
         durations(contact)},
        {"coupling",
         planned.coupling +
             (config.coupling.kind == VXS_COUPLING_QUASI_STATIC
                  ? fmt::format(", contact evaluated up to {} times", config.coupling.evaluations)
                  : ", six axes"),
         durations(couple)},
        {"tick", fmt::format("contact, coupling, clamp to {} N{}: the whole of it", config.max_force, guards),
         durations(whole)},
    };
}

std::vector<EffectCost> effect_costs(const PlannedServo &planned, const RunOptions &options,
                                     Progress &progress)
{
    const std::vector<vxs_device_state> states =
        states_of(planned, ticks_of(planned, options.seconds), progress);
    std::vector<EffectCost> costs;
    std::uint32_t kind = 0;
    const char *reads = nullptr;
    progress.stage("effects", 0);
    for (std::uint32_t n = 0; const char *name = vxs_servo_stage_at(n, &kind, &reads); ++n) {
        if (!kind) continue;
        progress.check();
        EffectCost cost{name, reads, false, {}, {}};
        std::vector<vxs_effect> without, with;
        for (const vxs_effect &effect : std::span(planned.config.effects, planned.config.effect_count)) {
            (effect.kind == kind ? with : without).push_back(effect);
        }
        cost.is_in = !with.empty();
        if (!cost.is_in) vxs_effect_default(kind, &with.emplace_back());
        with.insert(with.end(), without.begin(), without.end());
        const vxs_servo_config asked = with_effects(planned.config, with);
        if (const vxs_result result = vxs_servo_config_check(&asked); result != VXS_OK) {
            cost.why_not =
                result == VXS_PARAM ? "needs more than its constants by default" : vxs_result_text(result);
        } else {
            cost.ns = difference(asked, with_effects(planned.config, without), states);
        }
        costs.push_back(cost);
    }
    return costs;
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
