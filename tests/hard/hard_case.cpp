// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"

#include "hard_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace hard {

const std::vector<Pair> &pairs()
{
    static const std::vector<Pair> rows{
        {"original/surface", VXS_CONTACT_ORIGINAL, VXS_CONTACT_SURFACE},
        {"average/surface", VXS_CONTACT_AVERAGE, VXS_CONTACT_SURFACE},
        {"patch/surface", VXS_CONTACT_PATCH, VXS_CONTACT_SURFACE},
        {"original/layers", VXS_CONTACT_ORIGINAL, VXS_CONTACT_LAYERS},
        {"average/layers", VXS_CONTACT_AVERAGE, VXS_CONTACT_LAYERS},
        {"patch/layers", VXS_CONTACT_PATCH, VXS_CONTACT_LAYERS},
        {"original/distance", VXS_CONTACT_ORIGINAL, VXS_CONTACT_DISTANCE},
        {"average/distance", VXS_CONTACT_AVERAGE, VXS_CONTACT_DISTANCE},
        {"patch/distance", VXS_CONTACT_PATCH, VXS_CONTACT_DISTANCE},
        {"gradient/distance", VXS_CONTACT_GRADIENT, VXS_CONTACT_DISTANCE},
    };
    return rows;
}

bool all(const Pair &)
{
    return true;
}

bool none(const Pair &)
{
    return false;
}

bool reads_surface(const Pair &pair)
{
    return pair.field == VXS_CONTACT_SURFACE;
}

bool is_conservative(const Pair &pair)
{
    return pair.law == VXS_CONTACT_GRADIENT;
}

bool reads_distance(const Pair &pair)
{
    return pair.field == VXS_CONTACT_DISTANCE;
}

bool has_common_normal(const Pair &pair)
{
    return pair.law == VXS_CONTACT_AVERAGE || reads_distance(pair);
}

bool keeps_opposed(const Pair &pair)
{
    return pair.law == VXS_CONTACT_PATCH || pair.law == VXS_CONTACT_GRADIENT;
}

bool keeps_slanted(const Pair &pair)
{
    return keeps_opposed(pair) && reads_distance(pair);
}

std::string number(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.3g", value);
    return text;
}

void Measured::note(double value, const std::string &at)
{
    must(std::isfinite(value), "not a finite measure " + at);
    if (value > worst) {
        worst = value;
        where = at;
    }
}

void Measured::must(bool holds, const std::string &what)
{
    if (!holds && broken.empty()) broken = what;
}

void Measured::refuse(const std::string &why)
{
    refused = why;
}

double length(const double v[3])
{
    return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double apart(const double a[3], const double b[3])
{
    const double way[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return length(way);
}

void Comparison::add(const vxs_wrench &a, const vxs_wrench &b, const std::string &where)
{
    const double difference = apart(a.force, b.force) + apart(a.torque, b.torque) / arm_;
    size_ = std::max(size_, length(a.force) + length(a.torque) / arm_);
    if (difference > most_) {
        most_ = difference;
        where_ = where;
    }
}

Comparison::~Comparison()
{
    measured_->must(size_ > 0, "no force to compare");
    measured_->note(size_ > 0 ? most_ / size_ : 0, where_);
}

vxs_pose pose_at(const Point &p, const std::array<double, 4> &q)
{
    return {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
}

vxs_pose turned(const Point &position, const Point &axis, double angle)
{
    const double size = length(axis.data()), s = std::sin(angle / 2) / size;
    return pose_at(position, {std::cos(angle / 2), s * axis[0], s * axis[1], s * axis[2]});
}

namespace {

void check(vxs_result result, const char *what)
{
    if (result == VXS_OK) return;
    std::fprintf(stderr, "hard_suite: %s: %s\n", what, vxs_result_text(result));
    std::exit(1);
}

vxs_contact_config config_of(const Pair &pair, double foundation)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = pair.law;
    config.field = pair.field;
    config.weighting = VXS_CONTACT_AREA;
    config.stiffness = foundation;
    return config;
}

bool is_finite(const vxs_wrench &w)
{
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += std::abs(w.force[i]) + std::abs(w.torque[i]);
    return std::isfinite(sum);
}

} // namespace

Touch::Touch(const Asset &fixed, const Asset &moving, const Pair &pair, Measured &measured, double foundation)
    : config(config_of(pair, foundation)), statics{&fixed.map, nullptr}, measured_(&measured)
{
    if (!vxs_contact_has_field(&fixed.map, pair.field)) measured.refuse("no inside, so no signed distance");
    open(fastest_, moving, VXS_CONTACT_FASTEST, VXS_CONTACT_CHECKED);
    open(plain_, moving, VXS_CONTACT_SCALAR, VXS_CONTACT_BRUTE);
}

void Touch::open(Engine &engine, const Asset &moving, std::uint32_t kernel, std::uint32_t culling)
{
    const std::size_t size = vxs_contact_memory(&moving.shell, 1);
    engine.memory.resize(size / sizeof(std::max_align_t) + 1);
    check(vxs_contact_init(engine.memory.data(), size, &moving.shell, 1, &engine.contact), "contact");
    check(vxs_contact_use(engine.contact, kernel), "kernel");
    check(vxs_contact_cull(engine.contact, culling), "culling");
}

const vxs_contact_result &Touch::at(const vxs_pose &pose)
{
    vxs_contact_evaluate(fastest_.contact, &statics, 1, &pose, &config, &result_);
    const std::string here = "at pose " + number(pose.position[0]) + " " + number(pose.position[1]) + " " +
                             number(pose.position[2]);
    measured_->must(is_finite(result_.wrench) && std::isfinite(result_.depth),
                    "a number that is not finite " + here);
    if (measured_->refused.empty())
        measured_->must(
            !(result_.flags & (VXS_CONTACT_INVALID | VXS_CONTACT_WRONG_SKIP | VXS_CONTACT_OVERFLOW)),
            "flags " + std::to_string(result_.flags) + " " + here);
    if (result_.points == 0 && result_.deep_points == 0)
        measured_->must(length(result_.wrench.force) == 0 && length(result_.wrench.torque) == 0,
                        "force without contact " + here);
    if (count_++ % 8 == 0) {
        vxs_contact_result plain;
        vxs_contact_evaluate(plain_.contact, &statics, 1, &pose, &config, &plain);
        measured_->must(std::memcmp(&plain.wrench, &result_.wrench, sizeof plain.wrench) == 0,
                        "another wrench without culling " + here);
    }
    return result_;
}

double worst_jump(Touch &touch, Measured &measured, int steps,
                  const std::function<vxs_pose(double share)> &path)
{
    double last[3] = {}, jump = 0, most = 0;
    for (int n = 0; n <= steps; ++n) {
        const vxs_contact_result &result = touch.at(path(static_cast<double>(n) / steps));
        if (n > 0) jump = std::max(jump, apart(result.wrench.force, last));
        most = std::max(most, length(result.wrench.force));
        std::memcpy(last, result.wrench.force, sizeof last);
    }
    measured.must(most > 0, "no force on the way");
    return most > 0 ? jump / most : 0;
}

namespace {

void compare_touches(Touch one, Touch two, Measured &measured)
{
    Comparison same(measured, 5e-3);
    for (int n = 0; n <= 100; ++n) {
        const vxs_pose pose = pose_at({1e-4 * n, 5.6e-3 - 5e-6 * n, 3e-5 * n});
        same.add(one.at(pose).wrench, two.at(pose).wrench, "at step " + std::to_string(n));
    }
}

} // namespace

void compare(const Asset &clean, const Asset &other, const Asset &moving, const Pair &pair,
             Measured &measured)
{
    compare_touches(Touch(clean, moving, pair, measured), Touch(other, moving, pair, measured), measured);
}

void compare_moving(const Asset &fixed, const Asset &moving, const Asset &other, const Pair &pair,
                    Measured &measured)
{
    compare_touches(Touch(fixed, moving, pair, measured), Touch(fixed, other, pair, measured), measured);
}

Loop::Loop(const Pair &pair, Measured &measured,
           const std::function<void(vxs_servo_config &, vxs_simulated_config &)> &change)
    : measured_(&measured)
{
    const Asset &floor = asset("floor", h, [] { return block(0); }),
                &moving = asset("ball", h, [] { return ball(); });
    vxs_simulated_config simulated;
    vxs_simulated_config_default(&simulated, nullptr);
    simulated.start.position[1] = 6e-3;
    vxs_servo_config config;
    vxs_servo_config_default(&config);
    statics_ = {&floor.map, nullptr};
    config.statics = &statics_;
    config.static_count = 1;
    config.shell = &moving.shell;
    config.max_force = 8.5;
    config.contact = config_of(pair, stiffness);
    if (change) change(config, simulated);
    max_force_ = config.max_force;
    max_torque_ = config.max_torque;
    device_memory_.resize(vxs_simulated_memory() / sizeof(std::max_align_t) + 1);
    servo_memory_.resize(vxs_servo_memory(&config) / sizeof(std::max_align_t) + 1);
    check(vxs_simulated_open(device_memory_.data(), vxs_simulated_memory(), &simulated, &device), "device");
    check(vxs_servo_init(servo_memory_.data(), vxs_servo_memory(&config), &config, &servo), "servo");
}

Loop::~Loop()
{
    vxs_device_close(device);
}

std::uint32_t Loop::tick(const Point &hand, const double *orientation)
{
    vxs_simulated_hand(device, hand.data(), orientation);
    vxs_device_exchange(device, &command, &state, &report);
    return tick_on(state);
}

std::uint32_t Loop::tick_on(const vxs_device_state &now)
{
    const std::uint32_t flags = vxs_servo_tick(servo, &now, &command, &row);
    const std::string here = "in tick " + std::to_string(row.tick);
    measured_->must(is_finite(command.wrench), "a command that is not finite " + here);
    measured_->must(length(command.wrench.force) <= max_force_ * (1 + 1e-12) &&
                        length(command.wrench.torque) <= max_torque_ * (1 + 1e-12),
                    "a command beyond the clamp " + here);
    if (flags & (VXS_SERVO_OFF | VXS_SERVO_FAULT | VXS_SERVO_DEVICE_LOST | VXS_SERVO_START_IN_CONTACT))
        measured_->must(length(command.wrench.force) == 0 && length(command.wrench.torque) == 0,
                        "force although it is off " + here);
    return flags;
}

} // namespace hard
