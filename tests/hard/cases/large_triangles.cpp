// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

Mesh other()
{
    return refined(block(), 5);
}

void run(const Pair &pair, const Options &, Measured &m)
{
    compare(asset("block", h, [] { return block(); }), asset("large_triangles", h, other),
            asset("ball", h, [] { return ball(); }), pair, m);
    const Asset &fine = asset("fine ball", h, [] { return refined(ball(), 1); });
    compare_moving(asset("block", h, [] { return block(); }), asset("ball", h, [] { return ball(); }), fine,
                   pair, m);
}

} // namespace

// The bound: vertices are snapped to the lattice, by at most 1/131072 h an axis, in either mesh; the mean
// depth where the wrench is largest is 0.2 h.
extern const Case large_triangles{
    "large_triangles",
    "faces of two triangles, larger than any brick of cells: the same as of two thousand, fixed and moving",
    "wrench off the clean part's",
    2 * std::sqrt(3.0) / 131072 / 0.2,
    all,
    run};

} // namespace hard
