// SPDX-License-Identifier: GPL-3.0-or-later
#include "hard_case.hpp"
#include "hard_shapes.hpp"

#include <cmath>

namespace hard {
namespace {

Mesh other()
{
    return solids::turned_inside_out(block());
}

void run(const Pair &pair, const Options &, Measured &m)
{
    compare(asset("block", h, [] { return block(); }), asset("inverted_mesh", h, other),
            asset("ball", h, [] { return ball(); }), pair, m);
    compare_moving(asset("block", h, [] { return block(); }), asset("ball", h, [] { return ball(); }),
                   asset("inverted ball", h, [] { return solids::turned_inside_out(ball()); }), pair, m);
}

} // namespace

// The bound: the same surface gives the same files, and those the same bits.
extern const Case inverted_mesh{"inverted_mesh",
                                "a floor inside out, and a ball inside out: the same as the right way round",
                                "wrench off the clean part's",
                                0,
                                all,
                                run};

} // namespace hard
