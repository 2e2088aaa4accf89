// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

/// Every face three times, and a leaf of no thickness in the plane of the top.
Mesh other()
{
    Mesh mesh = block();
    const std::vector<voxshell::Triangle> once = mesh.triangles;
    for (int n = 0; n < 2; ++n) mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
    Mesh leaf;
    leaf.vertices = {{-3e-3, 0.5e-3, -3e-3}, {-3e-3, 0.5e-3, 7e-3}, {9e-3, 0.5e-3, 5e-3}};
    leaf.triangles = {{0, 1, 2}, {0, 2, 1}};
    return solids::join(mesh, leaf);
}

void run(const Pair &pair, const Options &, Measured &m)
{
    compare(asset("block", h, [] { return block(); }), asset("duplicate_faces", h, other),
            asset("ball", h, [] { return ball(); }), pair, m);
}

} // namespace

// The bound: the same surface gives the same files, and those the same bits.
extern const Case duplicate_faces{
    "duplicate_faces",
    "a floor with every face three times and a coplanar leaf on it: the same as without",
    "wrench off the clean part's",
    0,
    all,
    run};

} // namespace hard
