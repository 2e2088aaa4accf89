// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/thickness.hpp"

#include "mesh/box_tree.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace voxshell {
namespace {

constexpr std::uint32_t sample_count = 4096;
constexpr std::uint32_t tests_per_ray = 20000; // a ray through a hundred walls needs some hundreds
constexpr double facets = 0.02;                // a polygon of 16 corners is 1.9 % thinner than its circle

struct Hit {
    double t;
    int leaves; // 1: the ray leaves through this face, -1: it enters
};

// Woop, Benthin, Wald 2013: sheared so that the ray is an axis, two triangles compute the same number for the
// edge that they share. A ray exactly through an edge meets both; the count of walls then does not come out,
// and the place is sorted out.
class Shot {
  public:
    explicit Shot(const Ray &ray) : ray_(ray)
    {
        for (int i = 1; i < 3; ++i)
            if (std::abs(ray.d[i]) > std::abs(ray.d[z_])) z_ = i;
        x_ = (z_ + 1) % 3, y_ = (z_ + 2) % 3;
        if (ray.d[z_] < 0) std::swap(x_, y_); // keeps the winding
        sx_ = ray.d[x_] / ray.d[z_], sy_ = ray.d[y_] / ray.d[z_], sz_ = 1 / ray.d[z_];
    }

    bool at(const Point &pa, const Point &pb, const Point &pc, Hit &hit) const
    {
        const Point a = minus(pa, ray_.p), b = minus(pb, ray_.p), c = minus(pc, ray_.p);
        const double ax = a[x_] - sx_ * a[z_], ay = a[y_] - sy_ * a[z_];
        const double bx = b[x_] - sx_ * b[z_], by = b[y_] - sy_ * b[z_];
        const double cx = c[x_] - sx_ * c[z_], cy = c[y_] - sy_ * c[z_];
        const double u = cx * by - cy * bx, v = ax * cy - ay * cx, w = bx * ay - by * ax;
        if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
        const double det = u + v + w;
        if (det == 0) return false;
        hit = {sz_ * (u * a[z_] + v * b[z_] + w * c[z_]) / det, det < 0 ? 1 : -1};
        return hit.t >= ray_.first;
    }

  private:
    const Ray &ray_;
    int x_ = 0, y_ = 0, z_ = 0;
    double sx_, sy_, sz_;
};

enum class Found : std::uint8_t { wall, buried, nothing };

struct Look {
    Found found = Found::nothing;
    double wall = 0;
};

// What lies behind the skin at `ray.p`, a place on triangle `own`; `touching`: what is nearer is at the same
// place. Beyond all of the part the depth is 0, so the sum of what the ray leaves and enters is the depth at
// its begin.
Look look(const BoxTree &tree, const Mesh &mesh, const Ray &ray, std::uint32_t own, double touching,
          std::vector<Hit> &hits)
{
    hits.clear();
    const Shot shot(ray);
    std::uint32_t tests = 0;
    tree.visit(ray, [&](std::uint32_t t) {
        Hit hit;
        const auto &[a, b, c] = mesh.triangles[t];
        if (t != own && shot.at(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], hit))
            hits.push_back(hit);
        return ++tests <= tests_per_ray;
    });
    if (tests > tests_per_ray) return {};
    std::sort(hits.begin(), hits.end(),
              [](const Hit &a, const Hit &b) { return a.t != b.t ? a.t < b.t : a.leaves < b.leaves; });
    int depth = 0, before = -1; // just within the skin; what the skin itself and faces upon it change
    for (const Hit &hit : hits) (hit.t <= touching ? before : depth) += hit.leaves;
    if (depth + before > 0) return {Found::buried, 0};
    if (depth < 1) return {};
    for (std::size_t h = 0; h < hits.size(); ++h) {
        if (hits[h].t <= touching) continue;
        depth -= hits[h].leaves;
        const bool goes_on =
            h + 1 < hits.size() && hits[h + 1].leaves < 0 && hits[h + 1].t - hits[h].t <= touching;
        if (depth < 1 && !goes_on) return {Found::wall, hits[h].t};
    }
    return {};
}

} // namespace

Thickness thickness(const Mesh &mesh, Progress &progress)
{
    Thickness out;
    std::vector<double> until(mesh.triangles.size()); // area up to and with each triangle
    std::vector<Point> normals(mesh.triangles.size());
    double area = 0, largest = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
        const auto &[a, b, c] = mesh.triangles[t];
        normals[t] =
            cross(minus(mesh.vertices[b], mesh.vertices[a]), minus(mesh.vertices[c], mesh.vertices[a]));
        until[t] = area += length(normals[t]);
        for (const std::uint32_t v : mesh.triangles[t])
            for (const double x : mesh.vertices[v]) largest = std::max(largest, std::abs(x));
    }
    if (!(area > 0) || !std::isfinite(area)) return out;
    const double touching = 64 * std::numeric_limits<double>::epsilon() * largest;
    const BoxTree tree(mesh);
    progress.check();

    out.samples = sample_count;
    std::vector<Look> looks(sample_count);
    std::vector<Point> places(sample_count);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, sample_count, 32), [&](const auto &range) {
        progress.check();
        std::vector<Hit> hits;
        for (std::uint32_t s = range.begin(); s != range.end(); ++s) {
            const auto found = std::upper_bound(until.begin(), until.end(), area * (s + 0.5) / sample_count);
            const auto t = static_cast<std::uint32_t>(std::min(found, until.end() - 1) - until.begin());
            // Roberts' R2: as evenly in the plane as the golden ratio on the line.
            double u = std::fmod(0.5 + 0.7548776662466927 * s, 1.0),
                   v = std::fmod(0.5 + 0.5698402909980532 * s, 1.0);
            if (u + v > 1) u = 1 - u, v = 1 - v;
            const auto &[a, b, c] = mesh.triangles[t];
            const double size = length(normals[t]);
            if (!(size > 0)) continue;
            Point inward{};
            for (int i = 0; i < 3; ++i) {
                places[s][i] = mesh.vertices[a][i] + u * (mesh.vertices[b][i] - mesh.vertices[a][i]) +
                               v * (mesh.vertices[c][i] - mesh.vertices[a][i]);
                inward[i] = -normals[t][i] / size;
            }
            looks[s] = look(tree, mesh, {places[s], inward, -touching}, t, touching, hits);
        }
    });
    for (std::uint32_t s = 0; s < sample_count; ++s) {
        if (looks[s].found == Found::buried) ++out.buried;
        if (looks[s].found == Found::nothing) ++out.sorted_out;
        if (looks[s].found != Found::wall) continue;
        if (out.walls.empty() || looks[s].wall < out.thinnest) {
            out.thinnest = looks[s].wall;
            out.thinnest_at = places[s];
        }
        out.walls.push_back(looks[s].wall);
    }
    std::sort(out.walls.begin(), out.walls.end());
    return out;
}

double Thickness::quantile(double q) const
{
    const auto at = static_cast<std::size_t>(q * static_cast<double>(walls.size()));
    return walls[std::min(at, walls.size() - 1)];
}

double Thickness::share_below(double length) const
{
    const auto below = std::lower_bound(walls.begin(), walls.end(), length) - walls.begin();
    return walls.empty() ? 0 : static_cast<double>(below) / static_cast<double>(walls.size());
}

double voxel_for_wall(double wall)
{
    return round_down_125(wall / (3 * (1 - facets)));
}

double wall_of(double voxels, double voxel)
{
    return voxels * (1 - facets) * voxel;
}

namespace {

// step 10^decade with one rounding, as a length on the command line is read.
double step_125(int n)
{
    constexpr double steps[] = {1, 2, 5};
    const int decade = n >= 0 ? n / 3 : -((2 - n) / 3);
    const double step = steps[n - 3 * decade];
    double power = 1;
    for (int k = 0; k < std::abs(decade); ++k) power *= 10; // exact up to 10^22
    return decade < 0 ? step / power : step * power;
}

int index_below_125(double x)
{
    int n = 3 * static_cast<int>(std::floor(std::log10(x))) - 3;
    while (step_125(n + 1) <= x) ++n;
    return n;
}

} // namespace

double round_down_125(double x)
{
    return step_125(index_below_125(x));
}

double round_up_125(double x)
{
    const int n = index_below_125(x);
    return step_125(n) == x ? x : step_125(n + 1);
}

} // namespace voxshell
