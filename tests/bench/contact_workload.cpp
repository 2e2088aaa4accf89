// SPDX-License-Identifier: GPL-3.0-or-later
#include "contact_workload.hpp"

#include "cup.hpp"
#include "mesh/weld.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace voxshell::bench {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double outer = 0.040, inner = 0.037, height = 0.090, floor_height = 0.003;
constexpr int facets = 300; // of bench_cup()
constexpr double ball_radius = sphere_radius + 0.00001;

Pose pose_at(const Vec3 &position, double angle)
{
    constexpr double length = 3.7416573867739413; // of the axis 1 2 3, which lines up with nothing
    const double s = std::sin(angle / 2) / length, w = std::cos(angle / 2), x = s, y = 2 * s, z = 3 * s;
    Pose pose{position, {w, x, y, z}, {}};
    pose.rotation = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                     2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
    return pose;
}

/// Around the cup's axis at this distance from it; climbs a tenth of its way.
std::vector<Pose> helix(double radius, const Vec3 &place)
{
    std::vector<Pose> poses;
    for (int n = 0; n < pose_count; ++n) {
        const double turn = 0.3 + n * step * std::sqrt(0.99) / radius;
        poses.push_back(pose_at({place[0] + radius * std::cos(turn), place[1] + 0.040 + n * step * 0.1,
                                 place[2] + radius * std::sin(turn)},
                                n * step / sphere_radius));
    }
    return poses;
}

/// Signed distance from the cup's profile in the half plane (distance from the axis, height).
double profile_distance(double radius, double y)
{
    static constexpr std::array<std::array<double, 2>, 6> corner{
        {{0, 0}, {outer, 0}, {outer, height}, {inner, height}, {inner, floor_height}, {0, floor_height}}};
    double nearest = HUGE_VAL;
    for (std::size_t i = 0; i + 1 < corner.size(); ++i) {
        const double ex = corner[i + 1][0] - corner[i][0], ey = corner[i + 1][1] - corner[i][1];
        const double px = radius - corner[i][0], py = y - corner[i][1];
        const double t = std::clamp((px * ex + py * ey) / (ex * ex + ey * ey), 0.0, 1.0);
        nearest = std::min(nearest, std::hypot(px - t * ex, py - t * ey));
    }
    const bool inside = radius < outer && y > 0 && y < height && (radius > inner || y < floor_height);
    return inside ? -nearest : nearest;
}

/// Puts [first, last) into the order of clusters: see Points.
void halve(const std::vector<Vec3> &at, std::vector<std::uint32_t> &order, std::size_t first,
           std::size_t last)
{
    const std::size_t count = last - first;
    if (count <= 16) return;
    Vec3 low{HUGE_VAL, HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (std::size_t i = first; i < last; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], at[order[i]][axis]);
            high[axis] = std::max(high[axis], at[order[i]][axis]);
        }
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
        if (high[axis] - low[axis] > high[longest] - low[longest]) longest = axis;
    const std::size_t run = count > 64 ? 64 : 16, middle = first + (count + run - 1) / run / 2 * run;
    const auto begin = order.begin();
    std::nth_element(begin + static_cast<std::ptrdiff_t>(first), begin + static_cast<std::ptrdiff_t>(middle),
                     begin + static_cast<std::ptrdiff_t>(last), [&](std::uint32_t a, std::uint32_t b) {
                         return at[a][longest] != at[b][longest] ? at[a][longest] < at[b][longest] : a < b;
                     });
    halve(at, order, first, middle);
    halve(at, order, middle, last);
}

} // namespace

Motion motion_named(std::string_view name)
{
    const auto found = std::ranges::find(motion_names, name);
    if (found == motion_names.end())
        throw Failure(ExitCode::usage, std::string(name),
                      "no such motion: slide, outside, deep, grazing, free or all");
    return static_cast<Motion>(found - motion_names.begin());
}

std::vector<Pose> slide_at(double depth, const Vec3 &place)
{
    return helix(inner - sphere_radius + depth, place);
}

std::vector<Pose> poses_of(Motion motion)
{
    switch (motion) {
    case Motion::slide:
        return slide_at(0.00025);
    case Motion::outside:
        return helix(outer + sphere_radius - 0.00025, {0, 0, 0});
    case Motion::deep:
        return slide_at(0.0015);
    case Motion::grazing:
        return slide_at(0.00002);
    case Motion::free:
        return slide_at(-0.015);
    case Motion::all:
        break;
    }
    std::vector<Pose> poses;
    for (int n = 0; n < pose_count; ++n) poses.push_back(pose_at({0, 0, 0}, n * step / sphere_radius));
    return poses;
}

Mesh static_mesh(Motion motion)
{
    return motion == Motion::all ? sphere_mesh(100000, ball_radius) : bench_cup();
}

double static_distance(Motion motion, const Vec3 &p)
{
    if (motion == Motion::all) return std::hypot(p[0], p[1], p[2]) - ball_radius;
    // On a facet (through the points of radius r at its two ends) rho cos(turn) = r cos(pi / facets).
    const double rho = std::hypot(p[0], p[2]), facet = 2 * pi / facets;
    const double turn = std::remainder(std::atan2(p[2], p[0]) - facet / 2, facet);
    return profile_distance(rho * std::cos(turn) / std::cos(facet / 2), p[1]);
}

Points sphere_points(std::uint32_t count)
{
    std::vector<Vec3> unit(count);
    const double golden = pi * (3 - std::sqrt(5.0));
    for (std::uint32_t i = 0; i < count; ++i) {
        const double y = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - y * y);
        unit[i] = {r * std::cos(golden * i), y, r * std::sin(golden * i)};
    }
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    halve(unit, order, 0, count);
    while (order.size() % 16) order.push_back(order.back());
    Points points;
    points.count = count;
    for (const std::uint32_t i : order) {
        points.x.push_back(static_cast<float>(sphere_radius * unit[i][0]));
        points.y.push_back(static_cast<float>(sphere_radius * unit[i][1]));
        points.z.push_back(static_cast<float>(sphere_radius * unit[i][2]));
        points.nx.push_back(static_cast<float>(-unit[i][0]));
        points.ny.push_back(static_cast<float>(-unit[i][1]));
        points.nz.push_back(static_cast<float>(-unit[i][2]));
    }
    return points;
}

Mesh sphere_mesh(std::uint32_t triangles, double radius)
{
    // An icosahedron: (0, +-1, +-golden) and its turns; faces are the triples of corners two apart.
    const double golden = std::numbers::phi;
    std::vector<Vec3> corner;
    for (const double a : {-1.0, 1.0})
        for (const double b : {-golden, golden}) {
            corner.push_back({0, a, b});
            corner.push_back({a, b, 0});
            corner.push_back({b, 0, a});
        }
    const auto adjacent = [&](std::size_t a, std::size_t b) {
        return std::abs(std::hypot(corner[a][0] - corner[b][0], corner[a][1] - corner[b][1],
                                   corner[a][2] - corner[b][2]) -
                        2) < 0.1;
    };
    Mesh soup;
    soup.name = "sphere";
    const auto parts = static_cast<std::uint32_t>(std::lround(std::sqrt(triangles / 20.0)));
    const auto add_face = [&](std::array<std::size_t, 3> face) {
        const Vec3 &a = corner[face[0]], &b = corner[face[1]], &c = corner[face[2]];
        const double triple = a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                              a[2] * (b[0] * c[1] - b[1] * c[0]);
        if (triple < 0) std::swap(face[1], face[2]);
        // Shares are added in the order of the corners, so that both faces of an edge give its points the
        // same bits.
        const auto vertex = [&](std::uint32_t i, std::uint32_t j) {
            std::array<std::pair<std::size_t, std::uint32_t>, 3> share{
                {{face[0], parts - i - j}, {face[1], i}, {face[2], j}}};
            std::ranges::sort(share);
            Vec3 sum{};
            for (const auto &[which, weight] : share)
                for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += weight * corner[which][axis];
            const double scale = radius / std::hypot(sum[0], sum[1], sum[2]);
            soup.vertices.push_back({sum[0] * scale, sum[1] * scale, sum[2] * scale});
        };
        const auto add = [&](std::uint32_t i, std::uint32_t j, bool up) {
            const auto first = static_cast<std::uint32_t>(soup.vertices.size());
            vertex(i, j), vertex(i + 1, up ? j : j - 1), vertex(up ? i : i + 1, up ? j + 1 : j);
            soup.triangles.push_back({first, first + 1, first + 2});
        };
        for (std::uint32_t i = 0; i < parts; ++i)
            for (std::uint32_t j = 0; i + j < parts; ++j) {
                add(i, j, true);
                if (j > 0) add(i, j, false);
            }
    };
    for (std::size_t a = 0; a < corner.size(); ++a)
        for (std::size_t b = a + 1; b < corner.size(); ++b)
            for (std::size_t c = b + 1; c < corner.size(); ++c)
                if (adjacent(a, b) && adjacent(b, c) && adjacent(c, a)) add_face({a, b, c});

    const Weld joined = weld(soup);
    Mesh mesh;
    mesh.name = soup.name;
    mesh.vertices.resize(joined.count);
    for (std::size_t v = 0; v < soup.vertices.size(); ++v) mesh.vertices[joined.of[v]] = soup.vertices[v];
    for (const Triangle &t : soup.triangles)
        mesh.triangles.push_back({joined.of[t[0]], joined.of[t[1]], joined.of[t[2]]});
    return mesh;
}

Vec3 exact_force(Motion motion, const Points &points, const Pose &pose)
{
    constexpr double tiny = 1e-7;
    Vec3 force{};
    const auto &r = pose.rotation;
    for (std::uint32_t i = 0; i < points.count; ++i) {
        Vec3 p = pose.position;
        for (std::size_t axis = 0; axis < 3; ++axis)
            p[axis] +=
                r[3 * axis] * points.x[i] + r[3 * axis + 1] * points.y[i] + r[3 * axis + 2] * points.z[i];
        const double distance = static_distance(motion, p);
        if (distance >= 0) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            Vec3 before = p, after = p;
            before[axis] -= tiny;
            after[axis] += tiny;
            const double slope =
                (static_distance(motion, after) - static_distance(motion, before)) / (2 * tiny);
            force[axis] -= distance * slope;
        }
    }
    return force;
}

} // namespace voxshell::bench
