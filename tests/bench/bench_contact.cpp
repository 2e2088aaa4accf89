// SPDX-License-Identifier: GPL-3.0-or-later
// Our contact on the moving sphere: bench_contact < JOBS (contact_rival.hpp).
#include "contact_ours.hpp"

using namespace voxshell::bench;

int main(int argc, char **argv)
{
    using MapKey = std::pair<bool, double>; // one static part is the cup, the other the ball of `all`
    Last<MapKey, OurMap> maps[2];           // without and with distance
    std::vector<RivalRow> table;
    for (const OurMode &mode : our_modes())
        table.push_back({mode.name, Kind::points, [&, mode](const Job &job, const Points &points) {
                             const auto map =
                                 maps[mode.distance].get({job.motion == Motion::all, job.voxel}, [&] {
                                     return make_our_map(static_mesh(job.motion), job.voxel, mode.distance);
                                 });
                             return make_our_rival(mode, map, points);
                         }});
    return run_rivals(argc, argv, table);
}
