// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/stage_costs.hpp"

#include "plan/plan_facts.hpp"
#include "study/instructions.hpp"
#include "study/simulated_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <span>

namespace voxshell {
namespace {

constexpr int passes = 7;
constexpr double most_counted = 150'000; ///< instructions of a tick that is worth stepping through 14 times
constexpr double most_steps = 60'000;    ///< instructions of one servo's ticks: a quarter of a second

/// The device's states in the last ticks of a run.
std::vector<vxs_device_state> states_of(const PlannedServo &planned, std::uint64_t ticks, Progress &progress)
{
    constexpr std::uint64_t most_states = 5000;
    const Simulated simulated(planned);
    const Servo servo(planned.config);
    require_ok(vxs_device_arm(simulated.device), planned.device);
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

/// Contact and coupling by themselves, as the servo sets them up.
class Alone {
  public:
    explicit Alone(const vxs_servo_config &config)
        : config_(config), room_(vxs_contact_memory(config.shell, config.static_count)),
          levels_(vxs_contact_levels_memory(config.shell)), filter_(vxs_coupling_memory())
    {
        require_ok(vxs_contact_init(room_.get(), room_.size(), config.shell, config.static_count, &contact_),
                   "contact");
        if (config.contact.most_points)
            require_ok(vxs_contact_add_levels(contact_, levels_.get(), levels_.size()), "levels of detail");
        require_ok(vxs_coupling_init(filter_.get(), filter_.size(), &config.coupling, &coupling_),
                   "coupling");
    }
    void contact(const vxs_device_state &state)
    {
        vxs_contact_evaluate(contact_, config_.statics, config_.static_count, &state.pose, &config_.contact,
                             &result);
    }
    void couple(const vxs_device_state &state)
    {
        vxs_wrench out;
        vxs_coupling_step(coupling_, &result.wrench, &state.pose, &out);
    }
    vxs_contact_result result{};

  private:
    const vxs_servo_config &config_;
    Memory room_, levels_, filter_;
    vxs_contact *contact_ = nullptr;
    vxs_coupling *coupling_ = nullptr;
};

vxs_servo_config with_effects(vxs_servo_config config, const std::vector<vxs_effect> &effects)
{
    config.effects = effects.data();
    config.effect_count = static_cast<std::uint32_t>(effects.size());
    return config;
}

/// Runs work(0 .. count - 1) and counts that of `picks` of them, spread evenly; their mean.
template<typename Work>
double mean_count(InstructionCount &counter, std::uint64_t count, std::uint64_t picks, const Work &work)
{
    double sum = 0;
    std::uint64_t taken = 0;
    for (std::uint64_t n = 0; n < count; ++n) {
        if (taken < picks && n == count * (2 * taken + 1) / (2 * picks)) {
            sum += static_cast<double>(counter.of([&] { work(n); }));
            ++taken;
        } else {
            work(n);
        }
    }
    return sum / static_cast<double>(taken);
}

class Costs {
  public:
    Costs(const PlannedServo &planned, double seconds, Progress &progress)
        : planned_(planned), seconds_(seconds), progress_(progress)
    {
    }

    TickCosts run()
    {
        states_ = states_of(planned_, ticks_of(planned_, seconds_), progress_);
        costs_.not_counted = counter_.why_not();
        if (counts()) {
            const double one = ticks_counted(planned_.config, 1);
            picks_ = static_cast<std::uint32_t>(std::clamp(most_steps / one, 2.0, 16.0));
            if (one > most_counted)
                costs_.not_counted = fmt::format(
                    "a tick here takes about {:.0f}, too many to step through for each stage", one);
        }
        if (counts()) costs_.counted_ticks = picks_;
        parts();
        stages();
        return std::move(costs_);
    }

  private:
    bool counts() const { return costs_.not_counted.empty(); }

    double ticks_counted(const vxs_servo_config &config, std::uint32_t picks)
    {
        const Servo servo(config);
        vxs_device_command command{};
        progress_.check();
        return mean_count(counter_, states_.size(), picks, [&](std::uint64_t n) {
            vxs_servo_tick(servo.servo, &states_[n], &command, nullptr);
        });
    }

    /// A tick over the states [ns]. Each pass from rest.
    double tick_ns(const vxs_servo_config &config) const
    {
        const Servo servo(config);
        vxs_device_command command{};
        const auto begin = Clock::now();
        for (const vxs_device_state &state : states_) vxs_servo_tick(servo.servo, &state, &command, nullptr);
        return double{ns_since(begin)} / static_cast<double>(states_.size());
    }

    double difference_ns(const vxs_servo_config &with, const vxs_servo_config &without) const
    {
        double least_with = std::numeric_limits<double>::infinity(), least_without = least_with;
        for (int pass = 0; pass < passes; ++pass) { // in turn, so that both meet the same machine
            least_without = std::min(least_without, tick_ns(without));
            least_with = std::min(least_with, tick_ns(with));
        }
        return least_with - least_without;
    }

    /// The parts of the loop along the whole path: as often as the hand meets them.
    void parts()
    {
        const std::uint64_t ticks = std::min<std::uint64_t>(ticks_of(planned_, seconds_), 100'000);
        const vxs_servo_config &config = planned_.config;
        const Simulated simulated(planned_);
        const Servo servo(config);
        require_ok(vxs_device_arm(simulated.device), planned_.device);
        Alone alone(config);
        std::array<std::vector<float>, 4> ns;
        std::array<double, 4> sums{};
        vxs_device_state state{};
        vxs_device_command command{};
        const std::uint64_t picks = std::min<std::uint64_t>(picks_, ticks);
        std::uint64_t taken = 0;
        progress_.stage("explain", ticks);
        for (std::uint64_t n = 0; n < ticks; ++n) {
            move_hand(simulated.device, planned_.hand.at(static_cast<double>(n) / planned_.rate));
            const bool counted = counts() && taken < picks && n == ticks * (2 * taken + 1) / (2 * picks);
            taken += counted;
            const auto measure = [&](std::size_t part, const auto &work) {
                if (counted) {
                    sums[part] += static_cast<double>(counter_.of(work));
                    return;
                }
                const auto begin = Clock::now();
                work();
                ns[part].push_back(ns_since(begin));
            };
            measure(0, [&] { vxs_device_exchange(simulated.device, &command, &state, nullptr); });
            measure(1, [&] { alone.contact(state); });
            measure(2, [&] { alone.couple(state); });
            measure(3, [&] { vxs_servo_tick(servo.servo, &state, &command, nullptr); });
            progress_.advance(1);
            if (n % 256 == 0) progress_.check();
        }
        const std::array<std::pair<const char *, std::string>, 4> said = {
            {{"exchange", fmt::format("{}: pose and velocity in, the last command out", planned_.device)},
             {"contact", what_contact_is()},
             {"coupling", what_coupling_is()},
             {"tick", what_a_tick_is()}}};
        for (std::size_t part = 0; part < 4; ++part) {
            LoopPart &out = costs_.parts.emplace_back();
            out.name = said[part].first;
            out.what = said[part].second;
            if (ns[part].empty()) ns[part].push_back(0); // a single tick, which was counted
            out.ns = durations(ns[part]);
            if (counts()) out.instructions = sums[part] / static_cast<double>(taken);
        }
    }

    std::string what_contact_is() const
    {
        const vxs_contact_config &contact = planned_.config.contact;
        return fmt::format("{} points into cells of {} mm, law {}, field {}", planned_.shell().point_count,
                           1e3 * planned_.map().voxel, law_name(contact.law), field_name(contact.field));
    }

    std::string what_coupling_is() const
    {
        const vxs_coupling_config &coupling = planned_.config.coupling;
        return planned_.coupling +
               (coupling.kind == VXS_COUPLING_QUASI_STATIC
                    ? fmt::format(", contact evaluated up to {} times", coupling.evaluations)
                    : ", six axes");
    }

    std::string what_a_tick_is() const
    {
        const vxs_servo_config &config = planned_.config;
        std::string guards;
        for (const vxs_effect &effect : std::span(config.effects, config.effect_count))
            guards += std::string(", ") + vxs_effect_kind_name(effect.kind);
        return fmt::format("contact, coupling, clamp to {} N{}: the whole of it", config.max_force, guards);
    }

    void stages()
    {
        std::uint32_t kind = 0;
        const char *reads = nullptr;
        progress_.stage("effects", 0);
        if (counts()) tick_.instructions = ticks_counted(planned_.config, picks_);
        for (std::uint32_t n = 0; const char *name = vxs_servo_stage_at(n, &kind, &reads); ++n) {
            progress_.check();
            StageCost &cost = costs_.stages.emplace_back();
            cost.name = name;
            cost.reads = reads;
            cost.is_effect = kind != 0;
            cost.is_in = !kind;
            if (kind) measure_effect(kind, cost);
        }
        measure_rest();
    }

    void measure_effect(std::uint32_t kind, StageCost &cost)
    {
        const vxs_servo_config &config = planned_.config;
        std::vector<vxs_effect> without, with;
        for (const vxs_effect &effect : std::span(config.effects, config.effect_count))
            (effect.kind == kind ? with : without).push_back(effect);
        cost.is_in = !with.empty();
        if (!cost.is_in) vxs_effect_default(kind, &with.emplace_back());
        with.insert(with.end(), without.begin(), without.end());
        const vxs_servo_config asked = with_effects(config, with), bare = with_effects(config, without);
        if (const vxs_result result = vxs_servo_config_check(&asked); result != VXS_OK) {
            cost.why_not =
                result == VXS_PARAM ? "needs more than its constants by default" : vxs_result_text(result);
            return;
        }
        cost.ns = difference_ns(asked, bare);
        if (!counts()) return;
        const double other = ticks_counted(cost.is_in ? bare : asked, picks_);
        cost.instructions = cost.is_in ? *tick_.instructions - other : other - *tick_.instructions;
    }

    /// Of the stages that are always there: contact and coupling alone, and what is left of a tick.
    void measure_rest()
    {
        tick_.ns = std::numeric_limits<double>::infinity();
        double contact_ns = *tick_.ns, coupling_ns = *tick_.ns;
        std::vector<vxs_wrench> wrenches(states_.size());
        const auto each = static_cast<double>(states_.size());
        for (int pass = 0; pass < passes; ++pass) {
            tick_.ns = std::min(*tick_.ns, tick_ns(planned_.config));
            Alone alone(planned_.config);
            auto begin = Clock::now();
            for (std::size_t n = 0; n < states_.size(); ++n) {
                alone.contact(states_[n]);
                wrenches[n] = alone.result.wrench;
            }
            contact_ns = std::min(contact_ns, double{ns_since(begin)} / each);
            begin = Clock::now();
            for (std::size_t n = 0; n < states_.size(); ++n) {
                alone.result.wrench = wrenches[n];
                alone.couple(states_[n]);
            }
            coupling_ns = std::min(coupling_ns, double{ns_since(begin)} / each);
        }
        std::optional<double> contact, coupling;
        if (counts()) {
            Alone alone(planned_.config);
            contact = mean_count(counter_, states_.size(), picks_,
                                 [&](std::uint64_t n) { alone.contact(states_[n]); });
            coupling = mean_count(counter_, states_.size(), picks_, [&](std::uint64_t n) {
                alone.result.wrench = wrenches[n];
                alone.couple(states_[n]);
            });
        }
        StageCost rest;
        rest.ns = *tick_.ns - contact_ns - coupling_ns;
        if (counts()) rest.instructions = *tick_.instructions - *contact - *coupling;
        for (const StageCost &stage : costs_.stages) {
            if (!stage.is_effect || !stage.is_in) continue;
            *rest.ns -= stage.ns.value_or(0);
            if (rest.instructions) *rest.instructions -= stage.instructions.value_or(0);
        }
        for (StageCost &stage : costs_.stages) {
            if (stage.is_effect) continue;
            const bool is_contact = stage.name == "contact", is_coupling = stage.name == "coupling";
            stage.ns = is_contact ? contact_ns : is_coupling ? coupling_ns : *rest.ns;
            stage.instructions = is_contact ? contact : is_coupling ? coupling : rest.instructions;
        }
    }

    const PlannedServo &planned_;
    const double seconds_;
    Progress &progress_;
    InstructionCount counter_;
    std::uint32_t picks_ = 1;
    std::vector<vxs_device_state> states_;
    StageCost tick_; ///< of the plan as it is
    TickCosts costs_;
};

} // namespace

TickCosts tick_costs(const PlannedServo &planned, double seconds, Progress &progress)
{
    return Costs(planned, seconds, progress).run();
}

} // namespace voxshell
