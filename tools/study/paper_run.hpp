// SPDX-License-Identifier: GPL-3.0-or-later
// The scenarios run with the shipped runtime on assets that the real pipeline made, as many at once as there
// are threads; what comes out stands in the order of the table, whatever they are.
#pragma once

#include "cli/progress.hpp"
#include "study/durations.hpp"
#include "study/force_metrics.hpp"
#include "study/paper_points.hpp"
#include "study/paper_scenarios.hpp"

#include <string>
#include <vector>

namespace voxshell {

/// One scenario with one variant, level, speed and seed.
struct RunKey {
    const Scenario *scenario;
    std::size_t variant, level, speed;
    unsigned seed;
    const Variant &how() const { return scenario->variants[variant]; }
    double level_value() const { return scenario->levels[level]; }
    double speed_value() const { return scenario->speeds.empty() ? 0 : scenario->speeds[speed]; }
};

/// A pose is prescribed: force at each tick.
struct PathRun {
    RunKey key;
    ForceMetrics metrics;
    bool degenerate; ///< nothing to score: a pose on the path is_degenerate(), or the metrics are
    double crossing_hz;
    double radius;                ///< of what moves [m]
    double height_e;              ///< of a plane along the grid, within its cell
    std::vector<double> progress; ///< as Path::Step; with `samples`, kept where a figure draws them
    std::vector<ForceSample> samples;
};

/// Through a coupling: at a prescribed pose (figure 11), or with a device in the loop.
struct LoopRun {
    RunKey key;
    std::string coupling;     ///< "quasi-static 400 N/m (auto)"
    double contact_stiffness; ///< largest on the way if nothing held it, before a bound [N/m]
    double largest_stiffness; ///< that the loop carries with this coupling, held by a hand [N/m]; NaN: any
    double bound;             ///< of the contact as a whole [N/m]; NaN: none
    ResponseMetrics response; ///< of the force along the normal
    ForceMetrics felt;        ///< of the output, from half a second after contact on
    double collision_peak, output_peak; ///< [N]
    double deepest;                     ///< of the object, by geometry [m]
    bool through;                       ///< its deepest point came out on the other side of the wall
    double energy;                      ///< least taken from the hand [J]
    double saturated;                   ///< [s]
    double flagged_deep;                ///< share of the ticks in contact
    Durations tick;                     ///< of a device in the loop
    std::vector<double> time, collision,
        output; ///< [s], [N] along the normal (figure 11) or size (others); where a figure draws them
};

struct PaperRuns {
    std::vector<PathRun> paths;
    std::vector<LoopRun> loops;
    PointRuns points;
};

struct PaperOptions {
    unsigned seeds = 5;
    bool quick = false; ///< fewer depths where laws are only compared, fewer walls
};

PaperRuns run_paper(const PaperOptions &options, Progress &progress);

class OpenPart;

/// For run_paper(): one run with the scenario's bodies.
PathRun run_path(const RunKey &key, const OpenPart &stands, const OpenPart &moves);
LoopRun run_coupled(const RunKey &key, const OpenPart &stands, const OpenPart &moves);
LoopRun run_loop(const RunKey &key, const OpenPart &stands, const OpenPart &moves);

} // namespace voxshell
