// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/accuracy_path.hpp"

#include "plan/scene_contact.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxshell {
namespace {

constexpr std::size_t steps = 20'000;
constexpr double wrong_share = 0.01;
constexpr double piece_edge =
    0.31; ///< [cells]: a triangle of a 24th of a cell's face, and a cell gives 1.5 points
constexpr int most_halvings = 4;
constexpr double settled = 0.001;

/// Way of the hand at each of `steps` equal times, from 0 on.
std::vector<double> ways_of(const AccuracyScene &scene, double radius)
{
    const double end = scene.hand.keyframes.back().t;
    std::vector<double> ways{0};
    Pose last = scene.hand.at(0);
    for (std::size_t n = 1; n <= steps; ++n) {
        const Pose next = scene.hand.at(end * static_cast<double>(n) / steps);
        double square = 0, same = 0;
        for (std::size_t i = 0; i < 3; ++i)
            square += (next.position[i] - last.position[i]) * (next.position[i] - last.position[i]);
        for (std::size_t i = 0; i < 4; ++i) same += next.rotation[i] * last.rotation[i];
        const double turn = 2 * std::acos(std::min(1.0, std::abs(same)));
        ways.push_back(ways.back() + std::sqrt(square) + radius * turn);
        last = next;
    }
    return ways;
}

double time_at(const std::vector<double> &ways, double way, double end)
{
    const auto after = std::lower_bound(ways.begin() + 1, ways.end() - 1, way);
    const double before = *(after - 1), length = *after - before;
    const double share = length > 0 ? (way - before) / length : 0;
    return end * (static_cast<double>(after - 1 - ways.begin()) + share) / steps;
}

std::vector<Foundation> foundations(const AccuracyScene &scene, const FoundationSurface &surface,
                                    const Distance &distance, const std::vector<double> &times,
                                    double spacing, Progress &progress)
{
    std::vector<Foundation> all(times.size());
    tbb::parallel_for(std::size_t{0}, times.size(), [&](std::size_t n) {
        progress.check();
        all[n] = surface.at(hand_pose(scene, times[n]), distance, spacing);
    });
    return all;
}

bool is_usable(const Foundation &f, const Distance &distance, double below)
{
    if (!(f.gross > 0) || f.wrong > wrong_share * f.gross) return false;
    Point deeper = f.deepest_at;
    for (std::size_t i = 0; i < 3; ++i) deeper[i] -= below * f.deepest_out[i];
    return distance.side(deeper) < 0 &&
           distance.nearest(deeper, no_triangle).distance >= f.deepest + 0.9 * below;
}

std::vector<Wrench> wrenches(const std::vector<Foundation> &all)
{
    std::vector<Wrench> out;
    for (const Foundation &f : all) out.push_back(f.wrench);
    return out;
}

std::vector<double> numbers_of(const AccuracyPath &path)
{
    std::vector<double> out{path.spacing, path.halving,  path.pieces, path.deepest,
                            path.way,     path.touching, path.usable};
    for (std::size_t n = 0; n < path.times.size(); ++n) {
        out.insert(out.end(), {path.times[n], path.ways[n], static_cast<double>(path.parts[n])});
        for (const Point *p : {&path.reference[n].force, &path.reference[n].torque})
            out.insert(out.end(), p->begin(), p->end());
    }
    return out;
}

void read_numbers(const std::vector<double> &in, AccuracyPath &path)
{
    double *const head[] = {&path.spacing, &path.halving,  &path.pieces, &path.deepest,
                            &path.way,     &path.touching, &path.usable};
    std::size_t at = 0;
    for (double *number : head) *number = in[at++];
    while (at + 9 <= in.size()) {
        path.times.push_back(in[at]);
        path.ways.push_back(in[at + 1]);
        path.parts.push_back(static_cast<unsigned>(in[at + 2]));
        path.reference.push_back(
            {{in[at + 3], in[at + 4], in[at + 5]}, {in[at + 6], in[at + 7], in[at + 8]}});
        at += 9;
    }
}

/// Where, by a first coarse look; how many poses by what they cost.
double choose_poses(const AccuracyScene &scene, const FoundationSurface &surface, const Distance &distance,
                    const PathOptions &options, AccuracyPath &path, Progress &progress)
{
    const unsigned probes = options.probes, poses = options.poses;
    const double end = scene.hand.keyframes.back().t;
    const std::vector<double> ways = ways_of(scene, path.radius);
    path.way = ways.back();
    if (!(path.way > 0)) throw Failure(ExitCode::invalid, scene.given, "the hand does not move");
    std::vector<double> times;
    for (std::size_t n = 0; n < probes; ++n)
        times.push_back(time_at(ways, path.way * (static_cast<double>(n) + 0.5) / probes, end));
    const double coarse = 4 * piece_edge * scene.voxel;
    const std::vector<Foundation> found = foundations(scene, surface, distance, times, coarse, progress);
    std::vector<std::size_t> usable;
    double touching = 0, pieces = 0;
    for (std::size_t n = 0; n < probes; ++n) {
        touching += found[n].gross > 0;
        if (is_usable(found[n], distance, scene.voxel / 2)) {
            usable.push_back(n);
            pieces += static_cast<double>(found[n].pieces);
        }
    }
    path.touching = touching / probes;
    path.usable = static_cast<double>(usable.size()) / probes;
    if (usable.empty()) {
        throw Failure(ExitCode::invalid, scene.given,
                      touching > 0
                          ? "wherever the hand's path touches what stands it is so deep that the nearest "
                            "way out is another wall; let it press less"
                          : "the hand's path touches nothing");
    }
    pieces /= static_cast<double>(usable.size());
    const double dear = options.most_pieces / std::max(1.0, 64 * pieces); // three halvings from here
    const unsigned count =
        std::clamp(static_cast<unsigned>(std::min(dear, 1e6)), std::min(poses, options.least_poses), poses);
    unsigned part = 0;
    std::size_t last = usable.front();
    for (unsigned n = 0; n < count; ++n) {
        const double at = (n + 0.5) / count * static_cast<double>(usable.size());
        const auto whole = std::min(usable.size() - 1, static_cast<std::size_t>(at));
        const double way =
            path.way * (static_cast<double>(usable[whole]) + at - static_cast<double>(whole)) / probes;
        for (; last < usable[whole]; ++last) {
            if (!std::binary_search(usable.begin(), usable.end(), last + 1)) ++part;
        }
        path.times.push_back(time_at(ways, way, end));
        path.ways.push_back(way);
        path.parts.push_back(part);
    }
    return options.coarser * piece_edge * scene.voxel;
}

} // namespace

vxs_pose hand_pose(const AccuracyScene &scene, double t)
{
    return as_runtime(scene.hand.at(t));
}

double wrench_difference(const std::vector<Wrench> &a, const std::vector<Wrench> &b, double radius)
{
    double apart = 0, whole = 0;
    for (std::size_t n = 0; n < a.size(); ++n) {
        for (std::size_t i = 0; i < 3; ++i) {
            const double force = a[n].force[i] - b[n].force[i],
                         torque = (a[n].torque[i] - b[n].torque[i]) / radius;
            apart += force * force + torque * torque;
            whole += b[n].force[i] * b[n].force[i] + b[n].torque[i] * b[n].torque[i] / (radius * radius);
        }
    }
    return whole > 0 ? std::sqrt(apart / whole) : std::numeric_limits<double>::quiet_NaN();
}

AccuracyPath accuracy_path(const AccuracyScene &scene, const PathOptions &options, FinishedWork &work,
                           Progress &progress)
{
    AccuracyPath path;
    const FoundationSurface surface(scene.dynamic);
    path.radius = surface.radius();
    if (const std::vector<double> *done = work.find("reference " + scene.name)) {
        read_numbers(*done, path);
    } else {
        const MeshDistance mesh(scene.statics);
        const Distance distance = distance_of(mesh);
        path.spacing = choose_poses(scene, surface, distance, options, path, progress);
        path.reference = wrenches(foundations(scene, surface, distance, path.times, path.spacing, progress));
        path.halving = 1;
        for (int n = 0; n < most_halvings && path.halving > settled; ++n) {
            path.spacing /= 2;
            const std::vector<Foundation> finer =
                foundations(scene, surface, distance, path.times, path.spacing, progress);
            const std::vector<Wrench> next = wrenches(finer);
            path.halving = wrench_difference(path.reference, next, path.radius);
            path.reference = next;
            path.pieces = 0;
            for (const Foundation &f : finer) {
                path.pieces += static_cast<double>(f.pieces) / static_cast<double>(finer.size());
                path.deepest = std::max(path.deepest, f.deepest);
            }
        }
        work.add("reference " + scene.name, numbers_of(path));
    }
    path.apart = std::numeric_limits<double>::quiet_NaN();
    if (scene.ball) {
        for (const double t : path.times)
            path.formula.push_back(
                ball_foundation(scene.ball->radius, scene.hand.at(t).position, scene.ball->distance));
        path.apart = wrench_difference(path.reference, path.formula, path.radius);
    }
    return path;
}

} // namespace voxshell
