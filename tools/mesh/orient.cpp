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
    bool open = false; // has an edge that an odd number of its triangles uses
    bool turn = false;
};

struct Neighbor {
    std::uint32_t triangle = none;
    bool turned = false; // runs along the shared edge in the same direction: one of the two is wrong
    static constexpr std::uint32_t none = ~std::uint32_t{0};
};

void turn(Triangle &t)
{
    std::swap(t[1], t[2]);
}

double length(double x, double y, double z)
{
    return std::sqrt(x * x + y * y + z * z);
}

double twice_area(const Mesh &mesh, std::uint32_t t, Point &normal, double &longest)
{
    const auto &[a, b, c] = mesh.triangles[t];
    Point u{}, v{}, w{};
    for (int i = 0; i < 3; ++i) {
        u[i] = mesh.vertices[b][i] - mesh.vertices[a][i];
        v[i] = mesh.vertices[c][i] - mesh.vertices[a][i];
        w[i] = v[i] - u[i];
    }
    longest = std::max({length(u[0], u[1], u[2]), length(v[0], v[1], v[2]), length(w[0], w[1], w[2])});
    normal = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const double twice = length(normal[0], normal[1], normal[2]);
    if (twice > 0)
        for (double &x : normal) x /= twice;
    return twice;
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
    std::vector<std::uint32_t> patch_of(mesh.triangles.size(), 0);
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
        for (const std::uint32_t t : patch.triangles)
            patch_of[t] = static_cast<std::uint32_t>(patches.size() - 1);
    }
    std::vector<std::uint32_t> users;
    for_each_edge(e.uses, [&](const EdgeUse *first, const EdgeUse *last) {
        users.clear();
        for (; first != last; ++first) users.push_back(patch_of[first->triangle]);
        std::sort(users.begin(), users.end());
        for (std::size_t i = 0; i < users.size();) {
            const std::size_t begin = i;
            while (i < users.size() && users[i] == users[begin]) ++i;
            if ((i - begin) & 1) patches[users[begin]].open = true;
        }
    });
    return patches;
}

// |w| behind minus |w| in front of the patch's largest faces, weighted by area: 1 where the normals leave a
// solid, -1 where they enter it, near 0 for a sheet. `rest` leaves the patch's own share out and looks
// farther off the face: of an open piece of a larger surface it is the others that know where the solid is,
// for the piece itself always makes |w| larger behind it.
double outwardness(const Mesh &mesh, const WindingNumber &winding, const Patch &patch, std::size_t samples,
                   bool rest)
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
        double coordinate = 0;
        for (const std::uint32_t v : mesh.triangles[t])
            for (const double x : mesh.vertices[v]) coordinate = std::max(coordinate, std::abs(x));
        // Near enough to stay within a wall that is thin against the face, far enough to be beside it in
        // double.
        const double step = std::max((rest ? 0.25 : 1e-4) * area / longest,
                                     64 * std::numeric_limits<double>::epsilon() * coordinate);
        const auto look = [&](double side) {
            Point at{};
            for (int i = 0; i < 3; ++i) {
                for (const std::uint32_t v : mesh.triangles[t]) at[i] += mesh.vertices[v][i] / 3;
                at[i] += side * n[i];
            }
            double w = winding.at(at);
            if (rest)
                for (const std::uint32_t own : patch.triangles) {
                    const auto &[a, b, c] = mesh.triangles[own];
                    w -= winding_of_triangle(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c], at);
                }
            return std::abs(w);
        };
        sum += area * (look(-step) - look(step));
        weight += area;
    }
    return weight > 0 ? sum / weight : 0;
}

bool inward(const Mesh &mesh, const WindingNumber &winding, const Patch &patch, std::size_t samples)
{
    if (patch.open) {
        constexpr double heard = 0.05; // above the winding number's error
        const double others = outwardness(mesh, winding, patch, samples, true);
        if (std::abs(others) > heard) return others < 0;
    }
    constexpr double clear = -0.5; // halfway between a sheet and a closed shell
    return outwardness(mesh, winding, patch, samples, false) < clear;
}

} // namespace

OrientReport orient(Mesh &mesh)
{
    std::vector<std::uint8_t> turned(mesh.triangles.size(), 0);
    std::vector<Patch> patches = make_consistent(mesh, turned);
    // A soup of a million patches must not cost a million times fifteen looks.
    const std::size_t samples = patches.size() <= 4096 ? 15 : 1;
    // A turned patch changes the winding number that its neighbours are judged by. Closed shells are settled
    // in one round; more rounds serve surfaces in pieces (cracks, non-manifold edges).
    constexpr int rounds = 4;
    for (int round = 0; round < rounds; ++round) {
        const WindingNumber winding(mesh);
        std::vector<std::uint8_t> wrong(patches.size(), 0);
        tbb::parallel_for(std::size_t{0}, patches.size(),
                          [&](std::size_t p) { wrong[p] = inward(mesh, winding, patches[p], samples); });
        bool changed = false;
        for (std::size_t p = 0; p < patches.size(); ++p) {
            if (!wrong[p]) continue;
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
