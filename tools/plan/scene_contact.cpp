// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/scene_contact.hpp"

#include "plan/memory.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxshell {
namespace {

constexpr double most_steps = 20'000; ///< of a walk along the hand's path
constexpr std::size_t most_pushes = 32, most_rays = 64;
constexpr double before = 0.5, after = 1; ///< of a push, from where it touches [s]

void check(vxs_result result, const std::string &where)
{
    if (result != VXS_OK) {
        throw Failure(ExitCode::invalid, "", where + ": " + vxs_result_text(result));
    }
}

/// Contact of the scene's shell and map.
class Feeler {
  public:
    Feeler(const vxs_voxmap &map, const vxs_pointshell &shell, const vxs_contact_config &config)
        : config_(config), statics_{&map, nullptr}, room_(vxs_contact_memory(&shell, 1))
    {
        check(vxs_contact_init(room_.get(), room_.size(), &shell, 1, &contact_), "contact");
    }
    const vxs_contact_result &at(const vxs_pose &pose)
    {
        vxs_contact_evaluate(contact_, &statics_, 1, &pose, &config_, &result_);
        return result_;
    }

  private:
    vxs_contact_config config_;
    vxs_contact_static statics_;
    Memory room_;
    vxs_contact *contact_ = nullptr;
    vxs_contact_result result_{};
};

vxs_pose moved(vxs_pose pose, const Point &along, double way)
{
    for (int i = 0; i < 3; ++i) pose.position[i] += way * along[static_cast<std::size_t>(i)];
    return pose;
}

bool is_free(const vxs_voxmap &map, const Point &p)
{
    std::int64_t cell[3];
    return !vxs_voxmap_cell_of(&map, p.data(), cell) ||
           vxs_voxmap_state_at(&map, cell[0], cell[1], cell[2]) == VXS_CELL_FREE;
}

/// How far from p on it is until a free cell.
double way_out(const vxs_voxmap &map, Point p, const Point &along, double sign)
{
    const double step = map.voxel / 8;
    double way = 0;
    for (; !is_free(map, p); way += step) {
        for (std::size_t i = 0; i < 3; ++i) p[i] += sign * step * along[i];
    }
    return way;
}

/// How far the points that touch here are from where their lines came in and go out; of the thinnest place.
struct Wall {
    double in = 0, out = 0;
};

Wall wall_at(const vxs_voxmap &map, const vxs_pointshell &shell, const vxs_pose &pose, const Point &along)
{
    double r[9];
    vxs_pose_rotation(&pose, r);
    std::vector<Point> touching;
    for (std::uint32_t n = 0; n < shell.point_count; ++n) {
        const double x = shell.x[n], y = shell.y[n], z = shell.z[n];
        const Point p{r[0] * x + r[1] * y + r[2] * z + pose.position[0],
                      r[3] * x + r[4] * y + r[5] * z + pose.position[1],
                      r[6] * x + r[7] * y + r[8] * z + pose.position[2]};
        if (!is_free(map, p)) touching.push_back(p);
    }
    Wall thinnest{0, std::numeric_limits<double>::infinity()};
    for (std::size_t n = 0; n < touching.size(); n += touching.size() / most_rays + 1) {
        const Wall wall{way_out(map, touching[n], along, -1), way_out(map, touching[n], along, 1)};
        if (wall.in + wall.out < thinnest.in + thinnest.out) thinnest = wall;
    }
    return thinnest;
}

} // namespace

vxs_pose as_runtime(const Pose &pose)
{
    const auto &[x, y, z, w] = pose.rotation;
    return {{pose.position[0], pose.position[1], pose.position[2]}, {w, x, y, z}};
}

vxs_contact_config contact_of(const SceneFile &scene)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = scene.law == ContactLaw::original   ? VXS_CONTACT_ORIGINAL
                 : scene.law == ContactLaw::patch    ? VXS_CONTACT_PATCH
                 : scene.law == ContactLaw::gradient ? VXS_CONTACT_GRADIENT
                                                     : VXS_CONTACT_AVERAGE;
    config.field = scene.field == ContactField::layers     ? VXS_CONTACT_LAYERS
                   : scene.field == ContactField::distance ? VXS_CONTACT_DISTANCE
                                                           : VXS_CONTACT_SURFACE;
    config.weighting = scene.weighting == Weighting::area           ? VXS_CONTACT_AREA
                       : scene.weighting == Weighting::count_capped ? VXS_CONTACT_COUNT_CAPPED
                                                                    : VXS_CONTACT_COUNT;
    config.stiffness = scene.stiffness;
    config.most_stiffness = scene.most_stiffness;
    check(vxs_contact_config_check(&config), scene.path.string() + ": /contact");
    return config;
}

ContactStiffness contact_stiffness(const SceneFile &scene, const vxs_voxmap &map, const vxs_pointshell &shell)
{
    if (scene.most_stiffness > 0) {
        return {scene.most_stiffness, "the scene's most_stiffness"};
    }
    vxs_contact_config config = contact_of(scene);
    config.most_stiffness = std::numeric_limits<double>::max(); // bounds nothing, and is told
    Feeler feeler(map, shell, config);
    const double end = scene.hand.keyframes.back().t;
    const auto steps = static_cast<std::uint64_t>(std::clamp(end * scene.rate, 0.0, most_steps));
    double most = 0;
    for (std::uint64_t n = 0; n <= steps; ++n) {
        const double t = steps ? end * static_cast<double>(n) / static_cast<double>(steps) : 0;
        const vxs_contact_result &result = feeler.at(as_runtime(scene.hand.at(t)));
        if (result.points > 0) most = std::max(most, result.stiffness);
    }
    if (!(most > 0)) {
        throw Failure(ExitCode::invalid, scene.path.string(),
                      "the hand's path touches nothing, so that a design has no stiffness to go by; say "
                      "contact's \"most_stiffness\"");
    }
    return {most, "all that the hand's path asks for at once; \"most_stiffness\" would bound it"};
}

std::vector<Push> pushes(const SceneFile &scene, const vxs_voxmap &map, const vxs_pointshell &shell)
{
    Feeler feeler(map, shell, contact_of(scene));
    const auto touches = [&](double t) { return feeler.at(as_runtime(scene.hand.at(t))).depth > 0; };
    const double end = scene.hand.keyframes.back().t,
                 step = end / std::clamp(std::ceil(end * scene.rate), 1.0, most_steps);
    std::vector<Push> out;
    bool was_free = false;
    for (double t = 0; t < end + step / 2 && out.size() < most_pushes; t += step) {
        const bool is_touching = touches(t);
        const bool begins = is_touching && was_free;
        was_free = !is_touching;
        if (!begins) continue;
        double low = t - step, high = t;
        for (int n = 0; n < 30; ++n) (touches(0.5 * (low + high)) ? high : low) = 0.5 * (low + high);
        const Point from = scene.hand.at(t - step).position, to = scene.hand.at(t).position;
        Point along{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
        const double way = std::sqrt(along[0] * along[0] + along[1] * along[1] + along[2] * along[2]);
        if (way < 1e-6 * map.voxel) continue;
        for (double &x : along) x /= way;

        const vxs_pose touch = as_runtime(scene.hand.at(high));
        const Wall wall = wall_at(map, shell, touch, along);
        if (!(wall.in + wall.out > 0) || !std::isfinite(wall.out)) continue;
        Push push{{},
                  {},
                  std::max(map.voxel / 8, wall.out / 4000),
                  way / step,
                  std::max(wall.in + wall.out - map.voxel, 0.5 * map.voxel),
                  0.5 * (wall.out - wall.in)};
        for (double depth = 0; depth < wall.out + push.step; depth += push.step) {
            const vxs_contact_result &result = feeler.at(moved(touch, along, depth));
            push.force.push_back(-(result.wrench.force[0] * along[0] + result.wrench.force[1] * along[1] +
                                   result.wrench.force[2] * along[2]));
        }
        for (double at = std::max(high - before, 0.0); at < high + after; at += 1 / scene.rate) {
            const Point p = scene.hand.at(at).position;
            push.hand.push_back((p[0] - touch.position[0]) * along[0] +
                                (p[1] - touch.position[1]) * along[1] +
                                (p[2] - touch.position[2]) * along[2]);
        }
        out.push_back(push);
    }
    return out;
}

SceneContact scene_contact(const SceneFile &scene, const vxs_voxmap &map, const vxs_pointshell &shell)
{
    return {[&scene, &map, &shell] { return contact_stiffness(scene, map, shell); },
            [&scene, &map, &shell] { return pushes(scene, map, shell); }};
}

} // namespace voxshell
