// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/accuracy_scene.hpp"

#include "container/container.hpp"
#include "pipeline/convert_scene.hpp"
#include "study/bodies.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <span>

namespace voxshell {
namespace {

constexpr double pi = std::numbers::pi, mm = 1e-3;
constexpr double ball_radius = 20 * mm, plane_tilt = 60 * mm, bowl_radius = 40 * mm, drum_radius = 30 * mm;
constexpr double deepest = 1.5 * mm; ///< of the own scenes: within a force layer and a half of their cells
constexpr std::uint32_t fine = 480, ball_rings = 128;

std::uint32_t number_of(ContactLaw law)
{
    return law == ContactLaw::original  ? VXS_CONTACT_ORIGINAL
           : law == ContactLaw::average ? VXS_CONTACT_AVERAGE
           : law == ContactLaw::patch   ? VXS_CONTACT_PATCH
                                        : VXS_CONTACT_GRADIENT;
}

std::uint32_t number_of(ContactField field)
{
    return field == ContactField::surface  ? VXS_CONTACT_SURFACE
           : field == ContactField::layers ? VXS_CONTACT_LAYERS
                                           : VXS_CONTACT_DISTANCE;
}

std::uint32_t number_of(Weighting weighting)
{
    return weighting == Weighting::count          ? VXS_CONTACT_COUNT
           : weighting == Weighting::count_capped ? VXS_CONTACT_COUNT_CAPPED
                                                  : VXS_CONTACT_AREA;
}

AccuracyScene of_file(const std::string &given)
{
    const SceneFile file = read_scene(given);
    const SceneGeometry geometry = read_geometry(file);
    if (!geometry.moving.empty())
        throw Failure(ExitCode::unsupported, given,
                      "a part that stands has a path; the accuracy study takes scenes whose statics stay");
    AccuracyScene scene;
    scene.name = scene_name(file.path);
    scene.given = file.path.filename().string();
    scene.statics = flatten(geometry.statics);
    scene.dynamic = flatten(geometry.dynamic);
    scene.hand = file.hand;
    scene.rate = file.rate;
    scene.voxel = file.voxel;
    scene.method = {ShellKind::exact, number_of(file.law), number_of(file.field), number_of(file.weighting)};
    if (file.coupling == CouplingKind::quasi_static || file.coupling == CouplingKind::designed)
        scene.evaluations = file.evaluations;
    Sha256Stream hash;
    hash.update(file.source_hash);
    hash.update(geometry.statics.source_hash);
    hash.update(geometry.dynamic.source_hash);
    scene.hash = hex(hash.digest());
    return scene;
}

Mesh bowl()
{
    constexpr std::uint32_t rings = 120;
    const double wall = bowl_radius + 10 * mm;
    std::vector<ProfilePoint> profile{{0, -wall}, {wall, -wall}, {wall, 0}};
    for (std::uint32_t n = 0; n <= rings; ++n) {
        const double polar = pi / 2 * n / rings;
        profile.push_back({n == rings ? 0 : bowl_radius * std::cos(polar), -bowl_radius * std::sin(polar)});
    }
    return revolved(profile, fine);
}

Pose at(const Point &position)
{
    Pose pose;
    pose.position = position;
    return pose;
}

/// In and along, where `out` leads away from the surface at `start`; turns are about the scene's origin.
HandPath sliding(const Point &start, const Point &out, const HandPath::Keyframe::Turn &turn)
{
    const auto off = [&](double high) {
        return at({start[0] + high * out[0], start[1] + high * out[1], start[2] + high * out[2]});
    };
    HandPath path;
    path.keyframes.push_back({0.0, off(mm), {}});
    path.keyframes.push_back({0.2, off(-deepest), {}});
    Pose end = off(-deepest);
    const double half = turn.angle / 2;
    end.position = rotate({turn.axis[0] * std::sin(half), turn.axis[1] * std::sin(half),
                           turn.axis[2] * std::sin(half), std::cos(half)},
                          end.position); // about the scene's origin
    path.keyframes.push_back({1.2, end, turn});
    return path;
}

AccuracyScene own_scene(const std::string &name)
{
    AccuracyScene scene;
    scene.name = scene.given = name;
    scene.dynamic = ball(ball_radius, ball_rings);
    scene.voxel = mm;
    scene.method = {ShellKind::exact, VXS_CONTACT_AVERAGE, VXS_CONTACT_SURFACE, VXS_CONTACT_COUNT};
    if (name == "ball-on-plane") {
        const Point out = tilted({0, 0, 1});
        scene.statics = tilted(slab(plane_tilt, 0, 12 * mm));
        scene.ball = {ball_radius, distance_of([out](const Point &p) {
                          return Nearest{p[0] * out[0] + p[1] * out[1] + p[2] * out[2], out};
                      })};
        const Point start = tilted({15 * mm, 0, ball_radius});
        scene.hand = sliding(start, out, {{0, 0, 0}, out, pi / 2});
    } else if (name == "ball-on-cylinder") {
        scene.statics = cylinder(drum_radius, 40 * mm, fine);
        scene.ball = {ball_radius, distance_of([](const Point &p) {
                          const double r = std::hypot(p[0], p[1]);
                          return Nearest{r - drum_radius, {p[0] / r, p[1] / r, 0}};
                      })};
        scene.hand =
            sliding({drum_radius + ball_radius, 0, 0.3 * mm}, {1, 0, 0}, {{0, 0, 0}, {0, 0, 1}, pi / 2});
    } else {
        scene.statics = bowl();
        scene.ball = {ball_radius, distance_of([](const Point &p) {
                          const double r = std::hypot(p[0], p[1], p[2]);
                          return Nearest{bowl_radius - r, {-p[0] / r, -p[1] / r, -p[2] / r}};
                      })};
        const double polar = pi / 6; // off the bottom: askew to the grid
        const Point out{-std::sin(polar), 0, std::cos(polar)};
        const double way = bowl_radius - ball_radius;
        scene.hand = sliding({-way * out[0], 0, -way * out[2]}, out, {{0, 0, 0}, {0, 0, 1}, pi / 2});
    }
    const std::string text = fmt::format("{} {}", name, 1);
    scene.hash = hex(sha256(std::span(reinterpret_cast<const std::uint8_t *>(text.data()), text.size())));
    return scene;
}

} // namespace

std::vector<std::string> own_scenes()
{
    return {"ball-on-plane", "ball-on-cylinder", "ball-in-bowl"};
}

AccuracyScene accuracy_scene(const std::string &given)
{
    if (given.ends_with(".scene.json")) return of_file(given);
    for (const std::string &name : own_scenes()) {
        if (given == name) return own_scene(name);
    }
    throw Failure(
        ExitCode::usage, given,
        "a scene ends in .scene.json; the study's own are ball-on-plane, ball-on-cylinder and ball-in-bowl");
}

} // namespace voxshell
