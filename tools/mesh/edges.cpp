// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/edges.hpp"

#include "mesh/weld.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace voxshell {
namespace {

using Key = std::pair<std::uint32_t, std::uint32_t>;

Key key(std::uint32_t v, std::uint32_t w)
{
    return {std::min(v, w), std::max(v, w)};
}

// Buckets by the lower vertex, then a short sort in each: linear for any mesh without a giant fan.
std::vector<EdgeUse> sorted_uses(const std::vector<Triangle> &triangles, const std::vector<Facet> &facets,
                                 std::uint32_t vertices)
{
    std::vector<std::size_t> start(std::size_t{vertices} + 1, 0);
    const auto each = [&](auto visit) {
        for (std::uint32_t t = 0; t < triangles.size(); ++t) {
            if (facets[t] != Facet::face && facets[t] != Facet::plug) continue;
            for (int e = 0; e < 3; ++e) {
                const std::uint32_t v = triangles[t][e], w = triangles[t][(e + 1) % 3];
                visit(EdgeUse{std::min(v, w), std::max(v, w), t, v < w});
            }
        }
    };
    each([&](const EdgeUse &use) { ++start[use.a + 1]; });
    for (std::size_t v = 0; v < vertices; ++v) start[v + 1] += start[v];
    std::vector<EdgeUse> uses(start[vertices]);
    std::vector<std::size_t> next(start.begin(), start.end() - 1);
    each([&](const EdgeUse &use) { uses[next[use.a]++] = use; });
    for (std::size_t v = 0; v < vertices; ++v)
        std::sort(uses.begin() + static_cast<std::ptrdiff_t>(start[v]),
                  uses.begin() + static_cast<std::ptrdiff_t>(start[v + 1]),
                  [](const EdgeUse &x, const EdgeUse &y) {
                      return x.b != y.b ? x.b < y.b : x.triangle < y.triangle;
                  });
    return uses;
}

// Turns strays that close a hole into plugs; returns whether there was one.
bool find_plugs(const std::vector<Triangle> &triangles, std::vector<Facet> &facets,
                const std::vector<EdgeUse> &uses)
{
    std::vector<std::pair<Key, std::uint32_t>> rim; // each edge of each sliver
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        if (facets[t] == Facet::stray)
            for (int e = 0; e < 3; ++e) rim.push_back({key(triangles[t][e], triangles[t][(e + 1) % 3]), t});
    std::sort(rim.begin(), rim.end());
    std::vector<Key> rim_edges;
    for (const auto &[edge, t] : rim)
        if (rim_edges.empty() || rim_edges.back() != edge) rim_edges.push_back(edge);
    const auto place = [&](const Key &edge) {
        return static_cast<std::size_t>(std::lower_bound(rim_edges.begin(), rim_edges.end(), edge) -
                                        rim_edges.begin());
    };
    std::vector<std::uint8_t> odd(rim_edges.size(), 0);
    for (std::size_t i = 0; i < rim_edges.size(); ++i) {
        const auto [first, last] = std::equal_range(
            uses.begin(), uses.end(), EdgeUse{rim_edges[i].first, rim_edges[i].second, 0, 0},
            [](const EdgeUse &x, const EdgeUse &y) { return x.a != y.a ? x.a < y.a : x.b < y.b; });
        odd[i] = (last - first) & 1;
    }
    std::vector<std::uint32_t> queue;
    for (std::uint32_t t = 0; t < triangles.size(); ++t)
        if (facets[t] == Facet::stray) queue.push_back(t);
    bool found = false;
    for (std::size_t head = 0; head < queue.size(); ++head) {
        const std::uint32_t t = queue[head];
        std::array<std::size_t, 3> at{};
        for (int e = 0; e < 3; ++e) at[e] = place(key(triangles[t][e], triangles[t][(e + 1) % 3]));
        // Each plug leaves fewer odd edges behind, so this ends.
        if (facets[t] != Facet::stray || odd[at[0]] + odd[at[1]] + odd[at[2]] < 2) continue;
        facets[t] = Facet::plug;
        found = true;
        for (const std::size_t e : at) {
            odd[e] ^= 1;
            if (!odd[e]) continue;
            const auto first =
                std::lower_bound(rim.begin(), rim.end(), std::pair{rim_edges[e], std::uint32_t{0}});
            for (auto it = first; it != rim.end() && it->first == rim_edges[e]; ++it)
                if (facets[it->second] == Facet::stray) queue.push_back(it->second);
        }
    }
    return found;
}

} // namespace

bool zero_area(const Point &a, const Point &b, const Point &c)
{
    double largest = 0;
    Point u{}, v{}, w{};
    for (int i = 0; i < 3; ++i) {
        largest = std::max({largest, std::abs(a[i]), std::abs(b[i]), std::abs(c[i])});
        u[i] = b[i] - a[i];
        v[i] = c[i] - a[i];
        w[i] = c[i] - b[i];
    }
    // Not hypot: its last bit differs from one C library to the next.
    const auto length = [](double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); };
    const double twice =
        length(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
    const double longest =
        std::max({length(u[0], u[1], u[2]), length(v[0], v[1], v[2]), length(w[0], w[1], w[2])});
    return !(twice > 8 * std::numeric_limits<double>::epsilon() * largest * longest);
}

Edges edges(const Mesh &mesh)
{
    const Weld joined = weld(mesh);
    Edges out;
    out.triangles.reserve(mesh.triangles.size());
    out.facets.reserve(mesh.triangles.size());
    bool slivers = false;
    for (const Triangle &t : mesh.triangles) {
        const Triangle v{joined.of[t[0]], joined.of[t[1]], joined.of[t[2]]};
        Facet facet = Facet::face;
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
            facet = Facet::collapsed;
        else if (zero_area(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]))
            facet = Facet::stray;
        slivers |= facet == Facet::stray;
        out.triangles.push_back(v);
        out.facets.push_back(facet);
    }
    out.uses = sorted_uses(out.triangles, out.facets, joined.count);
    if (slivers && find_plugs(out.triangles, out.facets, out.uses))
        out.uses = sorted_uses(out.triangles, out.facets, joined.count);
    return out;
}

} // namespace voxshell
