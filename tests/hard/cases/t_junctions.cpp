// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

/// Top faces cut, their neighbours not: vertices in the middle of edges.
Mesh other()
{
    Mesh mesh = block(), out;
    out.vertices = mesh.vertices;
    for (const auto &[a, b, c] : mesh.triangles) {
        if (mesh.vertices[a][1] < 0 || mesh.vertices[b][1] < 0 || mesh.vertices[c][1] < 0) {
            out.triangles.push_back({a, b, c});
            continue;
        }
        const std::uint32_t n = static_cast<std::uint32_t>(out.vertices.size());
        for (const double share : {0.3, 0.7}) {
            const Point &p = mesh.vertices[a], &q = mesh.vertices[b];
            out.vertices.push_back({p[0] + share * (q[0] - p[0]), p[1], p[2] + share * (q[2] - p[2])});
        }
        out.triangles.insert(out.triangles.end(), {{a, n, c}, {n, n + 1, c}, {n + 1, b, c}});
    }
    return out;
}

void run(const Pair &pair, const Options &, Measured &m)
{
    compare(asset("block", h, [] { return block(); }), asset("t_junctions", h, other),
            asset("ball", h, [] { return ball(); }), pair, m);
}

} // namespace

// The bound: the same surface gives the same files, and those the same bits.
extern const Case t_junctions{"t_junctions",
                              "a floor whose top is cut finer than what it borders on: the same as without",
                              "wrench off the clean part's",
                              0,
                              all,
                              run};

} // namespace hard
