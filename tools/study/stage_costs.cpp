// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/stage_costs.hpp"

#include "plan/plan_facts.hpp"
#include "study/watched_servo.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <numeric>
#include <span>

namespace voxshell {
namespace {

constexpr double most_ns = 1e9; ///< that the passes of one servo may take
constexpr double instructions_a_ns =
    8;                      ///< about, so that a tick's weight is known before it is stepped through
constexpr double call = 32; ///< of an effect from within another stage
constexpr double small = 0.03; ///< of a stage's instructions
constexpr double most_steps = 40'000; ///< instructions of one servo's ticks: a quarter of a second
constexpr double most_counted = 20e6; ///< of one tick: a minute

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

vxs_servo_config with_effects(vxs_servo_config config, const std::vector<vxs_effect> &effects)
{
    config.effects = effects.data();
    config.effect_count = static_cast<std::uint32_t>(effects.size());
    return config;
}

/// What servos with the same effects take in a mean tick, stage by stage.
struct Profile {
    ByStage ns, instructions; ///< instructions: of the counted ticks, 0 if none are
    std::vector<ByStage> counted;
    std::vector<vxs_pose> bodies; ///< in these ticks
};

vxs_pose pose_of(const vxs_contact_static &at)
{
    return at.pose ? *at.pose : vxs_pose_identity();
}

double sum(const ByStage &shares)
{
    return std::accumulate(shares.of.begin(), shares.of.end(), 0.0);
}

class Costs {
  public:
    Costs(const PlannedServo &planned, double seconds, Progress &progress)
        : planned_(planned), seconds_(seconds), progress_(progress), contact_(stage_named("contact"))
    {
    }

    TickCosts run()
    {
        states_ = states_of(planned_, ticks_of(planned_, seconds_), progress_);
        progress_.stage("stages", 0);
        watch_ns_ = watch_cost_ns(planned_.config, states_.front());
        time_plan();
        choose_counted();
        count(planned_.config, true, plan_);
        parts();
        stages();
        return std::move(costs_);
    }

  private:
    bool counts() const { return costs_.not_counted.empty(); }

    /// How many passes fit, each stage's share of a tick, and the plan's ticks by weight.
    void time_plan()
    {
        const auto begin = Clock::now();
        {
            const Servo servo(planned_.config);
            vxs_device_command command{};
            for (const vxs_device_state &state : states_)
                vxs_servo_tick(servo.servo, &state, &command, nullptr);
        }
        passes_ = static_cast<int>(std::clamp(most_ns / double{ns_since(begin)}, 2.0, 7.0));
        plan_.ns = times(planned_.config, &weight_);
    }

    /// Each tick's stages at the least of some passes, each from rest; their mean. weight: of each tick, its
    /// contact [ns].
    ByStage times(const vxs_servo_config &config, std::vector<double> *weight = nullptr) const
    {
        std::vector<ByStage> least(states_.size());
        for (int pass = 0; pass < passes_; ++pass) {
            WatchedServo servo(config);
            for (std::size_t n = 0; n < states_.size(); ++n) {
                if (n % 256 == 0) progress_.check();
                const ByStage taken = watch_ns_.taken_from(servo.time(states_[n]));
                for (std::uint32_t stage = 0; stage <= ByStage::most; ++stage)
                    least[n][stage] = pass ? std::min(least[n][stage], taken[stage]) : taken[stage];
            }
        }
        ByStage mean;
        for (const ByStage &tick : least) {
            for (std::uint32_t stage = 0; stage <= ByStage::most; ++stage)
                mean[stage] += std::max(tick[stage], 0.0) / static_cast<double>(least.size());
            if (weight) weight->push_back(tick[contact_]);
        }
        return mean;
    }

    /// Which ticks are stepped through: some, spread evenly; one that is like the mean where they are heavy.
    void choose_counted()
    {
        costs_.not_counted = counter_.why_not();
        if (!counts()) return;
        watch_ = watch_cost(planned_.config, states_.front(), counter_);
        const double guess = instructions_a_ns * sum(plan_.ns);
        if (guess > most_counted) {
            costs_.not_counted = fmt::format("a tick here takes about {:.0f} us, too long to step through",
                                             sum(plan_.ns) / 1e3);
            return;
        }
        is_heavy_ = guess > most_steps;
        const auto picks = static_cast<std::size_t>(std::clamp(most_steps / guess, 1.0, 16.0));
        for (std::size_t n = 0; n < picks; ++n) picked_.push_back(states_.size() * (2 * n + 1) / (2 * picks));
        if (is_heavy_) {
            const auto like_the_mean = [&](double a, double b) {
                return std::abs(a - plan_.ns[contact_]) < std::abs(b - plan_.ns[contact_]);
            };
            const auto at = std::min_element(weight_.begin(), weight_.end(), like_the_mean);
            picked_ = {static_cast<std::size_t>(at - weight_.begin())};
        }
        costs_.counted_ticks = static_cast<std::uint32_t>(picked_.size());
    }

    /// Instructions of the picked ticks. Contact that is heavy is only stepped through where an effect says
    /// that it changes it, or has moved the object.
    void count(const vxs_servo_config &config, bool changes_contact, Profile &profile)
    {
        if (!counts()) return;
        WatchedServo servo(config);
        for (std::size_t n = 0; n < states_.size() && profile.counted.size() < picked_.size(); ++n) {
            const std::size_t taken = profile.counted.size();
            if (n != picked_[taken]) {
                servo.time(states_[n]);
                continue;
            }
            progress_.check();
            const bool is_known = is_heavy_ && !changes_contact;
            const TickShares shares = servo.count(states_[n], counter_, is_known ? contact_ : ByStage::none);
            profile.counted.push_back(watch_.taken_from(shares));
            profile.bodies.push_back(shares.body);
            if (is_known && std::memcmp(&shares.body, &plan_.bodies[taken], sizeof shares.body) != 0) {
                profile = {profile.ns, {}, {}, {}};
                count(config, true, profile);
                return;
            }
            if (is_known) profile.counted[taken][contact_] = plan_.counted[taken][contact_];
        }
        for (const ByStage &tick : profile.counted)
            for (std::uint32_t stage = 0; stage <= ByStage::most; ++stage)
                profile.instructions[stage] += tick[stage] / static_cast<double>(profile.counted.size());
    }

    /// What `with` takes beyond `without`: in the effect's own stage, and in the others as far as they run
    /// other instructions (without a count: as far as the clock sees it).
    void compare(const Profile &with, const Profile &without, std::uint32_t own, StageCost &cost)
    {
        cost.ns = with.ns[own];
        if (counts()) cost.instructions = 0;
        for (std::uint32_t stage = 0; stage <= ByStage::most; ++stage) {
            const double more = with.instructions[stage] - without.instructions[stage];
            if (counts()) *cost.instructions += more;
            if (cost.is_in && stage != own) shared_.instructions[stage] += more;
            if (stage == own || stage == ByStage::around || (counts() && std::abs(more) < call)) continue;
            // The clock does not see so small a part of a stage: it is taken at the stage's own pace.
            const bool is_small = std::abs(more) < small * without.instructions[stage];
            const double more_ns = is_small ? more / without.instructions[stage] * without.ns[stage]
                                            : with.ns[stage] - without.ns[stage];
            *cost.ns += more_ns;
            if (cost.is_in) shared_.ns[stage] += more_ns;
            vxs_servo_stage other;
            if (counts() && vxs_servo_stage_at(stage, &other) == VXS_OK)
                cost.elsewhere.emplace_back(other.name, more);
        }
    }

    /// The parts of the loop along the whole path: as often as the hand meets them.
    void parts()
    {
        const std::uint64_t ticks = std::min<std::uint64_t>(ticks_of(planned_, seconds_), 100'000);
        const Simulated simulated(planned_);
        const Servo servo(planned_.config);
        WatchedServo watched(planned_.config);
        require_ok(vxs_device_arm(simulated.device), planned_.device);
        const std::uint32_t coupling = stage_named("coupling");
        std::array<std::vector<float>, 4> ns;
        vxs_device_state state{};
        vxs_device_command command{};
        const std::uint64_t picks = std::min<std::uint64_t>(16, ticks);
        std::uint64_t taken = 0;
        double exchange = 0;
        progress_.stage("explain", ticks);
        for (std::uint64_t n = 0; n < ticks; ++n) {
            move_hand(simulated.device, planned_.hand.at(static_cast<double>(n) / planned_.rate));
            const auto work = [&] { vxs_device_exchange(simulated.device, &command, &state, nullptr); };
            auto begin = Clock::now();
            if (counts() && taken < picks && n == ticks * (2 * taken + 1) / (2 * picks)) {
                exchange += static_cast<double>(counter_.of(work));
                ++taken;
            } else {
                work();
                ns[0].push_back(ns_since(begin));
            }
            const ByStage shares = watch_ns_.taken_from(watched.time(state));
            ns[1].push_back(static_cast<float>(shares[contact_]));
            ns[2].push_back(static_cast<float>(std::max(shares[coupling], 0.0)));
            begin = Clock::now();
            vxs_servo_tick(servo.servo, &state, &command, nullptr);
            ns[3].push_back(ns_since(begin));
            progress_.advance(1);
            if (n % 256 == 0) progress_.check();
        }
        const ByStage &count = plan_.instructions;
        const std::array<LoopPart, 4> said = {
            {{"exchange",
              fmt::format("{}: pose and velocity in, the last command out", planned_.device),
              {},
              exchange / static_cast<double>(std::max<std::uint64_t>(taken, 1))},
             {"contact", what_contact_is(), {}, count[contact_]},
             {"coupling", what_coupling_is(), {}, count[coupling]},
             {"tick", what_a_tick_is(), {}, sum(count)}}};
        for (std::size_t part = 0; part < 4; ++part) {
            LoopPart &out = costs_.parts.emplace_back(said[part]);
            if (ns[part].empty()) ns[part].push_back(0); // a single tick, which was counted
            out.ns = durations(ns[part]);
            if (!counts()) out.instructions.reset();
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
        vxs_servo_stage stage;
        progress_.stage("effects", 0);
        for (std::uint32_t n = 0; vxs_servo_stage_at(n, &stage) == VXS_OK; ++n) {
            progress_.check();
            StageCost &cost = costs_.stages.emplace_back();
            cost.name = stage.name;
            cost.reads = stage.reads;
            cost.changes = stage.changes ? stage.changes : "";
            cost.is_effect = stage.effect != 0;
            cost.is_in = !stage.effect;
            if (cost.is_effect) measure_effect(stage.effect, n, cost);
        }
        // What is always there, without what effects make of it: that is in their lines.
        for (std::uint32_t n = 0; n < costs_.stages.size(); ++n)
            if (!costs_.stages[n].is_effect) always_there(n, costs_.stages[n]);
        StageCost &rest = costs_.stages.emplace_back();
        rest.name = "around";
        rest.reads = "the device's state, the clock; checks both and writes the command";
        rest.is_in = true;
        always_there(ByStage::around, rest);
    }

    void always_there(std::uint32_t stage, StageCost &cost) const
    {
        cost.ns = std::max(plan_.ns[stage] - shared_.ns[stage], 0.0);
        if (counts()) cost.instructions = plan_.instructions[stage] - shared_.instructions[stage];
    }

    void measure_effect(std::uint32_t kind, std::uint32_t stage, StageCost &cost)
    {
        const vxs_servo_config &config = planned_.config;
        std::vector<vxs_effect> without, with;
        for (const vxs_effect &effect : std::span(config.effects, config.effect_count))
            (effect.kind == kind ? with : without).push_back(effect);
        cost.is_in = !with.empty();
        const vxs_effect_keyframe still = {0, pose_of(config.statics[0]), 0, 0};
        if (!cost.is_in) {
            vxs_effect &effect = with.emplace_back();
            vxs_effect_default(kind, &effect);
            if (kind == VXS_EFFECT_MOTION) { // of what moves to where it is
                effect.keyframes = &still;
                effect.keyframe_count = 1;
            }
        }
        with.insert(with.end(), without.begin(), without.end());
        const vxs_servo_config other = with_effects(config, cost.is_in ? without : with);
        if (const vxs_result result = vxs_servo_config_check(&other); result != VXS_OK) {
            cost.why_not =
                result == VXS_PARAM ? "needs more than its constants by default" : vxs_result_text(result);
            return;
        }
        Profile changed;
        changed.ns = times(other);
        count(other, cost.changes.find("contact") != std::string::npos, changed);
        if (cost.is_in)
            compare(plan_, changed, stage, cost);
        else
            compare(changed, plan_, stage, cost);
    }

    const PlannedServo &planned_;
    const double seconds_;
    Progress &progress_;
    const std::uint32_t contact_;
    InstructionCount counter_;
    WatchCost watch_, watch_ns_;
    std::vector<vxs_device_state> states_;
    std::vector<double> weight_;
    int passes_ = 2;
    std::vector<std::size_t> picked_; ///< ticks that are counted
    bool is_heavy_ = false;
    Profile plan_;   ///< of the plan as it is
    Profile shared_; ///< what the plan's effects take within stages that are always there
    TickCosts costs_;
};

} // namespace

TickCosts tick_costs(const PlannedServo &planned, double seconds, Progress &progress)
{
    return Costs(planned, seconds, progress).run();
}

} // namespace voxshell
