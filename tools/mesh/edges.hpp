// SPDX-License-Identifier: GPL-3.0-or-later
// Which triangle uses which edge: the topology that report and orientation share.
#pragma once

#include "import/scene.hpp"

#include <cstdint>
#include <vector>

namespace voxshell {

enum class Facet : std::uint8_t {
    face,  ///< has area
    plug,  ///< no area, three vertices, and the surface would have a hole without it (a T-junction's sliver)
    stray, ///< no area, three vertices, closes nothing
    collapsed, ///< two of its vertices are one
};

struct EdgeUse {
    std::uint32_t a, b; ///< welded vertices, a < b
    std::uint32_t triangle;
    std::uint32_t forward; ///< 1: the triangle runs from a to b
    bool same_edge(const EdgeUse &other) const { return a == other.a && b == other.b; }
};

/// Triangle without area: its height is within 8 roundings of its largest coordinate. (Exactly collinear
/// vertices do not survive the scaling from millimetres to metres as exactly collinear.)
bool zero_area(const Point &a, const Point &b, const Point &c);

struct Edges {
    std::vector<Triangle> triangles; ///< of the mesh, in welded vertices
    std::vector<Facet> facets;       ///< per triangle
    std::vector<EdgeUse> uses;       ///< of faces and plugs, sorted by (a, b, triangle)
};

/// Welds and sorts. Triangles without area are left out of the edges, but for one case: where a row of
/// collinear slivers joins one long edge to several short ones, leaving them out would open a hole that is
/// not there. A sliver is a plug if at least two of its edges are used an odd number of times without it;
/// taking it in can make a plug of its neighbour, so this is repeated until nothing changes.
Edges edges(const Mesh &mesh);

/// Calls visit(first, last) for each edge with its uses.
template<class Visit>
void for_each_edge(const std::vector<EdgeUse> &uses, Visit visit)
{
    for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
        while (last < uses.size() && uses[last].same_edge(uses[first])) ++last;
        visit(uses.data() + first, uses.data() + last);
    }
}

} // namespace voxshell
