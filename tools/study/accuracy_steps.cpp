// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/accuracy_steps.hpp"

#include "plan/memory.hpp"

#include "voxshell/coupling.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

namespace voxshell {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double pi = std::numbers::pi;
constexpr unsigned window = 16, passes = 3;
constexpr double trace_seconds = 2, most_shift = 0.3;
constexpr double tie = 1e-5;       ///< [cells] to a plane: several roundings of a float
constexpr double off_plane = 0.29; ///< [cells]: no half, third or quarter

Point difference(const Point &a, const Point &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// Contact alone, evaluated at poses.
class Contact {
  public:
    Contact(const vxs_voxmap &map, const vxs_pointshell &shell, const Method &method)
        : statics_{&map, nullptr}, config_(contact_of(method, map.voxel)),
          room_(vxs_contact_memory(&shell, 1))
    {
        if (vxs_contact_init(room_.get(), room_.size(), &shell, 1, &contact) != VXS_OK)
            throw Failure(ExitCode::bug, "", "no contact");
    }
    Contact(const Contact &) = delete;
    Contact &operator=(const Contact &) = delete;
    vxs_contact_result at(const vxs_pose &pose)
    {
        vxs_contact_result result;
        vxs_contact_evaluate(contact, &statics_, 1, &pose, &config_, &result);
        return result;
    }
    vxs_contact *contact = nullptr;

  private:
    vxs_contact_static statics_;
    vxs_contact_config config_;
    Memory room_;
};

Wrench of(const vxs_wrench &w)
{
    return {{w.force[0], w.force[1], w.force[2]}, {w.torque[0], w.torque[1], w.torque[2]}};
}

std::vector<AccuracyConfig> compared(const AccuracyScene &scene)
{
    return {{scene.voxel, {ShellKind::exact, VXS_CONTACT_AVERAGE, VXS_CONTACT_SURFACE, VXS_CONTACT_COUNT}},
            {scene.voxel, {ShellKind::exact, VXS_CONTACT_GRADIENT, VXS_CONTACT_DISTANCE, VXS_CONTACT_AREA}}};
}

} // namespace

const vxs_voxmap &StepAssets::map()
{
    if (!map_.part) {
        PartOptions options;
        options.voxel = scene_.voxel;
        options.channels = {static_cast<int>(reach_of(VXS_CONTACT_LAYERS, scene_.voxel, path_.deepest)),
                            reach_of(VXS_CONTACT_DISTANCE, scene_.voxel, path_.deepest)};
        map_ = make_part("static", scene_.statics, options, progress_);
    }
    return map_.part->map;
}

const vxs_pointshell &StepAssets::shell(ShellKind kind)
{
    MadePart &made = shells_[kind == ShellKind::exact];
    if (!made.part) {
        PartOptions options;
        options.voxel = scene_.voxel;
        options.shell = kind;
        options.stands = false;
        made = make_part("dynamic", scene_.dynamic, options, progress_);
    }
    return made.part->shell;
}

std::vector<CullingRow> run_culling(const AccuracyScene &scene, const AccuracyPath &path, StepAssets &assets,
                                    FinishedWork &work, Progress &progress)
{
    const struct {
        const char *name;
        std::uint32_t kernel, culling;
    } modes[] = {{"every point, plain C", VXS_CONTACT_SCALAR, VXS_CONTACT_BRUTE},
                 {"every point", VXS_CONTACT_FASTEST, VXS_CONTACT_BRUTE},
                 {"culled", VXS_CONTACT_FASTEST, VXS_CONTACT_CULLED},
                 {"coherent", VXS_CONTACT_FASTEST, VXS_CONTACT_COHERENT}};
    std::vector<CullingRow> rows;
    std::vector<vxs_pose> poses;
    for (const double t : path.times) {
        for (unsigned k = window; k-- > 0;) poses.push_back(hand_pose(scene, t - k / scene.rate));
    }
    const auto count = static_cast<double>(poses.size());
    for (const AccuracyConfig &config : compared(scene)) {
        const std::string name = "culling " + config.text();
        const std::vector<double> *done = work.find(name);
        if (!done) {
            std::vector<vxs_wrench> plain;
            std::vector<double> numbers;
            for (const auto &mode : modes) {
                Contact contact(assets.map(), assets.shell(ShellKind::exact), config.method);
                if (vxs_contact_use(contact.contact, mode.kernel) != VXS_OK ||
                    vxs_contact_cull(contact.contact, mode.culling) != VXS_OK)
                    throw Failure(ExitCode::bug, scene.name, "a kernel that this machine has not");
                std::vector<float> ns(poses.size(), std::numeric_limits<float>::infinity());
                std::vector<vxs_wrench> wrenches(poses.size());
                double probed = 0, differing = 0;
                for (unsigned pass = 0; pass < passes; ++pass) {
                    for (std::size_t n = 0; n < poses.size(); ++n) {
                        const auto begin = Clock::now();
                        const vxs_contact_result result = contact.at(poses[n]);
                        ns[n] = std::min(
                            ns[n], std::chrono::duration<float, std::nano>(Clock::now() - begin).count());
                        wrenches[n] = result.wrench;
                        if (pass == 0) probed += result.probed;
                    }
                    progress.check();
                }
                if (plain.empty()) plain = wrenches;
                for (std::size_t n = 0; n < poses.size(); ++n)
                    differing += std::memcmp(&wrenches[n], &plain[n], sizeof plain[n]) != 0;
                const Durations d = durations(ns);
                numbers.insert(numbers.end(), {differing, probed / count, d.p50, d.p99, d.p999, d.max});
            }
            done = &work.add(name, std::move(numbers));
        }
        const double *v = done->data();
        for (const auto &mode : modes) {
            rows.push_back({config.text(), mode.name, count, v[0], v[1], {v[2], v[3], v[4], v[5]}});
            v += 6;
        }
        progress.advance(1);
    }
    return rows;
}

namespace {

/// A shell's points in doubles: what they were before they were stored.
struct ExactPoint {
    Point at, normal;
};

std::vector<ExactPoint> exact_points(const vxs_pointshell &shell, const MeshDistance &mesh, double &moved)
{
    std::vector<ExactPoint> points;
    for (std::uint32_t n = 0; n < shell.point_count; ++n) {
        const Point stored{shell.x[n], shell.y[n], shell.z[n]};
        ExactPoint p{stored, {shell.nx[n], shell.ny[n], shell.nz[n]}};
        if (shell.kind == VXS_POINTSHELL_NAIVE) {
            for (double &x : p.at) x = (std::floor(x / shell.voxel) + 0.5) * shell.voxel;
        } else {
            p.at = mesh.foot(stored); // of the rounding, its part along the normal
        }
        const double size = std::sqrt(dot(p.normal, p.normal));
        for (double &x : p.normal) x /= size;
        const Point way = difference(p.at, stored);
        moved = std::max(moved, std::sqrt(dot(way, way)));
        points.push_back(p);
    }
    return points;
}

struct InDoubles {
    Wrench wrench;
    double colliding = 0, gross = 0, in_planes = 0; ///< gross: sum of |force|; in_planes: of all points
};

/// METHOD section 3, original and average on the surface's cells, with k = 1 / h, as it reads.
InDoubles in_doubles(const std::vector<ExactPoint> &points, const vxs_voxmap &map, const vxs_pose &pose,
                     bool average)
{
    InDoubles out;
    double r[9];
    vxs_pose_rotation(&pose, r);
    const auto turned = [&](const Point &v) {
        return Point{r[0] * v[0] + r[1] * v[1] + r[2] * v[2], r[3] * v[0] + r[4] * v[1] + r[5] * v[2],
                     r[6] * v[0] + r[7] * v[1] + r[8] * v[2]};
    };
    struct Hit {
        Point arm, to_middle, normal;
    };
    std::vector<Hit> hits;
    Point mean{};
    for (const ExactPoint &p : points) {
        const Point arm = turned(p.at);
        const double at[3] = {pose.position[0] + arm[0], pose.position[1] + arm[1],
                              pose.position[2] + arm[2]};
        out.in_planes += std::any_of(
            at, at + 3, [&](double x) { return std::abs(x / map.voxel - std::round(x / map.voxel)) < tie; });
        std::int64_t cell[3];
        if (!vxs_voxmap_cell_of(&map, at, cell) ||
            vxs_voxmap_state_at(&map, cell[0], cell[1], cell[2]) != VXS_CELL_SURFACE)
            continue;
        Hit hit{arm, {}, turned(p.normal)};
        for (std::size_t i = 0; i < 3; ++i) {
            hit.to_middle[i] = map.voxel * (static_cast<double>(cell[i]) + 0.5) - at[i];
            mean[i] += hit.normal[i];
        }
        hits.push_back(hit);
    }
    out.colliding = static_cast<double>(hits.size());
    const double size = std::sqrt(dot(mean, mean));
    for (const Hit &hit : hits) {
        const Point n = average ? Point{mean[0] / size, mean[1] / size, mean[2] / size} : hit.normal;
        const double depth = std::max(0.0, dot(hit.to_middle, n)) / map.voxel;
        const Point turn = cross(hit.arm, n);
        for (std::size_t i = 0; i < 3; ++i) {
            out.wrench.force[i] += depth * n[i];
            out.wrench.torque[i] += depth * turn[i];
        }
        out.gross += depth;
    }
    return out;
}

RoundingRow measured(const std::vector<vxs_pose> &poses, const std::vector<ExactPoint> &points,
                     const vxs_voxmap &map, const vxs_pointshell &shell, const Method &method, double radius,
                     Progress &progress)
{
    Contact contact(map, shell, method);
    std::vector<Wrench> stored, exact;
    double apart = 0, all = 0, gross = 0, net = 0;
    RoundingRow row{};
    for (const vxs_pose &pose : poses) {
        progress.check();
        const vxs_contact_result result = contact.at(pose);
        const InDoubles found = in_doubles(points, map, pose, method.law == VXS_CONTACT_AVERAGE);
        row.in_planes += found.in_planes / static_cast<double>(points.size() * poses.size());
        if (result.flags & VXS_CONTACT_MEAN_CANCELLED) continue; // another law
        exact.push_back(found.wrench);
        stored.push_back(of(result.wrench));
        apart += std::abs(found.colliding - result.points);
        all += found.colliding;
        gross += found.gross;
        net += std::sqrt(dot(found.wrench.force, found.wrench.force));
    }
    double square = 0, worst = 0;
    for (std::size_t n = 0; n < exact.size(); ++n) {
        const Point f = difference(stored[n].force, exact[n].force),
                    m = difference(stored[n].torque, exact[n].torque);
        worst = std::max(worst, std::sqrt(dot(f, f) + dot(m, m) / (radius * radius)));
        square += (dot(exact[n].force, exact[n].force) +
                   dot(exact[n].torque, exact[n].torque) / (radius * radius)) /
                  static_cast<double>(exact.size());
    }
    row.wrench = wrench_difference(stored, exact, radius);
    row.worst = worst / std::sqrt(square);
    row.other_cells = all > 0 ? apart / all : 0;
    row.cancelled = gross / net;
    return row;
}

} // namespace

std::vector<RoundingRow> run_rounding(const AccuracyScene &scene, const AccuracyPath &path,
                                      StepAssets &assets, FinishedWork &work, Progress &progress)
{
    std::vector<RoundingRow> rows;
    for (const ShellKind kind : {ShellKind::naive, ShellKind::exact}) {
        for (const std::uint32_t law : {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE}) {
            const AccuracyConfig config{scene.voxel, {kind, law, VXS_CONTACT_SURFACE, VXS_CONTACT_COUNT}};
            for (const bool is_moved : {false, true}) {
                const std::string poses_text = is_moved ? "moved" : "as they are",
                                  name = "rounding " + config.text() + ", " + poses_text;
                const std::vector<double> *done = work.find(name);
                if (!done) {
                    double moved = 0;
                    const std::vector<ExactPoint> points =
                        exact_points(assets.shell(kind), MeshDistance(scene.dynamic), moved);
                    std::vector<vxs_pose> poses;
                    for (const double t : path.times) {
                        poses.push_back(hand_pose(scene, t));
                        if (!is_moved) continue;
                        for (double &x : poses.back().position) x += off_plane * scene.voxel;
                    }
                    const RoundingRow r = measured(poses, points, assets.map(), assets.shell(kind),
                                                   config.method, path.radius, progress);
                    done =
                        &work.add(name, {r.wrench, r.worst, r.other_cells, moved, r.in_planes, r.cancelled});
                }
                const std::vector<double> &v = *done;
                rows.push_back({config.text(), poses_text, v[0], v[1], v[2], v[3], v[4], v[5]});
            }
            progress.advance(1);
        }
    }
    return rows;
}

namespace {

/// The longest part of the path that stays in contact, as ways and the forces there.
struct Stretch {
    std::size_t first = 0, count = 0;
};

Stretch longest(const AccuracyPath &path)
{
    Stretch best;
    for (std::size_t begin = 0, end = 0; begin < path.parts.size(); begin = end) {
        while (end < path.parts.size() && path.parts[end] == path.parts[begin]) ++end;
        if (end - begin > best.count) best = {begin, end - begin};
    }
    return best;
}

/// Poses and reference, tick by tick, there and back.
struct Stroke {
    std::vector<vxs_pose> poses;
    std::vector<Point> ideal;
};

Stroke stroke_of(const AccuracyScene &scene, const AccuracyPath &path)
{
    const Stretch s = longest(path);
    Stroke stroke;
    const double first = path.times[s.first], last = path.times[s.first + s.count - 1];
    const double end = scene.hand.keyframes.back().t, mean = path.way / end;
    const double length = path.ways[s.first + s.count - 1] - path.ways[s.first];
    // At its own speed in time; where the path rests its way does not go on, and so neither does this.
    const double ticks_there = std::max(2.0, std::round(std::max(length / mean, 1e-9) * scene.rate));
    const auto count = static_cast<std::size_t>(trace_seconds * scene.rate);
    for (std::size_t n = 0; n < count; ++n) {
        double share = std::fmod(static_cast<double>(n) / ticks_there, 2.0);
        if (share > 1) share = 2 - share;
        const double way = path.ways[s.first] + share * length;
        std::size_t k = s.first;
        while (k + 2 < s.first + s.count && path.ways[k + 1] < way) ++k;
        const std::size_t next = std::min(k + 1, s.first + s.count - 1);
        const double gap = path.ways[next] - path.ways[k], part = gap > 0 ? (way - path.ways[k]) / gap : 0;
        const double t = path.times[k] + part * (path.times[next] - path.times[k]);
        stroke.poses.push_back(hand_pose(scene, std::clamp(t, first, last)));
        Point ideal;
        for (std::size_t i = 0; i < 3; ++i)
            ideal[i] = (1 - part) * path.reference[k].force[i] + part * path.reference[next].force[i];
        stroke.ideal.push_back(ideal);
    }
    return stroke;
}

std::vector<Point> filtered(const std::vector<Point> &forces, double hertz, double rate)
{
    if (hertz == 0) return forces;
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.kind = VXS_COUPLING_PT2;
    config.sample_time = 1 / rate;
    config.omega0 = 2 * pi * hertz;
    config.damping = 1;
    const Memory room(vxs_coupling_memory());
    vxs_coupling *coupling = nullptr;
    if (vxs_coupling_init(room.get(), room.size(), &config, &coupling) != VXS_OK)
        throw Failure(ExitCode::bug, "", "no filter");
    const vxs_pose still = vxs_pose_identity();
    vxs_coupling_reset(coupling, &still);
    std::vector<Point> out;
    for (const Point &f : forces) {
        const vxs_wrench in = {{f[0], f[1], f[2]}, {0, 0, 0}};
        vxs_wrench w;
        vxs_coupling_step(coupling, &in, &still, &w);
        out.push_back({w.force[0], w.force[1], w.force[2]});
    }
    return out;
}

/// By how many ticks `in` is to be shifted to be nearest to `out`, to a part of a tick.
double shift_of(const std::vector<Point> &in, const std::vector<Point> &out, double rate)
{
    const auto most = static_cast<std::size_t>(most_shift * rate);
    std::vector<double> apart;
    for (std::size_t shift = 0; shift <= most; ++shift) {
        double sum = 0;
        for (std::size_t n = most; n < out.size(); ++n) {
            const Point d = difference(out[n], in[n - shift]);
            sum += dot(d, d);
        }
        apart.push_back(sum);
    }
    const auto best = static_cast<std::size_t>(std::min_element(apart.begin(), apart.end()) - apart.begin());
    double part = 0;
    if (best > 0 && best < most) {
        const double a = apart[best - 1], b = apart[best], c = apart[best + 1];
        if (a - 2 * b + c > 0) part = (a - c) / (2 * (a - 2 * b + c));
    }
    return (static_cast<double>(best) + part) / rate;
}

} // namespace

std::vector<FilterRow> run_filter(const AccuracyScene &scene, const AccuracyPath &path,
                                  const std::vector<AccuracyConfig> &configs, StepAssets &assets,
                                  FinishedWork &work, Progress &progress)
{
    std::vector<FilterRow> rows;
    if (const Stretch s = longest(path);
        s.count < 2 || !(path.ways[s.first + s.count - 1] > path.ways[s.first])) {
        progress.advance(configs.size());
        return rows;
    }
    for (const AccuracyConfig &config : configs) {
        const std::string name = "filter " + config.text();
        const std::vector<double> *done = work.find(name);
        if (!done) {
            Contact contact(assets.map(), assets.shell(config.method.shell), config.method);
            const Stroke stroke = stroke_of(scene, path);
            std::vector<Point> forces;
            double cross_sum = 0, square = 0, whole = 0;
            for (std::size_t n = 0; n < stroke.poses.size(); ++n) {
                forces.push_back(of(contact.at(stroke.poses[n]).wrench).force);
                cross_sum += dot(forces[n], stroke.ideal[n]);
                square += dot(forces[n], forces[n]);
                whole += dot(stroke.ideal[n], stroke.ideal[n]);
                if (n % 256 == 0) progress.check();
            }
            const double factor = square > 0 ? cross_sum / square : 0;
            std::vector<double> numbers;
            std::vector<double> frequencies{0};
            frequencies.insert(frequencies.end(), std::begin(filter_hertz), std::end(filter_hertz));
            for (const double hertz : frequencies) {
                const std::vector<Point> out = filtered(forces, hertz, scene.rate),
                                         ideal = filtered(stroke.ideal, hertz, scene.rate);
                Point mean{};
                double noise = 0;
                const double count = static_cast<double>(out.size());
                std::vector<Point> error;
                for (std::size_t n = 0; n < out.size(); ++n) {
                    error.emplace_back();
                    for (std::size_t i = 0; i < 3; ++i) {
                        error[n][i] = factor * out[n][i] - ideal[n][i];
                        mean[i] += error[n][i] / count;
                    }
                }
                for (const Point &e : error) noise += dot(difference(e, mean), difference(e, mean));
                numbers.insert(numbers.end(),
                               {hertz, shift_of(stroke.ideal, ideal, scene.rate), std::sqrt(noise / whole)});
            }
            done = &work.add(name, std::move(numbers));
        }
        for (std::size_t n = 0; n + 3 <= done->size(); n += 3) {
            const double hertz = (*done)[n];
            rows.push_back(
                {config, hertz, hertz > 0 ? 2 / (2 * pi * hertz) : 0, (*done)[n + 1], (*done)[n + 2]});
        }
        progress.advance(1);
    }
    return rows;
}

} // namespace voxshell
