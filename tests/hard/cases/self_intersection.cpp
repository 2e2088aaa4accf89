// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

/// Two blocks through each other: the faces between them lie inside.
Mesh other()
{
    return solids::join(solids::box({-20e-3, -7.5e-3, -20e-3}, {3.2e-3, 0.5e-3, 20e-3}),
                        solids::box({1.1e-3, -7.5e-3, -20e-3}, {20e-3, 0.5e-3, 20e-3}));
}

void run(const Pair &pair, const Options &, Measured &m)
{
    compare(asset("block", h, [] { return block(); }), asset("self_intersection", h, other),
            asset("ball", h, [] { return ball(); }), pair, m);
}

} // namespace

// The bound: away from the seam the same cells are surface, and the same bits follow. Channels see the faces
// inside (no claim).
extern const Case self_intersection{
    "self_intersection",
    "a floor of two blocks through each other, felt across the seam: the same as of one",
    "wrench off the clean part's",
    0,
    reads_surface,
    run};

} // namespace hard
