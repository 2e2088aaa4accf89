// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/contact_bench.hpp"

#include "cli/failure.hpp"
#include "plan/memory.hpp"
#include "scene/scene_file.hpp"

#include "voxshell/contact.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

namespace voxshell {
namespace {

constexpr int ticks_per_place = 50;
constexpr double step = 0.1; // [cells]

struct Motion {
    const char *name;
    double depth; // [cells]
    bool away;
} constexpr motions[] = {
    {"free", 0, true}, {"grazing", -0.5, false}, {"sliding", 0.5, false}, {"deep", 3, false}};

struct Mode {
    const char *name;
    std::uint32_t kernel, culling;
} constexpr modes[] = {{"scalar brute", VXS_CONTACT_SCALAR, VXS_CONTACT_BRUTE},
                       {"brute", VXS_CONTACT_FASTEST, VXS_CONTACT_BRUTE},
                       {"culled", VXS_CONTACT_FASTEST, VXS_CONTACT_CULLED},
                       {"coherent", VXS_CONTACT_FASTEST, VXS_CONTACT_COHERENT}};

Point scaled(const Point &a, double factor)
{
    return {a[0] * factor, a[1] * factor, a[2] * factor};
}

Point sum(const Point &a, const Point &b)
{
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

/// Some unit vector square to a unit vector.
Point across(const Point &n)
{
    const Point axis = std::abs(n[0]) < 0.6 ? Point{1, 0, 0} : Point{0, 1, 0};
    const Point v = cross(n, axis);
    return scaled(v, 1 / std::sqrt(dot(v, v)));
}

/// Columns are the images of the axes.
using Turn = std::array<Point, 3>;

Point turned(const Turn &r, const Point &v)
{
    return sum(sum(scaled(r[0], v[0]), scaled(r[1], v[1])), scaled(r[2], v[2]));
}

/// The rotation that takes the unit vector `from` to `to`, and what is square to it round by `spin`.
Turn turn(const Point &from, const Point &to, double spin)
{
    const Point a = across(from), b = cross(from, a), c = across(to), d = cross(to, c);
    const Point a_to = sum(scaled(c, std::cos(spin)), scaled(d, std::sin(spin))), b_to = cross(to, a_to);
    Turn r;
    for (int axis = 0; axis < 3; ++axis) {
        Point unit{};
        unit[axis] = 1;
        r[axis] =
            sum(sum(scaled(to, dot(from, unit)), scaled(a_to, dot(a, unit))), scaled(b_to, dot(b, unit)));
    }
    return r;
}

/// w, x, y, z of a rotation: from the largest of the four, so that none is divided by little.
void orientation(const Turn &r, double q[4])
{
    const double trace[4] = {r[0][0] + r[1][1] + r[2][2], r[0][0] - r[1][1] - r[2][2],
                             r[1][1] - r[0][0] - r[2][2], r[2][2] - r[0][0] - r[1][1]};
    const int largest = static_cast<int>(std::max_element(trace, trace + 4) - trace);
    const double s = 2 * std::sqrt(1 + trace[largest]);
    const double x = r[1][2] - r[2][1], y = r[2][0] - r[0][2], z = r[0][1] - r[1][0];
    const double xy = r[0][1] + r[1][0], xz = r[0][2] + r[2][0], yz = r[1][2] + r[2][1];
    const double rows[4][4] = {
        {s * s / 4, x, y, z}, {x, s * s / 4, xy, xz}, {y, xy, s * s / 4, yz}, {z, xz, yz, s * s / 4}};
    for (int n = 0; n < 4; ++n) q[n] = rows[largest][n] / s;
}

/// Surface cells of a map by chance.
class Places {
  public:
    explicit Places(const vxs_voxmap &map) : map_(map)
    {
        for (std::uint32_t i = 0; i < map.cells[0]; i += 8)
            for (std::uint32_t j = 0; j < map.cells[1]; j += 8)
                for (std::uint32_t k = 0; k < map.cells[2]; k += 8) {
                    if (map.root[vxs_voxmap_root_index(map.root_dims, i, j, k)] < VXS_VOXMAP_ENTRY_FIRST) {
                        k |= 56; // the loop's step takes it to the next chunk
                        continue;
                    }
                    if (vxs_voxmap_entry(&map, i, j, k) >= VXS_VOXMAP_ENTRY_FIRST)
                        corners_.push_back({i, j, k});
                }
    }

    /// A surface cell's centre [m], and the direction from interior to free around it.
    void pick(std::mt19937_64 &dice, Point &place, Point &outwards) const
    {
        for (;;) {
            const auto &corner = corners_[dice() % corners_.size()];
            const std::uint64_t cell = dice();
            const std::uint32_t c[3] = {corner[0] + static_cast<std::uint32_t>(cell & 7),
                                        corner[1] + static_cast<std::uint32_t>(cell >> 3 & 7),
                                        corner[2] + static_cast<std::uint32_t>(cell >> 6 & 7)};
            if (vxs_voxmap_state(&map_, c[0], c[1], c[2]) != VXS_CELL_SURFACE) continue;
            outwards = {};
            for (int n = 0; n < 343; ++n) {
                const int d[3] = {n / 49 - 3, n / 7 % 7 - 3, n % 7 - 3};
                const std::uint32_t state = vxs_voxmap_state(&map_, c[0] + static_cast<std::uint32_t>(d[0]),
                                                             c[1] + static_cast<std::uint32_t>(d[1]),
                                                             c[2] + static_cast<std::uint32_t>(d[2]));
                const double sign = state == VXS_CELL_FREE ? 1 : state == VXS_CELL_INTERIOR ? -1 : 0;
                for (int a = 0; a < 3; ++a) outwards[a] += sign * d[a];
            }
            const double length = std::sqrt(dot(outwards, outwards));
            outwards = length > 0 ? scaled(outwards, 1 / length) : Point{0, 1, 0};
            for (int a = 0; a < 3; ++a)
                place[a] = map_.voxel * (static_cast<double>(map_.origin_cell[a]) + c[a] + 0.5);
            return;
        }
    }

  private:
    const vxs_voxmap &map_;
    std::vector<std::array<std::uint32_t, 3>> corners_;
};

/// Nothing touches there, and the shell is near enough to the map to have to find that out.
bool is_free(vxs_contact *contact, const vxs_voxmap &map, const vxs_pose &pose)
{
    const vxs_contact_static statics{&map, nullptr};
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    vxs_contact_result result;
    return vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &result) == 0 && result.points == 0;
}

std::vector<vxs_pose> poses_of(const Motion &motion, const vxs_voxmap &map, const vxs_pointshell &shell,
                               const Places &places, vxs_contact *contact, std::uint64_t ticks)
{
    std::mt19937_64 dice(20261122);
    std::vector<vxs_pose> poses;
    int refused = 0; // a free place may be rare, or nowhere
    while (poses.size() < ticks) {
        Point place, outwards;
        places.pick(dice, place, outwards);
        const std::uint64_t p = dice() % shell.point_count;
        const Point own{shell.x[p], shell.y[p], shell.z[p]}, normal{shell.nx[p], shell.ny[p], shell.nz[p]};
        const Turn r =
            turn(normal, outwards, static_cast<double>(dice() >> 11) * 0x1p-53 * 2 * std::numbers::pi);
        const double off = motion.away ? 20 * map.voxel : -motion.depth * map.voxel;
        Point at = sum(sum(place, scaled(outwards, off)), scaled(turned(r, own), -1));
        const Point along = scaled(across(outwards), step * map.voxel);
        for (int n = 0; n < ticks_per_place && poses.size() < ticks; ++n, at = sum(at, along)) {
            vxs_pose pose;
            for (int a = 0; a < 3; ++a) pose.position[a] = at[a];
            orientation(r, pose.orientation);
            if (motion.away && n % 10 == 0 && !is_free(contact, map, pose) && refused++ < 10'000) break;
            poses.push_back(pose);
        }
    }
    return poses;
}

ContactBench run(const std::vector<vxs_pose> &poses, const vxs_voxmap &map, vxs_contact *contact,
                 const vxs_contact_config &config, Progress &progress)
{
    using Clock = std::chrono::steady_clock;
    const vxs_contact_static statics{&map, nullptr};
    ContactBench out;
    std::vector<float> ns;
    const auto begin = Clock::now();
    for (const vxs_pose &pose : poses) {
        vxs_contact_result result;
        const auto before = Clock::now();
        vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &result);
        const auto after = Clock::now();
        ns.push_back(std::chrono::duration<float, std::nano>(after - before).count());
        out.touched += result.probed;
        out.hits += result.points;
        ++out.ticks;
        if (out.ticks % 64 == 0) progress.check();
        if (out.ticks >= 100 && after - begin > std::chrono::seconds(2)) break;
    }
    out.touched /= static_cast<double>(out.ticks);
    out.hits /= static_cast<double>(out.ticks);
    out.ns = durations(ns);
    return out;
}

vxs_contact *make_contact(const Memory &memory, const vxs_pointshell &shell)
{
    vxs_contact *contact = nullptr;
    if (vxs_contact_init(memory.get(), memory.size(), &shell, 1, &contact) != VXS_OK)
        throw Failure(ExitCode::bug, "", "no contact for an open shell");
    return contact;
}

} // namespace

std::vector<ContactBench> bench_contact(const vxs_voxmap &map, const vxs_pointshell &shell,
                                        std::uint64_t ticks, Progress &progress)
{
    const Places places(map);
    const Memory memory(vxs_contact_memory(&shell, 1));
    const bool with_distance = vxs_contact_has_field(&map, VXS_CONTACT_DISTANCE);
    progress.stage("bench", std::size(motions) * std::size(modes) * (with_distance ? 2 : 1));
    std::vector<ContactBench> out;
    for (const Motion &motion : motions) {
        const std::vector<vxs_pose> poses =
            poses_of(motion, map, shell, places, make_contact(memory, shell), ticks);
        for (int field = 0; field <= (with_distance ? 1 : 0); ++field) {
            vxs_contact_config config;
            vxs_contact_config_default(&config);
            if (field) config.law = VXS_CONTACT_GRADIENT, config.field = VXS_CONTACT_DISTANCE;
            for (const Mode &mode : modes) {
                vxs_contact *contact = make_contact(memory, shell);
                vxs_contact_use(contact, mode.kernel);
                vxs_contact_cull(contact, mode.culling);
                ContactBench bench = run(poses, map, contact, config, progress);
                bench.motion = motion.name;
                bench.field = field ? "distance" : "states";
                bench.mode = mode.name;
                out.push_back(bench);
                progress.advance(1);
            }
        }
    }
    return out;
}

double contact_point_cost(const vxs_pointshell &shell)
{
    const Memory memory(vxs_contact_memory(&shell, 1));
    return vxs_contact_point_cost(make_contact(memory, shell));
}

std::string processor_name()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name") && line.find(": ") != std::string::npos)
            return line.substr(line.find(": ") + 2);
    return "unknown processor";
}

} // namespace voxshell
