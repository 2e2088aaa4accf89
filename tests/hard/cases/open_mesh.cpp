// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

/// The top alone: no inside.
Mesh other()
{
    Mesh mesh;
    for (const double x : {-20e-3, 20e-3})
        for (const double z : {-20e-3, 20e-3}) mesh.vertices.push_back({x, 0.5e-3, z});
    mesh.triangles = {{0, 1, 3}, {0, 3, 2}};
    return mesh;
}

void run(const Pair &pair, const Options &, Measured &m)
{
    compare(asset("block", h, [] { return block(); }), asset("open_mesh", h, other),
            asset("ball", h, [] { return ball(); }), pair, m);
}

} // namespace

// The bound: the same cells are surface, and the same bits follow.
extern const Case open_mesh{"open_mesh",
                            "a sheet without an inside: the same as the top of a block",
                            "wrench off the clean part's",
                            0,
                            reads_surface,
                            run};

} // namespace hard
