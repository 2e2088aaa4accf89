// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/report.hpp"

#include "mesh/edges.hpp"
#include "mesh/sum.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace voxshell {
namespace {

std::uint64_t count_duplicates(const Edges &e)
{
    std::vector<Triangle> sorted;
    sorted.reserve(e.triangles.size());
    for (std::size_t t = 0; t < e.triangles.size(); ++t) {
        if (e.facets[t] == Facet::collapsed) continue;
        sorted.push_back(e.triangles[t]);
        std::sort(sorted.back().begin(), sorted.back().end());
    }
    std::sort(sorted.begin(), sorted.end());
    std::uint64_t count = 0;
    for (std::size_t i = 1; i < sorted.size(); ++i) count += sorted[i] == sorted[i - 1];
    return count;
}

class Components {
  public:
    explicit Components(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0u); }
    std::uint32_t root(std::uint32_t i)
    {
        while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
        return i;
    }
    void join(std::uint32_t i, std::uint32_t j)
    {
        i = root(i), j = root(j);
        parent_[std::max(i, j)] = std::min(i, j);
    }

  private:
    std::vector<std::uint32_t> parent_;
};

} // namespace

MeshReport report(const Mesh &mesh)
{
    const Edges e = edges(mesh);
    MeshReport out;
    out.triangles = mesh.triangles.size();
    out.degenerate = static_cast<std::uint64_t>(
        std::count_if(e.facets.begin(), e.facets.end(), [](Facet f) { return f != Facet::face; }));
    out.duplicate = count_duplicates(e);

    Components shells(mesh.triangles.size());
    out.closed = out.oriented = !e.uses.empty();
    for_each_edge(e.uses, [&](const EdgeUse *first, const EdgeUse *last) {
        const auto used = last - first;
        std::ptrdiff_t forward = 0;
        for (const EdgeUse *use = first; use != last; ++use) {
            forward += use->forward;
            shells.join(first->triangle, use->triangle);
        }
        out.boundary_edges += used == 1;
        out.non_manifold_edges += used >= 3;
        out.badly_wound_edges += used == 2 && forward != 1;
        out.closed = out.closed && used % 2 == 0;
        out.oriented = out.oriented && forward * 2 == used;
    });

    Point middle{}; // of the box: a far-off part must not lose its volume in the rounding
    if (!mesh.vertices.empty()) {
        Point low = mesh.vertices[0], high = low;
        for (const Point &p : mesh.vertices)
            for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
        for (int i = 0; i < 3; ++i) middle[i] = low[i] / 2 + high[i] / 2;
    }
    Sum area, volume;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        if (e.facets[t] == Facet::face || e.facets[t] == Facet::plug) out.shells += shells.root(t) == t;
        if (e.facets[t] != Facet::face) continue;
        std::array<Point, 3> p;
        for (int v = 0; v < 3; ++v)
            for (int i = 0; i < 3; ++i) p[v][i] = mesh.vertices[mesh.triangles[t][v]][i] - middle[i];
        const Point u{p[1][0] - p[0][0], p[1][1] - p[0][1], p[1][2] - p[0][2]};
        const Point w{p[2][0] - p[0][0], p[2][1] - p[0][1], p[2][2] - p[0][2]};
        const Point n{u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
        area.add(std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2);
        volume.add((p[0][0] * n[0] + p[0][1] * n[1] + p[0][2] * n[2]) / 6);
    }
    out.area = area.value();
    out.volume = out.closed ? volume.value() : 0;
    return out;
}

} // namespace voxshell
