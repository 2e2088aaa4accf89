// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/accuracy_run.hpp"

#include "cli/options.hpp"
#include "plan/memory.hpp"
#include "plan/scene_contact.hpp"

#include "voxshell/servo.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>
#include <span>

namespace voxshell {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double pi = std::numbers::pi, nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double felt_share = 0.05; ///< of the reference's peak: below that a direction is not asked for
constexpr unsigned full_turns = 3, quick_turns = 2;
constexpr double least_reach = 3; ///< of convert, for a scene [cells]
/// A finer voxel is left out where the band around what stands has more cells than that, or the shell points.
constexpr double most_cells = 4e7, quick_cells = 4e6, most_points = 3e5, quick_points = 3e4;
constexpr double most_visits = 1.5e7; ///< points x ticks of a walk: beyond it windows get shorter

/// "VmRSS:" or "VmHWM:" [bytes].
double memory_line(const std::string &name)
{
    std::ifstream status("/proc/self/status");
    std::string word;
    while (status >> word) {
        double kilobytes = 0;
        if (word == name && status >> kilobytes) return 1024 * kilobytes;
    }
    return nothing;
}

bool forget_peak()
{
    std::ofstream refs("/proc/self/clear_refs");
    refs << "5" << std::flush; // the high-water mark becomes what is there now
    return static_cast<bool>(refs);
}

vxs_pose inverse_turn(const Turn &turn)
{
    return {{0, 0, 0}, {turn[0], -turn[1], -turn[2], -turn[3]}};
}

std::vector<double> numbers_of(const AccuracyRow &r)
{
    return {r.error,     r.force,       r.torque,        r.size,    r.angle_mean, r.angle_p95,
            r.missing,   r.stiffness,   r.points,        r.hits,    r.probed,     r.probed_most,
            r.deep,      r.asset_bytes, r.runtime_bytes, r.reach,   r.tick.p50,   r.tick.p99,
            r.tick.p999, r.tick.max,    r.mean_ns,       r.most_ns, r.conversion, r.conversion_bytes};
}

AccuracyRow read_numbers(const AccuracyConfig &config, const std::vector<double> &n)
{
    if (n.size() != 24) throw Failure(ExitCode::bug, "", "a finished row of another length");
    return {config, n[0],  n[1],  n[2],  n[3],  n[4],  n[5],  n[6],  n[7],
            n[8],   n[9],  n[10], n[11], n[12], n[13], n[14], n[15], {n[16], n[17], n[18], n[19]},
            n[20],  n[21], n[22], n[23]};
}

/// All assets of one voxel edge, each made when it is first asked for.
class Assets {
  public:
    Assets(const AccuracyScene &scene, double voxel, double deepest, Progress &progress)
        : scene_(scene), voxel_(voxel), deepest_(deepest), progress_(progress)
    {
    }
    const MadePart &map(std::uint32_t field)
    {
        MadePart &made = maps_[field - VXS_CONTACT_SURFACE];
        if (made.part) return made;
        PartOptions options;
        options.voxel = voxel_;
        const double reach = reach_of(field, voxel_, deepest_);
        if (field == VXS_CONTACT_LAYERS) options.channels.layers = static_cast<int>(reach);
        if (field == VXS_CONTACT_DISTANCE) options.channels.distance_cells = reach;
        return made = make_part("static", scene_.statics, options, progress_);
    }
    const MadePart &shell(ShellKind kind, unsigned seed)
    {
        auto &made = shells_[kind == ShellKind::exact];
        if (made.size() <= seed) made.resize(seed + 1);
        if (made[seed].part) return made[seed];
        PartOptions options;
        options.voxel = voxel_;
        options.shell = kind;
        options.stands = false;
        return made[seed] =
                   make_part("dynamic", turned_mesh(scene_.dynamic, turn_of(seed)), options, progress_);
    }

  private:
    const AccuracyScene &scene_;
    double voxel_, deepest_;
    Progress &progress_;
    MadePart maps_[3];
    std::vector<MadePart> shells_[2];
};

AccuracyRow run_config(const AccuracyScene &scene, const AccuracyPath &path, const AccuracyConfig &config,
                       unsigned turns, Assets &assets, Progress &progress)
{
    AccuracyRow row{};
    row.config = config;
    const MadePart &stands = assets.map(config.method.field);
    std::vector<Wrench> wrenches;
    std::vector<float> ns;
    double deep = 0;
    for (unsigned seed = 0; seed < turns; ++seed) {
        progress.check();
        const MadePart &moves = assets.shell(config.method.shell, seed);
        const Walk w =
            walk(scene, path, stands.part->map, moves.part->shell, config.method, turn_of(seed), {});
        wrenches.insert(wrenches.end(), w.wrenches.begin(), w.wrenches.end());
        ns.insert(ns.end(), w.ns.begin(), w.ns.end());
        for (const std::uint32_t flags : w.flags) deep += (flags & VXS_CONTACT_DEEP) != 0;
        row.most_ns = std::max(row.most_ns, w.most_ns);
        row.hits += w.hits / turns;
        row.probed += w.probed / turns;
        row.probed_most = std::max(row.probed_most, w.probed_most);
    }
    score(wrenches, path, row);
    row.deep = deep / static_cast<double>(wrenches.size());
    for (const float x : ns) row.mean_ns += double{x} / static_cast<double>(ns.size());
    row.tick = durations(ns);
    const MadePart &moves = assets.shell(config.method.shell, 0);
    row.points = moves.part->shell.point_count;
    row.asset_bytes = static_cast<double>(stands.part->map_file().size + moves.part->shell_file().size);
    row.runtime_bytes = row.asset_bytes + static_cast<double>(vxs_contact_memory(&moves.part->shell, 1));
    row.reach = reach_of(config.method.field, config.voxel, path.deepest);
    row.conversion = stands.seconds + moves.seconds;
    row.conversion_bytes = std::max(stands.bytes, moves.bytes);
    return row;
}

} // namespace

double area_of(const Mesh &mesh)
{
    double sum = 0;
    for (const Triangle &t : mesh.triangles) {
        const Point &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
        const Point u{b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v{c[0] - a[0], c[1] - a[1], c[2] - a[2]};
        sum += length({u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]}) / 2;
    }
    return sum;
}

std::string AccuracyConfig::text() const
{
    return fmt::format("{}, {}, {}, {}, {}", format_length(voxel), shell_name(method.shell),
                       law_name(method.law), field_name(method.field), weighting_name(method.weighting));
}

bool AccuracyConfig::operator==(const AccuracyConfig &other) const
{
    return voxel == other.voxel && method.shell == other.method.shell && method.law == other.method.law &&
           method.field == other.method.field && method.weighting == other.method.weighting;
}

MadePart make_part(const std::string &name, const Mesh &mesh, const PartOptions &options, Progress &progress)
{
    /// Stages of a conversion are not the study's.
    class Inside : public Progress {
      public:
        explicit Inside(Progress &outer) : outer_(outer) {}
        void check() override { outer_.check(); }

      private:
        Progress &outer_;
    } inside(progress);
    MadePart made;
    const double before = memory_line("VmRSS:");
    const bool is_told = forget_peak();
    const auto begin = Clock::now();
    made.part = std::make_unique<OpenPart>(name, mesh, options, inside);
    made.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    made.bytes = is_told ? std::max(0.0, memory_line("VmHWM:") - before) : nothing;
    return made;
}

Turn turn_of(unsigned seed)
{
    if (seed == 0) return as_is;
    const Draw drawn = draw(seed);
    return {drawn.orientation[0], drawn.orientation[1], drawn.orientation[2], drawn.orientation[3]};
}

Mesh turned_mesh(Mesh mesh, const Turn &turn)
{
    if (turn == as_is) return mesh;
    const Quaternion q{turn[1], turn[2], turn[3], turn[0]};
    for (Point &p : mesh.vertices) p = rotate(q, p);
    return mesh;
}

vxs_pose turned_pose(const vxs_pose &pose, const Turn &turn)
{
    if (turn == as_is) return pose;
    const vxs_pose back = inverse_turn(turn);
    vxs_pose out{};
    vxs_pose_compose(&pose, &back, &out);
    return out;
}

vxs_contact_config contact_of(const Method &method, double voxel)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = method.law;
    config.field = method.field;
    config.weighting = method.weighting;
    config.stiffness = method.weighting == VXS_CONTACT_AREA ? 1 / (voxel * voxel * voxel) : 1 / voxel;
    return config;
}

Walk walk(const AccuracyScene &scene, const AccuracyPath &path, const vxs_voxmap &map,
          const vxs_pointshell &shell, const Method &method, const Turn &turn, const WalkOptions &options)
{
    const vxs_contact_static statics{&map, nullptr};
    vxs_servo_config config;
    vxs_servo_config_default(&config);
    config.statics = &statics;
    config.static_count = 1;
    config.shell = &shell;
    config.contact = contact_of(method, map.voxel);
    config.coupling.kind = VXS_COUPLING_NONE;
    config.coupling.sample_time = 1 / scene.rate;
    config.max_speed = 1e6; // from one window to the next
    config.effects = nullptr;
    config.effect_count = 0;
    const double poses = static_cast<double>(path.times.size());
    const auto window = static_cast<unsigned>(std::clamp(
        std::floor(most_visits / (poses * shell.point_count)), 3.0, static_cast<double>(options.window)));
    Walk all;
    const Memory room(vxs_servo_memory(&config));
    for (unsigned pass = 0; pass < options.passes; ++pass) {
        vxs_servo *servo = nullptr;
        if (vxs_servo_init(room.get(), room.size(), &config, &servo) != VXS_OK)
            throw Failure(ExitCode::bug, scene.name, "no servo");
        vxs_device_state state{};
        state.state = VXS_DEVICE_ARMED;
        vxs_device_command command{};
        vxs_servo_trace trace{};
        std::size_t tick = 0;
        for (std::size_t n = 0; n < path.times.size(); ++n) {
            for (unsigned k = window; k-- > 0;) {
                state.pose = turned_pose(hand_pose(scene, path.times[n] - k / scene.rate), turn);
                ++state.sequence;
                state.time_ns += static_cast<std::int64_t>(1e9 / scene.rate);
                const auto begin = Clock::now();
                vxs_servo_tick(servo, &state, &command, &trace);
                const float ns = std::chrono::duration<float, std::nano>(Clock::now() - begin).count();
                if (trace.flags & (std::uint32_t{VXS_SERVO_FAULT} | std::uint32_t{VXS_CONTACT_INVALID}))
                    throw Failure(ExitCode::bug, scene.name, "the servo refused a pose");
                if (k + 1 == window) continue; // comes from elsewhere
                all.most_ns = std::max(all.most_ns, double{ns});
                if (pass == 0) {
                    all.ns.push_back(ns);
                    all.hits += trace.points;
                    all.probed += trace.probed;
                    all.probed_most = std::max(all.probed_most, static_cast<double>(trace.probed));
                } else {
                    all.ns[tick] = std::min(all.ns[tick], ns);
                }
                ++tick;
            }
            if (pass > 0) continue;
            const double *f = trace.collision.force, *t = trace.collision.torque;
            all.wrenches.push_back({{f[0], f[1], f[2]}, {t[0], t[1], t[2]}});
            all.flags.push_back(trace.flags);
        }
    }
    all.hits /= static_cast<double>(all.ns.size());
    all.probed /= static_cast<double>(all.ns.size());
    return all;
}

void score(const std::vector<Wrench> &wrenches, const AccuracyPath &path, AccuracyRow &row)
{
    const double r = path.radius;
    const auto ideal = [&](std::size_t n) -> const Wrench & {
        return path.reference[n % path.reference.size()];
    };
    double cross = 0, own = 0, whole = 0, whole_force = 0, peak = 0;
    for (std::size_t n = 0; n < wrenches.size(); ++n) {
        const Wrench &w = wrenches[n], &i = ideal(n);
        cross += dot(w.force, i.force) + dot(w.torque, i.torque) / (r * r);
        own += dot(w.force, w.force) + dot(w.torque, w.torque) / (r * r);
        whole_force += dot(i.force, i.force);
        whole += dot(i.force, i.force) + dot(i.torque, i.torque) / (r * r);
        peak = std::max(peak, length(i.force));
    }
    const double factor = own > 0 ? std::max(0.0, cross / own) : 0;
    double force = 0, torque = 0, size = 0, felt = 0, missing = 0;
    std::vector<double> angles;
    for (std::size_t n = 0; n < wrenches.size(); ++n) {
        const Wrench &w = wrenches[n], &i = ideal(n);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double f = factor * w.force[axis] - i.force[axis],
                         t = factor * w.torque[axis] - i.torque[axis];
            force += f * f;
            torque += t * t / (r * r);
        }
        const double f = length(w.force), g = length(i.force);
        size += (factor * f - g) * (factor * f - g);
        if (g < felt_share * peak) continue;
        ++felt;
        if (!(f > 0))
            ++missing;
        else
            angles.push_back(std::acos(std::clamp(dot(w.force, i.force) / (f * g), -1.0, 1.0)) * 180 / pi);
    }
    row.error = std::sqrt((force + torque) / whole);
    row.force = std::sqrt(force / whole_force);
    row.torque = std::sqrt(torque / whole_force);
    row.size = std::sqrt(size / whole_force);
    row.missing = felt > 0 ? missing / felt : nothing;
    row.stiffness = factor > 0 ? 1 / factor : nothing;
    row.angle_mean = row.angle_p95 = nothing;
    if (angles.empty()) return;
    std::sort(angles.begin(), angles.end());
    row.angle_mean = 0;
    for (const double a : angles) row.angle_mean += a / static_cast<double>(angles.size());
    row.angle_p95 = angles[static_cast<std::size_t>(0.95 * static_cast<double>(angles.size() - 1) + 0.5)];
}

double reach_of(std::uint32_t field, double voxel, double deepest)
{
    if (field == VXS_CONTACT_SURFACE) return 0;
    const double most = field == VXS_CONTACT_LAYERS ? most_layers : most_distance_cells;
    return std::clamp(std::ceil(deepest / voxel) + 1, least_reach, most);
}

std::vector<double> accuracy_voxels(const AccuracyScene &scene, const AccuracyPath &path,
                                    const AccuracyOptions &options)
{
    if (!options.voxels.empty()) return options.voxels;
    std::vector<double> voxels;
    const double stands = area_of(scene.statics), moves = area_of(scene.dynamic);
    for (const double part : options.quick ? std::vector<double>{1, 2} : std::vector<double>{0.5, 1, 2, 4}) {
        const double voxel = scene.voxel / part;
        const double band =
            1.5 * stands / (voxel * voxel) * 2 * reach_of(VXS_CONTACT_DISTANCE, voxel, path.deepest);
        const double points = 1.5 * moves / (voxel * voxel);
        if (voxel < scene.voxel && (band > (options.quick ? quick_cells : most_cells) ||
                                    points > (options.quick ? quick_points : most_points)))
            continue;
        voxels.push_back(voxel);
    }
    return voxels;
}

std::vector<Method> valid_methods()
{
    std::vector<Method> methods;
    for (const ShellKind shell : {ShellKind::naive, ShellKind::exact}) {
        for (const std::uint32_t law :
             {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE, VXS_CONTACT_PATCH, VXS_CONTACT_GRADIENT}) {
            for (const std::uint32_t field :
                 {VXS_CONTACT_SURFACE, VXS_CONTACT_LAYERS, VXS_CONTACT_DISTANCE}) {
                for (const std::uint32_t weighting :
                     {VXS_CONTACT_COUNT, VXS_CONTACT_COUNT_CAPPED, VXS_CONTACT_AREA}) {
                    const Method method{shell, law, field, weighting};
                    const vxs_contact_config config = contact_of(method, 1e-3);
                    if (vxs_contact_config_check(&config) == VXS_OK) methods.push_back(method);
                }
            }
        }
    }
    return methods;
}

std::vector<AccuracyRow> run_accuracy(const AccuracyScene &scene, const AccuracyPath &path,
                                      const AccuracyOptions &options, FinishedWork &work, Progress &progress)
{
    const unsigned turns = options.turns ? options.turns : options.quick ? quick_turns : full_turns;
    std::vector<AccuracyRow> rows;
    for (const double voxel : accuracy_voxels(scene, path, options)) {
        Assets assets(scene, voxel, path.deepest, progress);
        for (const Method &method : valid_methods()) {
            const AccuracyConfig config{voxel, method};
            const std::string name = "run " + config.text();
            const std::vector<double> *done = work.find(name);
            if (!done)
                done = &work.add(name, numbers_of(run_config(scene, path, config, turns, assets, progress)));
            rows.push_back(read_numbers(config, *done));
            progress.advance(1);
        }
    }
    return rows;
}

} // namespace voxshell
