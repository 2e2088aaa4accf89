// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mend.hpp"

#include "mesh/edges.hpp"
#include "mesh/weld.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace voxshell {
namespace {

constexpr std::uint32_t none = ~std::uint32_t{0};

double distance(const Point &a, const Point &b)
{
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return std::sqrt(x * x + y * y + z * z);
}

std::uint64_t open_edges(const Edges &e)
{
    std::uint64_t count = 0;
    for_each_edge(e.uses, [&](const EdgeUse *first, const EdgeUse *last) { count += (last - first) & 1; });
    return count;
}

// Border vertices that stay, by cubes of the tolerance's size.
class Anchors {
  public:
    explicit Anchors(double size) : size_(size) {}

    void add(std::uint32_t anchor, const Point &at) { cubes_[cube(at)].push_back(anchor); }

    template<class Visit>
    void near(const Point &at, Visit visit) const
    {
        const Key middle = cube(at);
        for (int n = 0; n < 27; ++n) {
            const Key key{middle[0] + n % 3 - 1, middle[1] + n / 3 % 3 - 1, middle[2] + n / 9 - 1};
            const auto found = cubes_.find(key);
            if (found == cubes_.end()) continue;
            for (const std::uint32_t anchor : found->second) visit(anchor);
        }
    }

  private:
    using Key = std::array<double, 3>;
    Key cube(const Point &at) const
    {
        return {std::floor(at[0] / size_), std::floor(at[1] / size_), std::floor(at[2] / size_)};
    }
    double size_;
    std::map<Key, std::vector<std::uint32_t>> cubes_;
};

} // namespace

StitchReport stitch(Mesh &mesh, double tolerance)
{
    const Weld joined = weld(mesh);
    const Edges e = edges(mesh);
    StitchReport out;
    std::uint64_t open = 0;
    std::vector<std::uint8_t> border(joined.count, 0);
    for_each_edge(e.uses, [&](const EdgeUse *first, const EdgeUse *last) {
        if ((last - first) & 1) border[first->a] = border[first->b] = 1, ++open;
    });
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ends; // of edges between border vertices, both ways
    for (std::size_t t = 0; t < e.triangles.size(); ++t)
        for (int v = 0; v < 3; ++v) {
            const std::uint32_t a = e.triangles[t][v], b = e.triangles[t][(v + 1) % 3];
            if (a == b || !border[a] || !border[b]) continue;
            ends.push_back({a, b});
            ends.push_back({b, a});
        }
    std::sort(ends.begin(), ends.end());
    std::vector<Point> place(joined.count);
    for (std::size_t v = mesh.vertices.size(); v-- > 0;) place[joined.of[v]] = mesh.vertices[v];

    std::vector<std::uint32_t> onto(joined.count, none);
    std::map<std::uint32_t, std::vector<std::uint32_t>> gathered; // what moved onto an anchor
    const auto share_edge = [&](std::uint32_t v, std::uint32_t anchor) {
        const auto edge = [&](std::uint32_t w) {
            return std::binary_search(ends.begin(), ends.end(), std::pair{v, w});
        };
        if (edge(anchor)) return true;
        const auto found = gathered.find(anchor);
        return found != gathered.end() && std::any_of(found->second.begin(), found->second.end(), edge);
    };
    Anchors anchors(tolerance);
    for (std::uint32_t v = 0; v < joined.count; ++v) {
        if (!border[v]) continue;
        std::uint32_t nearest = none;
        double least = tolerance;
        anchors.near(place[v], [&](std::uint32_t anchor) {
            const double d = distance(place[v], place[anchor]);
            if (d > least || (d == least && anchor > nearest) || share_edge(v, anchor)) return;
            nearest = anchor, least = d;
        });
        if (nearest == none) {
            anchors.add(v, place[v]);
            continue;
        }
        onto[v] = nearest;
        gathered[nearest].push_back(v);
        ++out.vertices;
        out.farthest = std::max(out.farthest, least);
    }
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
        if (onto[joined.of[v]] != none) mesh.vertices[v] = place[onto[joined.of[v]]];
    const std::uint64_t left = open_edges(edges(mesh));
    out.closed_edges = open > left ? open - left : 0;
    return out;
}

std::uint64_t open_edges(const std::vector<std::array<std::int64_t, 3>> &vertices,
                         const std::vector<Triangle> &triangles)
{
    Mesh mesh;
    mesh.triangles = triangles;
    mesh.vertices.reserve(vertices.size());
    for (const auto &v : vertices)
        mesh.vertices.push_back({static_cast<double>(v[0] - vertices[0][0]),
                                 static_cast<double>(v[1] - vertices[0][1]),
                                 static_cast<double>(v[2] - vertices[0][2])});
    return open_edges(edges(mesh));
}

} // namespace voxshell
