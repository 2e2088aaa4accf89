// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/orient.hpp"

#include "mesh/edges.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace voxshell {
namespace {

// Triangles connected by manifold edges: they turn together.
struct Patch {
    std::vector<std::uint32_t> triangles;
    bool turn = false;
};

struct Neighbor {
    std::uint32_t triangle = none;
    bool turned = false; // runs along the shared edge in the same direction: one of the two is wrong
    static constexpr std::uint32_t none = ~std::uint32_t{0};
};

void turn(Triangle &t) { std::swap(t[1], t[2]); }

double twice_area(const Mesh &mesh, std::uint32_t t, Point &normal, double &longest)
{
    const auto &[a, b, c] = mesh.triangles[t];
    Point u{}, v{}, w{};
    for (int i = 0; i < 3; ++i) {
        u[i] = mesh.vertices[b][i] - mesh.vertices[a][i];
        v[i] = mesh.vertices[c][i] - mesh.vertices[a][i];
        w[i] = v[i] - u[i];
    }
    longest = std::max({std::hypot(u[0], u[1], u[2]), std::hypot(v[0], v[1], v[2]), std::hypot(w[0], w[1], w[2])});
    normal = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double length = std::hypot(normal[0], normal[1], normal[2]);
    if (length > 0)
        for (double &x : normal) x /= length;
    return length;
}

// Breadth-first across manifold edges; makes each patch consistent the way most of its area is wound.
// `turned` collects what was turned against the input.
std::vector<Patch> make_consistent(Mesh &mesh, std::vector<std::uint8_t> &turned)
{
    const Edges e = edges(mesh);
    std::vector<std::array<Neighbor, 3>> neighbors(mesh.triangles.size());
    for_each_edge(e.uses, [&](const EdgeUse *first, const EdgeUse *last) {
        if (last - first != 2 || first[0].triangle == first[1].triangle) return;
        const bool same = first[0].forward == first[1].forward;
        for (int s = 0; s < 2; ++s)
            for (Neighbor &n : neighbors[first[s].triangle])
                if (n.triangle == Neighbor::none) {
                    n = {first[1 - s].triangle, same};
                    break;
                }
    });
    std::vector<Patch> patches;
    std::vector<std::uint8_t> seen(mesh.triangles.size(), 0);
    for (std::uint32_t seed = 0; seed < mesh.triangles.size(); ++seed) {
        if (seen[seed] || (e.facets[seed] != Facet::face && e.facets[seed] != Facet::plug)) continue;
        Patch &patch = patches.emplace_back();
        patch.triangles.push_back(seed);
        seen[seed] = 1;
        double kept = 0, against = 0;
        for (std::size_t head = 0; head < patch.triangles.size(); ++head) {
            const std::uint32_t t = patch.triangles[head];
            Point normal;
            double longest;
            (turned[t] ? against : kept) += twice_area(mesh, t, normal, longest);
            for (const Neighbor &n : neighbors[t]) {
                if (n.triangle == Neighbor::none || seen[n.triangle]) continue;
                seen[n.triangle] = 1;
                turned[n.triangle] = turned[t] ^ static_cast<std::uint8_t>(n.turned);
                patch.triangles.push_back(n.triangle);
            }
        }
        for (const std::uint32_t t : patch.triangles) {
            turned[t] ^= static_cast<std::uint8_t>(against > kept);
            if (turned[t]) turn(mesh.triangles[t]);
        }
        std::sort(patch.triangles.begin(), patch.triangles.end());
    }
    return patches;
}

// |w| behind minus |w| in front of the patch's largest faces, weighted by area: 1 where the normals
// leave a solid, -1 where they enter it, near 0 for a sheet.
double outwardness(const Mesh &mesh, const WindingNumber &winding, const Patch &patch, std::size_t samples)
{
    std::vector<std::pair<double, std::uint32_t>> largest;
    Point n;
    double longest;
    for (const std::uint32_t t : patch.triangles) largest.push_back({-twice_area(mesh, t, n, longest), t});
    samples = std::min(samples, largest.size());
    std::partial_sort(largest.begin(), largest.begin() + static_cast<std::ptrdiff_t>(samples), largest.end());
    double sum = 0, weight = 0;
    for (std::size_t s = 0; s < samples; ++s) {
        const std::uint32_t t = largest[s].second;
        const double area = twice_area(mesh, t, n, longest);
        if (!(area > 0)) break;
        Point front{}, back{};
        double coordinate = 0;
        for (const std::uint32_t v : mesh.triangles[t])
            for (const double x : mesh.vertices[v]) coordinate = std::max(coordinate, std::abs(x));
        // Near enough to stay within a wall that is thin against the face, far enough to be beside it in double.
        const double step =
            std::max(1e-4 * area / longest, 64 * std::numeric_limits<double>::epsilon() * coordinate);
        for (int i = 0; i < 3; ++i) {
            double c = 0;
            for (const std::uint32_t v : mesh.triangles[t]) c += mesh.vertices[v][i] / 3;
            front[i] = c + step * n[i];
            back[i] = c - step * n[i];
        }
        sum += area * (std::abs(winding.at(back)) - std::abs(winding.at(front)));
        weight += area;
    }
    return weight > 0 ? sum / weight : 0;
}

} // namespace

OrientReport orient(Mesh &mesh)
{
    std::vector<std::uint8_t> turned(mesh.triangles.size(), 0);
    std::vector<Patch> patches = make_consistent(mesh, turned);
    // A soup of a million patches must not cost a million times fifteen looks.
    const std::size_t samples = patches.size() <= 4096 ? 15 : 1;
    constexpr double clear = -0.5; // halfway between a sheet and a closed shell
    // A turned patch changes the winding number that its neighbours are judged by. Closed shells are settled
    // in one round; more rounds serve surfaces in pieces (cracks, non-manifold edges).
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
        const WindingNumber winding(mesh);
        std::vector<std::uint8_t> inward(patches.size(), 0);
        tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t p) {
            inward[p] = outwardness(mesh, winding, patches[p], samples) < clear;
        });
        bool changed = false;
        for (std::size_t p = 0; p < patches.size(); ++p) {
            if (!inward[p]) continue;
            changed = true;
            patches[p].turn = !patches[p].turn;
            for (const std::uint32_t t : patches[p].triangles) {
                turn(mesh.triangles[t]);
                turned[t] ^= 1;
            }
        }
        if (!changed) break;
    }
    OrientReport out;
    for (const std::uint8_t t : turned) out.flipped += t;
    for (const Patch &patch : patches) out.shells_flipped += patch.turn;
    return out;
}

} // namespace voxshell
