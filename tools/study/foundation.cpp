// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/foundation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voxshell {
namespace {

using Corners = std::array<Point, 3>;

constexpr double pi = std::numbers::pi;
constexpr std::size_t leaf_triangles = 4;

Point middle_of(const Corners &t)
{
    Point m{};
    for (const Point &p : t)
        for (std::size_t i = 0; i < 3; ++i) m[i] += p[i] / 3;
    return m;
}

Point between(const Point &a, const Point &b)
{
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2};
}

double reach(const Corners &t, const Point &from)
{
    return std::max({length(minus(t[0], from)), length(minus(t[1], from)), length(minus(t[2], from))});
}

void press(Wrench &sum, const Point &arm, const Point &direction, double share)
{
    const Point turn = cross(arm, direction);
    for (std::size_t i = 0; i < 3; ++i) {
        sum.force[i] += share * direction[i];
        sum.torque[i] += share * turn[i];
    }
}

/// One pose at work.
class Pressing {
  public:
    Pressing(const vxs_pose &pose, const Distance &distance, double spacing)
        : distance_(distance), spacing_(spacing)
    {
        if (!vxs_pose_rotation(&pose, turn_)) throw Failure(ExitCode::bug, "", "a bad pose");
        std::copy_n(pose.position, 3, at_.begin());
    }

    Nearest look(const Point &own, std::uint32_t near) const { return distance_.nearest(placed(own), near); }

    /// Asked where nobody knows.
    int side(const Point &own, int known) const { return known ? known : distance_.side(placed(own)); }

    /// known: on which side its middle is; 0: nobody knows. near: where to begin to look.
    void press_triangle(const Corners &t, int known, std::uint32_t near)
    {
        const Point middle = middle_of(t);
        const double far = reach(t, middle);
        const Nearest nearest = look(middle, near);
        if (nearest.distance > far) { // no surface in between: all of it is on one side
            known = side(middle, known ? known : nearest.side);
            if (known > 0) return;
        } else {
            known = 0;
        }
        const double edge =
            std::max({length(minus(t[1], t[0])), length(minus(t[2], t[1])), length(minus(t[0], t[2]))});
        if (edge > spacing_) {
            const Point a = between(t[0], t[1]), b = between(t[1], t[2]), c = between(t[2], t[0]);
            for (const Corners &quarter :
                 {Corners{t[0], a, c}, Corners{a, t[1], b}, Corners{c, b, t[2]}, Corners{a, b, c}})
                press_triangle(quarter, known, nearest.triangle);
            return;
        }
        ++sum.pieces;
        if (side(middle, known ? known : nearest.side) > 0) return;
        const Point out{-nearest.away[0], -nearest.away[1], -nearest.away[2]};
        const Point twice = cross(minus(t[1], t[0]), minus(t[2], t[0]));
        const double share = nearest.distance * length(twice) / 2;
        voxshell::press(sum.wrench, turned(middle), out, share);
        sum.gross += share;
        if (dot(turned(twice), out) > 0) sum.wrong += share;
        if (nearest.distance > sum.deepest) {
            sum.deepest = nearest.distance;
            sum.deepest_at = placed(middle);
            sum.deepest_out = out;
        }
    }

    Foundation sum;

  private:
    Point placed(const Point &own) const
    {
        const Point arm = turned(own);
        return {at_[0] + arm[0], at_[1] + arm[1], at_[2] + arm[2]};
    }
    Point turned(const Point &v) const
    {
        Point out;
        for (std::size_t i = 0; i < 3; ++i)
            out[i] = turn_[3 * i] * v[0] + turn_[3 * i + 1] * v[1] + turn_[3 * i + 2] * v[2];
        return out;
    }
    const Distance &distance_;
    double spacing_, turn_[9];
    Point at_{};
};

/// Gauss-Legendre on [-1, 1]: Newton from Chebyshev's nodes.
template<std::size_t count>
std::array<std::array<double, 2>, count> gauss()
{
    std::array<std::array<double, 2>, count> rule;
    for (std::size_t n = 0; n < count; ++n) {
        double x = std::cos(pi * (static_cast<double>(n) + 0.75) / (count + 0.5)), slope = 1;
        for (int step = 0; step < 60; ++step) {
            double p = 1, last = 0;
            for (std::size_t k = 0; k < count; ++k) {
                const auto d = static_cast<double>(k);
                const double next = ((2 * d + 1) * x * p - d * last) / (d + 1);
                last = p;
                p = next;
            }
            slope = static_cast<double>(count) * (x * p - last) / (x * x - 1);
            x -= p / slope;
        }
        rule[n] = {x, 2 / ((1 - x * x) * slope * slope)};
    }
    return rule;
}

} // namespace

Distance distance_of(const MeshDistance &mesh)
{
    return {[&mesh](const Point &p, std::uint32_t near) { return mesh.nearest(p, near); },
            [&mesh](const Point &p) { return mesh.side(p); }};
}

Distance distance_of(std::function<Nearest(const Point &)> formula)
{
    return {[formula](const Point &p, std::uint32_t) {
                Nearest n = formula(p);
                if (n.distance < 0) n = {-n.distance, {-n.away[0], -n.away[1], -n.away[2]}};
                return n;
            },
            [formula](const Point &p) { return formula(p).distance < 0 ? -1 : 1; }};
}

/// A ball around triangles first .. first + count, or, with children, around theirs.
struct FoundationSurface::Node {
    Point middle;
    double radius;
    std::size_t first, count;
    std::size_t second; ///< child; the first one follows this node. 0: none
};

FoundationSurface::~FoundationSurface() = default;

FoundationSurface::FoundationSurface(const Mesh &mesh)
{
    for (const Triangle &t : mesh.triangles)
        triangles_.push_back({mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]});
    if (triangles_.empty()) throw Failure(ExitCode::invalid, mesh.name, "has no triangle");
    const std::function<void(std::size_t, std::size_t)> split = [&](std::size_t first, std::size_t count) {
        Point low = triangles_[first][0], high = low;
        for (std::size_t n = first; n < first + count; ++n) {
            for (const Point &p : triangles_[n]) {
                for (std::size_t i = 0; i < 3; ++i) {
                    low[i] = std::min(low[i], p[i]);
                    high[i] = std::max(high[i], p[i]);
                }
            }
        }
        const std::size_t own = nodes_.size();
        nodes_.push_back({between(low, high), 0, first, count, 0});
        for (std::size_t n = first; n < first + count; ++n)
            nodes_[own].radius = std::max(nodes_[own].radius, reach(triangles_[n], nodes_[own].middle));
        if (own == 0) radius_ = length(minus(high, low)) / 2;
        if (count <= leaf_triangles) return;
        const Point size = minus(high, low);
        const auto axis = static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
        const auto begin = triangles_.begin() + static_cast<std::ptrdiff_t>(first);
        std::stable_sort(
            begin, begin + static_cast<std::ptrdiff_t>(count), [&](const Corners &a, const Corners &b) {
                return a[0][axis] + a[1][axis] + a[2][axis] < b[0][axis] + b[1][axis] + b[2][axis];
            });
        split(first, count / 2);
        nodes_[own].second = nodes_.size();
        split(first + count / 2, count - count / 2);
    };
    split(0, triangles_.size());
}

Foundation FoundationSurface::at(const vxs_pose &pose, const Distance &distance, double spacing) const
{
    Pressing pressing(pose, distance, spacing);
    struct Open {
        std::size_t node;
        int side;
        std::uint32_t near;
    };
    std::vector<Open> open{{0, 0, no_triangle}};
    while (!open.empty()) {
        const Open at = open.back();
        const Node &node = nodes_[at.node];
        open.pop_back();
        const Nearest there = pressing.look(node.middle, at.near);
        int side = 0;
        if (there.distance > node.radius) {
            side = pressing.side(node.middle, at.side ? at.side : there.side);
            if (side > 0) continue;
        }
        if (node.second) {
            open.push_back({node.second, side, there.triangle});
            open.push_back({at.node + 1, side, there.triangle});
        } else {
            for (std::size_t n = node.first; n < node.first + node.count; ++n)
                pressing.press_triangle(triangles_[n], side, there.triangle);
        }
    }
    return pressing.sum;
}

Wrench ball_foundation(double radius, const Point &middle, const Distance &distance)
{
    static const auto rule = gauss<24>();
    constexpr int around = 96;
    const auto signed_distance = [&](const Point &p) {
        return distance.side(p) * distance.nearest(p, no_triangle).distance;
    };
    Wrench sum;
    if (signed_distance(middle) >= radius) return sum;
    const Point out = distance.nearest(middle, no_triangle).away, in{-out[0], -out[1], -out[2]};
    Point across = std::abs(in[0]) < 0.6 ? Point{1, 0, 0} : Point{0, 1, 0};
    const double part = dot(across, in);
    for (std::size_t i = 0; i < 3; ++i) across[i] -= part * in[i];
    const double size = length(across);
    for (double &x : across) x /= size;
    const Point third = cross(in, across);
    for (int n = 0; n < around; ++n) {
        const double turn = 2 * pi * (n + 0.5) / around;
        const auto arm = [&](double polar) {
            Point a;
            for (std::size_t i = 0; i < 3; ++i)
                a[i] = radius * (std::cos(polar) * in[i] +
                                 std::sin(polar) * (std::cos(turn) * across[i] + std::sin(turn) * third[i]));
            return a;
        };
        const auto place = [&](double polar) {
            const Point a = arm(polar);
            return Point{middle[0] + a[0], middle[1] + a[1], middle[2] + a[2]};
        };
        double in_contact = 0, outside = pi / 2;
        for (int step = 0; step < 100; ++step) {
            const double polar = (in_contact + outside) / 2;
            (signed_distance(place(polar)) < 0 ? in_contact : outside) = polar;
        }
        for (const auto &[x, weight] : rule) {
            const double polar = in_contact * (x + 1) / 2;
            const Nearest there = distance.nearest(place(polar), no_triangle);
            const double area = radius * radius * std::sin(polar) * weight * in_contact / 2 * 2 * pi / around;
            voxshell::press(sum, arm(polar), {-there.away[0], -there.away[1], -there.away[2]},
                            there.distance * area);
        }
    }
    return sum;
}

double ball_on_plane(double radius, double depth)
{
    return depth > 0 ? pi * radius * depth * depth : 0;
}

double ball_in_bowl(double radius, double bowl, double depth)
{
    if (!(depth > 0)) return 0;
    // rho: distance of a point of the ball from the bowl's middle, c: of the ball's.
    const double c = bowl - radius + depth, k = c * c - radius * radius;
    const auto sum = [&](double rho) {
        const double r2 = rho * rho;
        return r2 * r2 / 4 - bowl * r2 * rho / 3 + k * (r2 / 2 - bowl * rho);
    };
    return pi * radius / (c * c) * (sum(c + radius) - sum(bowl));
}

} // namespace voxshell
