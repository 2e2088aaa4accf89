// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/paper_path.hpp"

#include "study/bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voxshell {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double groove_angle = pi / 3, peg_tilt = pi / 180;
constexpr double press_seconds = 3, press_depth_e = 2, way_in = 0.015, way_speed = 0.05;

Point add(const Point &a, double x, const Point &b)
{
    return {a[0] + x * b[0], a[1] + x * b[1], a[2] + x * b[2]};
}

/// A ball's force on a flat elastic foundation: the volume sunk in, over pi.
double cap(double radius, double depth)
{
    return depth > 0 ? depth * depth * (radius - depth / 3) : 0;
}

} // namespace

double plane_height(const Scenario &scenario, unsigned seed)
{
    switch (scenario.stands) {
    case Stands::plane:
        return scenario.voxel * draw(seed).offset[3];
    case Stands::middle_plane:
        return scenario.voxel / 2;
    default:
        return 0;
    }
}

Body standing_body(const Scenario &scenario, double level, unsigned seed)
{
    const double e = scenario.voxel;
    const auto body = [&](const std::string &name, Mesh mesh) {
        return Body{fmt::format("{} of {} mm cells", name, 1e3 * e), std::move(mesh), e, ShellKind::exact,
                    true};
    };
    switch (scenario.stands) {
    case Stands::plane:
    case Stands::middle_plane: {
        const double height = plane_height(scenario, seed);
        return body(fmt::format("plane at {}", height), slab(40 * e, height, 8 * e));
    }
    case Stands::tilted_plane:
        return body("tilted plane", tilted(slab(40 * e, 0, 8 * e)));
    case Stands::cylinder:
        return body("cylinder", cylinder(cylinder_radius_e * e, 16 * e));
    case Stands::tilted_cylinder:
        return body("tilted cylinder", tilted(cylinder(cylinder_radius_e * e, 16 * e)));
    case Stands::groove:
        return body("groove", tilted(groove(groove_angle, 50 * e, 16 * e, 8 * e)));
    case Stands::hole:
        return body("hole", holed_block(hole_radius, 2 * hole_radius, hole_height));
    case Stands::cup:
        return body("cup", cup(cup_outer, cup_inner, cup_height, cup_floor));
    case Stands::plate:
        return body(fmt::format("plate of {} e", level), tilted(slab(25 * e, 0, level * e)));
    }
    return {};
}

Body moving_body(const Scenario &scenario, double level, ShellKind shell)
{
    const double e = scenario.voxel;
    const bool is_peg = scenario.moves == Moves::peg;
    const double radius = is_peg ? level / 2e3 : scenario.radius;
    return {fmt::format("{} of {} mm, {} points, {} mm cells", is_peg ? "peg" : "ball", 1e3 * radius,
                        shell_name(shell), 1e3 * e),
            is_peg ? cylinder(radius, peg_length / 2, 360) : ball(radius), e, shell, false};
}

Path::Path(const Scenario &scenario, double level, unsigned seed)
    : scenario_(scenario), level_(level),
      radius_(scenario.moves == Moves::peg ? level / 2e3 : scenario.radius),
      height_(plane_height(scenario, seed)), draw_(draw(seed))
{
    double seconds = turn_seconds;
    if (scenario.motion == Motion::press) seconds = press_seconds;
    if (scenario.motion == Motion::insert) seconds = way_in / way_speed;
    if (scenario.motion == Motion::coupled) seconds += approach_seconds;
    ticks_ = static_cast<std::size_t>(std::lround(seconds * study_rate));
    if (scenario.motion == Motion::circle || scenario.motion == Motion::coupled) {
        const double e = scenario.voxel;
        const double path = scenario.stands == Stands::cylinder || scenario.stands == Stands::tilted_cylinder
                                ? cylinder_radius_e * e + radius_ - level * e
                                : circle_radius_e * e;
        crossing_ = 2 * pi * path / turn_seconds / e;
    }
    if (!scenario.turned) std::copy_n(vxs_pose_identity().orientation, 4, draw_.orientation);
}

Path::Step Path::at(std::size_t tick) const
{
    const double t = static_cast<double>(tick) / study_rate, depth = level_ * scenario_.voxel;
    Step step{};
    switch (scenario_.motion) {
    case Motion::press:
        return press(t / press_seconds);
    case Motion::insert:
        return insert(t * way_speed);
    case Motion::coupled: {
        // From 10 e outside, straight down.
        const double ahead = std::max(0.0, 1 - t / approach_seconds);
        step = circle(std::max(0.0, t - approach_seconds) / turn_seconds,
                      depth - ahead * (depth + 10 * scenario_.voxel));
        break;
    }
    default:
        step = circle(t / turn_seconds, depth);
    }
    step.progress = t;
    return step;
}

Path::Step Path::circle(double turn, double depth) const
{
    const double e = scenario_.voxel, angle = 2 * pi * (turn + draw_.offset[0]);
    const double c = std::cos(angle), s = std::sin(angle);
    Step step{};
    Point at;
    const bool is_tilted =
        scenario_.stands == Stands::tilted_plane || scenario_.stands == Stands::tilted_cylinder;
    if (scenario_.stands == Stands::cylinder || scenario_.stands == Stands::tilted_cylinder) {
        step.axes[0] = {c, s, 0};
        step.axes[1] = {0, 0, 1};
        step.axes[2] = {-s, c, 0};
        const double r = cylinder_radius_e * e + radius_ - depth;
        at = {r * c, r * s, e * draw_.offset[1]};
    } else {
        at = {e * (circle_radius_e * c + draw_.offset[1]), e * (circle_radius_e * s + draw_.offset[2]),
              height_ + radius_ - depth};
        step.axes[0] = {0, 0, 1};
        step.axes[1] = {1, 0, 0};
        step.axes[2] = {0, 1, 0};
    }
    if (is_tilted) {
        at = tilted(at);
        for (Point &axis : step.axes) axis = tilted(axis);
    }
    std::copy_n(at.data(), 3, step.pose.position);
    std::copy_n(draw_.orientation, 4, step.pose.orientation);
    step.ideal_force = step.axes[0];
    return step;
}

Path::Step Path::press(double share) const
{
    const double e = scenario_.voxel, one = press_depth_e * e * share, other = level_ * one;
    const double c = std::cos(groove_angle / 2), s = std::sin(groove_angle / 2);
    // One wall leads right and up, the other left and up: their normals.
    const Point right{-c, 0, s}, left{c, 0, s};
    const Point at =
        tilted({(one - other) / (2 * c), e * draw_.offset[1], (2 * radius_ - one - other) / (2 * s)});
    Step step{};
    step.progress = one / e;
    const Point axes[] = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    for (std::size_t i = 0; i < 3; ++i) step.axes[i] = tilted(axes[i]);
    std::copy_n(at.data(), 3, step.pose.position);
    std::copy_n(draw_.orientation, 4, step.pose.orientation);
    step.ideal_force = add(add({}, cap(radius_, one), tilted(right)), cap(radius_, other), tilted(left));
    return step;
}

/// The peg's axis crosses the hole's in the middle of what is in, and leans over towards y. Ideal is an
/// elastic foundation on the peg's side against the hole's wall.
Path::Step Path::insert(double way) const
{
    const double c = std::cos(peg_tilt), s = std::sin(peg_tilt), turn = 2 * pi * draw_.offset[0];
    const Point axis{0, -s, c}, side{1, 0, 0}, front{0, c, s};
    const double in = way / 2 - peg_length / 2; // the crossing, from the peg's middle along its axis
    const Point at{-in * axis[0], -in * axis[1], hole_height - way / 2 - in * axis[2]};
    Step step{};
    step.progress = 1e3 * way;
    step.axes[0] = {0, 0, 1};
    step.axes[1] = {1, 0, 0};
    step.axes[2] = {0, 1, 0};
    std::copy_n(at.data(), 3, step.pose.position);
    // About its own axis at random, then over by the tilt about x.
    const double half = peg_tilt / 2;
    step.pose.orientation[0] = std::cos(half) * std::cos(turn / 2);
    step.pose.orientation[1] = std::sin(half) * std::cos(turn / 2);
    step.pose.orientation[2] = -std::sin(half) * std::sin(turn / 2);
    step.pose.orientation[3] = std::cos(half) * std::sin(turn / 2);
    constexpr int around = 90, up = 120;
    for (int n = 0; n < up; ++n) {
        const double high = peg_length * ((n + 0.5) / up - 0.5);
        for (int m = 0; m < around; ++m) {
            const double a = 2 * pi * m / around;
            const Point arm =
                add(add(add({}, radius_ * std::cos(a), side), radius_ * std::sin(a), front), high, axis);
            const Point p = add(at, 1, arm);
            const double r = std::hypot(p[0], p[1]), depth = r - hole_radius;
            if (depth <= 0 || p[2] <= 0 || p[2] >= hole_height) continue;
            const Point push{-depth * p[0] / r, -depth * p[1] / r, 0};
            step.ideal_force = add(step.ideal_force, 1, push);
            step.ideal_torque = add(step.ideal_torque, 1, cross(arm, push));
        }
    }
    return step;
}

bool is_degenerate(const Path::Step &step)
{
    const auto &[w, x, y, z] = step.pose.orientation;
    const double square = w * w + x * x + y * y + z * z;
    const double turned[] = {
        1 - 2 * (y * y + z * z) / square, 1 - 2 * (x * x + z * z) / square, 1 - 2 * (x * x + y * y) / square,
        2 * (x * y - w * z) / square,     2 * (x * y + w * z) / square,     2 * (x * z + w * y) / square,
        2 * (x * z - w * y) / square,     2 * (y * z - w * x) / square,     2 * (y * z + w * x) / square};
    const auto along_axis = [](double part) {
        return std::min(std::abs(part), std::abs(1 - std::abs(part))) < 1e-6;
    };
    return std::all_of(std::begin(turned), std::end(turned), along_axis) &&
           std::all_of(step.axes[0].begin(), step.axes[0].end(), along_axis);
}

Point along(const Path::Step &step, const double v[3])
{
    Point out;
    for (std::size_t i = 0; i < 3; ++i)
        out[i] = step.axes[i][0] * v[0] + step.axes[i][1] * v[1] + step.axes[i][2] * v[2];
    return out;
}

} // namespace voxshell
