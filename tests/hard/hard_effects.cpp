// SPDX-License-Identifier: GPL-3.0-or-later
// Every effect alone and every pair of them on hard shapes in the closed loop: nothing before arming, finite,
// bounded, within the clamp, the same again; and friction, whatever goes with it, never gives more energy
// than it took.
//   hard_effects [TICKS [all]]      all: every law, field and coupling, not one of each by turns
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <set>

namespace hard {
namespace {

enum class Trouble { none, not_finite, missed };

/// Two parts, and a way of the moving one: from 0 to 1 and back to where it began.
struct Shape {
    const char *name;
    const Asset &(*fixed)(), &(*moving)();
    vxs_pose (*way)(double share);
    Trouble trouble = Trouble::none;
};

double wave(double share, double times)
{
    return std::sin(2 * std::numbers::pi * times * share);
}

const Asset &block_floor()
{
    return asset("block", h, [] { return block(); });
}
const Asset &ball_5mm()
{
    return asset("ball", h, [] { return ball(); });
}
Mesh upside_down(const std::vector<std::array<double, 2>> &chain, double bottom, double depth)
{
    return moved(under(chain, bottom, depth), [](const Point &p) { return Point{-p[0], -p[1], p[2]}; });
}

/// Down onto the floor by `deep`, aslant, and up again.
vxs_pose dip(double share, double high, double deep)
{
    const double down = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * share);
    return turned({2e-3 * wave(share, 3), high - (high + deep) * down, 1e-3 * wave(share, 5)}, {1, 0.4, 2},
                  0.1 * wave(share, 2));
}

const std::vector<Shape> shapes{
    {"peg_in_hole",
     []() -> const Asset & { return asset("frame", h, [] { return frame(12e-3, 5.5e-3, 24e-3); }); },
     []() -> const Asset & {
         return asset("peg", h, [] {
             return solids::box({-5.4e-3, -20e-3, -5.4e-3}, {5.4e-3, 20e-3, 5.4e-3});
         });
     },
     [](double s) {
         return turned({4e-4 * wave(s, 3), 3e-3 * wave(s, 1), 3e-4 * wave(s, 4)}, {1, 2, 1},
                       0.01 * wave(s, 5));
     }},
    {"wedge",
     []() -> const Asset & {
         return asset("groove", h, [] {
             return under({{-12e-3, 8.5e-3}, {-8e-3, 8.5e-3}, {0, 0.5e-3}, {8e-3, 8.5e-3}, {12e-3, 8.5e-3}},
                          -6e-3, 40e-3);
         });
     },
     []() -> const Asset & {
         return asset("wedge", h, [] {
             return upside_down({{-5e-3, -5e-3}, {0, 0}, {5e-3, -5e-3}}, -8e-3, 20e-3);
         });
     },
     [](double s) { return dip(s, 2e-3, 0); }},
    {"slot",
     []() -> const Asset & {
         return asset("slot", h, [] {
             return under({{-12e-3, 0.5e-3},
                           {-5.5e-3, 0.5e-3},
                           {-5.5e-3, -9.5e-3},
                           {5.5e-3, -9.5e-3},
                           {5.5e-3, 0.5e-3},
                           {12e-3, 0.5e-3}},
                          -14e-3, 40e-3);
         });
     },
     []() -> const Asset & {
         return asset("plate", h, [] {
             return solids::box({-5.7e-3, -8e-3, -10e-3}, {5.7e-3, 10e-3, 10e-3});
         });
     },
     [](double s) {
         return turned({1.5e-4 * wave(s, 4), 1e-3 * wave(s, 2), 2e-3 * wave(s, 1)}, {0, 1, 2},
                       0.01 * wave(s, 3));
     }},
    {"knife_edge", block_floor,
     []() -> const Asset & {
         return asset("knife", h, [] {
             return upside_down({{-1.25e-3, -9e-3}, {-0.5e-3, -0.5e-3}, {0.25e-3, -9e-3}}, -10e-3, 20e-3);
         });
     },
     [](double s) { return dip(s, 1.5e-3, 0.2e-3); }},
    {"enter_and_leave", block_floor, ball_5mm, [](double s) { return dip(s, 6.5e-3, -4.8e-3); }},
    {"tilted_wall",
     []() -> const Asset & { return asset("tilted block", h, [] { return moved(block(), tilted); }); },
     ball_5mm,
     [](double s) {
         return pose_at(tilted({5e-3 * wave(s, 1), 5.4e-3 - 7e-4 * std::abs(wave(s, 2)), 2e-3 * wave(s, 3)}));
     }},
    {"start_inside", block_floor, ball_5mm,
     [](double s) { return dip(s < 0.5 ? s + 0.5 : s - 0.5, 7e-3, -4.8e-3); }},
    {"not_finite", block_floor, ball_5mm, [](double s) { return dip(s, 6e-3, -4.6e-3); },
     Trouble::not_finite},
    {"missed_ticks", block_floor, ball_5mm, [](double s) { return dip(s, 6e-3, -4.6e-3); }, Trouble::missed},
};

void fail(const std::string &what)
{
    std::fprintf(stderr, "hard_effects: %s\n", what.c_str());
    std::exit(1);
}

/// What to run: one or two effects, a law and field, a coupling.
struct Setting {
    const Shape *shape;
    Pair pair;
    std::uint32_t coupling;
    std::vector<std::uint32_t> kinds;
    std::string text() const
    {
        std::string all =
            std::string(shape->name) + ", " + pair.name + ", " + vxs_coupling_kind_name(coupling);
        for (const std::uint32_t kind : kinds) all.append(" + ").append(vxs_effect_kind_name(kind));
        return all;
    }
    bool has(std::uint32_t kind) const { return std::find(kinds.begin(), kinds.end(), kind) != kinds.end(); }
};

/// With constants at which it acts on these shapes, where it does not by default.
void acting(vxs_effect &effect)
{
    switch (effect.kind) {
    case VXS_EFFECT_PASSIVITY:
        effect.as.passivity.radius = 0.03;
        break;
    case VXS_EFFECT_GRAVITY:
        effect.as.gravity.com[0] = 0.005;
        break;
    case VXS_EFFECT_VISCOSITY:
        effect.as.viscosity.turning = 1e-4;
        break;
    case VXS_EFFECT_WORKSPACE:
        effect.as.workspace.high[1] = 0.005;
        effect.as.workspace.low[0] = -0.001;
        break;
    default:
        break;
    }
}

/// A servo in memory that was something else before.
class Rig {
  public:
    Rig(const Setting &setting, int filling, bool reversed) : text_(setting.text())
    {
        for (int n = 0; n < 9; ++n) {
            vxs_pose pose = turned({3e-4 * wave(n / 8.0, 1), 2e-4 * wave(n / 8.0, 2), 0}, {0, 1, 1},
                                   0.03 * wave(n / 8.0, 1));
            keyframes_.push_back({0.03 * n, pose, 0, 0});
        }
        for (const std::uint32_t kind : setting.kinds) {
            vxs_effect effect;
            vxs_effect_default(kind, &effect);
            if (kind == VXS_EFFECT_MOTION) {
                effect.as.motion.loop = 1;
                effect.keyframes = keyframes_.data();
                effect.keyframe_count = static_cast<std::uint32_t>(keyframes_.size());
            }
            acting(effect);
            effects_.insert(reversed ? effects_.begin() : effects_.end(), effect);
        }
        statics_ = {&setting.shape->fixed().map, nullptr};
        vxs_servo_config config;
        vxs_servo_config_default(&config);
        config.statics = &statics_;
        config.static_count = 1;
        config.shell = &setting.shape->moving().shell;
        config.max_force = 8.5;
        most_torque_ = config.max_torque;
        config.contact.law = setting.pair.law;
        config.contact.field = setting.pair.field;
        config.contact.weighting = VXS_CONTACT_AREA;
        config.contact.stiffness = stiffness;
        config.coupling.kind = setting.coupling;
        config.effects = effects_.data();
        config.effect_count = static_cast<std::uint32_t>(effects_.size());
        if (const vxs_result result = vxs_servo_config_check(&config); result != VXS_OK)
            fail(text_ + ": " + vxs_result_text(result));
        memory_.resize(vxs_servo_memory(&config) / sizeof(std::max_align_t) + 1);
        std::memset(memory_.data(), filling, memory_.size() * sizeof(std::max_align_t));
        if (vxs_servo_init(memory_.data(), vxs_servo_memory(&config), &config, &servo) != VXS_OK)
            fail(text_ + ": no servo");
    }
    Rig(const Rig &) = delete;
    Rig &operator=(const Rig &) = delete;

    std::uint32_t tick(const vxs_device_state &state)
    {
        const std::uint32_t flags = vxs_servo_tick(servo, &state, &command, &row);
        double sum = 0;
        for (int i = 0; i < 3; ++i)
            sum += std::abs(command.wrench.force[i]) + std::abs(command.wrench.torque[i]) +
                   std::abs(row.output.force[i]) + std::abs(row.output.torque[i]) +
                   std::abs(row.body.position[i]);
        const std::string here = text_ + ": tick " + std::to_string(row.tick) + ": ";
        if (!std::isfinite(sum)) fail(here + "not finite");
        if (length(command.wrench.force) > 8.5 * (1 + 1e-12) ||
            length(command.wrench.torque) > most_torque_ * (1 + 1e-12))
            fail(here + "beyond the clamp");
        if (state.state != VXS_DEVICE_ARMED &&
            length(command.wrench.force) + length(command.wrench.torque) != 0)
            fail(here + "pushes before it is armed");
        return flags;
    }

    vxs_servo *servo = nullptr;
    vxs_device_command command{};
    vxs_servo_trace row{};

  private:
    std::string text_;
    std::vector<vxs_effect_keyframe> keyframes_;
    std::vector<vxs_effect> effects_;
    vxs_contact_static statics_{};
    double most_torque_ = 0; // [N m]
    std::vector<std::max_align_t> memory_;
};

std::uint64_t hashed(std::uint64_t hash, const void *bytes, std::size_t size)
{
    for (std::size_t n = 0; n < size; ++n)
        hash = (hash ^ static_cast<const std::uint8_t *>(bytes)[n]) * 1099511628211u; // FNV-1a
    return hash;
}

struct Outcome {
    std::uint64_t hash = 14695981039346656037u;
    double most_force = 0, most_away = 0; // of the coupling [N]; of the object from the tip [m]
    double most_depth = 0;
};

/// In the simulated device's hand, twice along the way.
Outcome run_loop(const Setting &setting, long ticks, int filling, bool reversed)
{
    Rig rig(setting, filling, reversed);
    vxs_simulated_config config;
    vxs_simulated_config_default(&config, nullptr);
    config.start = setting.shape->way(0);
    std::vector<std::max_align_t> memory(vxs_simulated_memory() / sizeof(std::max_align_t) + 1);
    vxs_device *device = nullptr;
    if (vxs_simulated_open(memory.data(), vxs_simulated_memory(), &config, &device) != VXS_OK)
        fail("no device");
    vxs_device_state state{};
    Outcome outcome;
    for (int k = 0; k < 20; ++k) { // in the hand, not yet armed
        vxs_device_exchange(device, &rig.command, &state, nullptr);
        rig.tick(state);
        outcome.hash = hashed(outcome.hash, &rig.row, sizeof rig.row);
    }
    vxs_device_arm(device);
    for (long k = 0; k < ticks; ++k) {
        const vxs_pose target =
            setting.shape->way(std::fmod(2.0 * static_cast<double>(k) / static_cast<double>(ticks), 1));
        vxs_simulated_hand(device, target.position, target.orientation);
        vxs_device_exchange(device, &rig.command, &state, nullptr);
        if (setting.shape->trouble == Trouble::missed && k % 97 > 94 - k % 5) continue;
        if (setting.shape->trouble == Trouble::not_finite && k % 89 == 60) {
            vxs_device_state bad = state;
            (k % 2 ? bad.pose.position[1] : bad.pose.orientation[2]) = k % 3 ? NAN : INFINITY;
            if (!(rig.tick(bad) & VXS_SERVO_FAULT)) fail(setting.text() + ": no fault");
            vxs_servo_clear(rig.servo);
            continue;
        }
        if (rig.tick(state) & VXS_SERVO_FAULT)
            fail(setting.text() + ": a fault in tick " + std::to_string(k));
        outcome.hash = hashed(outcome.hash, &rig.row, sizeof rig.row);
        outcome.most_force = std::max(outcome.most_force, length(rig.row.output.force));
        outcome.most_away = std::max(outcome.most_away, apart(rig.row.body.position, state.pose.position));
        outcome.most_depth = std::max(outcome.most_depth, rig.row.depth);
    }
    vxs_device_close(device);
    return outcome;
}

/// On a given way beside the same without friction: what friction took, over what passed. Of its centre of
/// pressure it is exact, of a wrench about the tip to the square of a tick's turn.
struct Energy {
    double passed = 0, least = 0;
};

Energy run_energy(Setting setting, long ticks)
{
    if (!setting.has(VXS_EFFECT_TORQUE)) setting.kinds.push_back(VXS_EFFECT_TORQUE); // its work counts
    Setting without = setting;
    std::erase(without.kinds, static_cast<std::uint32_t>(VXS_EFFECT_FRICTION));
    Rig with(setting, 0, false), bare(without, 0, false);
    vxs_device_state state{};
    state.state = VXS_DEVICE_ARMED;
    state.pose = setting.shape->way(0);
    double taken = 0;
    Energy energy;
    for (long k = 0; k < ticks; ++k) {
        const vxs_pose last = state.pose;
        state.pose = setting.shape->way(static_cast<double>(k) / static_cast<double>(ticks));
        state.sequence++;
        state.time_ns += 1'000'000;
        with.tick(state);
        bare.tick(state);
        double turn[3], work = 0;
        vxs_pose_turn(last.orientation, state.pose.orientation, turn);
        for (int i = 0; i < 3; ++i)
            work -= (with.row.output.force[i] - bare.row.output.force[i]) *
                        (state.pose.position[i] - last.position[i]) +
                    (with.row.output.torque[i] - bare.row.output.torque[i]) * turn[i];
        taken += work;
        energy.passed += std::abs(work);
        energy.least = std::min(energy.least, taken);
    }
    if (energy.passed > 0 && !(energy.least >= -1e-9 * energy.passed))
        fail(setting.text() + ": friction gave " + number(-energy.least) + " J of " + number(energy.passed));
    return energy;
}

std::vector<std::vector<std::uint32_t>> choices()
{
    std::vector<std::uint32_t> kinds;
    for (std::uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; ++n) kinds.push_back(kind);
    std::vector<std::vector<std::uint32_t>> all{{}};
    for (std::size_t a = 0; a < kinds.size(); ++a) {
        all.push_back({kinds[a]});
        for (std::size_t b = 0; b < a; ++b) all.push_back({kinds[b], kinds[a]});
    }
    return all;
}

int run(long ticks, bool every)
{
    const std::uint32_t couplings[] = {VXS_COUPLING_NONE, VXS_COUPLING_QUASI_STATIC, VXS_COUPLING_PT2,
                                       VXS_COUPLING_SPRING_DAMPER};
    const auto sets = choices();
    long runs = 0, walks = 0;
    for (const Shape &shape : shapes) {
        Outcome worst;
        Energy friction;
        std::size_t turn = 0;
        for (const auto &kinds : sets) {
            const bool has_body = std::find(kinds.begin(), kinds.end(), VXS_EFFECT_INERTIA) != kinds.end();
            const bool is_driven = std::find(kinds.begin(), kinds.end(), VXS_EFFECT_MOTION) != kinds.end();
            const bool has_friction =
                std::find(kinds.begin(), kinds.end(), VXS_EFFECT_FRICTION) != kinds.end();
            const std::size_t couplings_count = has_body ? 3 : 4;
            ++turn;
            for (std::size_t p = 0; p < pairs().size(); ++p) {
                const Pair &pair = pairs()[p];
                if (!every && p != (turn % 3 == 0 ? 9 : 8)) continue; // gradient and patch on the distance
                for (std::size_t c = 0; c < couplings_count; c += has_body ? 2 : 1) {
                    if (!every && c != (has_body ? 2 * (turn % 2) : turn % 4)) continue;
                    const Setting setting{&shape, pair, couplings[c], kinds};
                    const Outcome one = run_loop(setting, ticks, 0, false),
                                  other = run_loop(setting, ticks, 0xA5, true);
                    if (one.hash != other.hash) fail(setting.text() + ": not the same again");
                    // nothing flies off: a spring of 1 kN/m would have to pull with 50 N
                    if (!(one.most_away < 0.05 && one.most_force < 500))
                        fail(setting.text() + ": not bounded: " + number(one.most_force) + " N, " +
                             number(one.most_away) + " m away");
                    worst.most_force = std::max(worst.most_force, one.most_force);
                    worst.most_away = std::max(worst.most_away, one.most_away);
                    worst.most_depth = std::max(worst.most_depth, one.most_depth);
                    ++runs;
                }
                if (has_friction && !has_body && !is_driven && shape.trouble == Trouble::none) {
                    const Energy energy = run_energy({&shape, pair, VXS_COUPLING_NONE, kinds}, 5 * ticks);
                    friction.passed += energy.passed;
                    friction.least = std::min(friction.least, energy.least);
                    ++walks;
                }
            }
        }
        std::printf("%-16s at most %5.3g N, the object %4.2f mm from the tip, %4.2f mm deep; friction: %8.3g "
                    "J passed, "
                    "never less than %.2g J taken\n",
                    shape.name, worst.most_force, 1e3 * worst.most_away, 1e3 * worst.most_depth,
                    friction.passed, friction.least);
        std::fflush(stdout);
        if (!(worst.most_depth > 0)) fail(std::string(shape.name) + ": nothing ever touched");
    }
    std::printf("%zu sets of effects, %ld runs of %ld ticks, each twice the same; %ld walks of friction\n",
                sets.size(), runs, ticks, walks);
    return 0;
}

} // namespace
} // namespace hard

int main(int count, char **arguments)
{
    return hard::run(count > 1 ? std::atol(arguments[1]) : 200,
                     count > 2 && !std::strcmp(arguments[2], "all"));
}
