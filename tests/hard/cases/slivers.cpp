// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

/// Each edge of each face with a triangle on it that is one float ulp high.
Mesh other()
{
    Mesh mesh = block(), out;
    out.vertices = mesh.vertices;
    for (const auto &[a, b, c] : mesh.triangles) {
        Point q;
        for (int i = 0; i < 3; ++i) {
            const float middle = static_cast<float>((mesh.vertices[a][i] + mesh.vertices[b][i]) / 2);
            q[i] = mesh.vertices[c][i] == mesh.vertices[a][i] && mesh.vertices[c][i] == mesh.vertices[b][i]
                       ? mesh.vertices[a][i] // stays in the plane
                       : std::nextafterf(middle, static_cast<float>(mesh.vertices[c][i]));
        }
        const std::uint32_t n = static_cast<std::uint32_t>(out.vertices.size());
        out.vertices.push_back(q);
        out.triangles.insert(out.triangles.end(), {{a, b, n}, {b, c, n}, {c, a, n}});
    }
    return out;
}

void run(const Pair &pair, const Options &, Measured &m)
{
    compare(asset("block", h, [] { return block(); }), asset("slivers", h, other),
            asset("ball", h, [] { return ball(); }), pair, m);
}

} // namespace

// The bound: an ulp is less than a unit of the lattice that vertices are snapped to, so that the files are
// the same, and their wrenches to the bit.
extern const Case slivers{
    "slivers",
    "a floor whose faces have slivers one float ulp high along their edges: the same as without",
    "wrench off the clean part's",
    0,
    all,
    run};

} // namespace hard
