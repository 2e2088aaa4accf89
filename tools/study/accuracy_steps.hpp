// SPDX-License-Identifier: GPL-3.0-or-later
// What single steps of the method cost and buy, beside those that are configurations: culling, rounding,
// the filter; and how time goes with points and with what stands.
#pragma once

#include "study/accuracy_run.hpp"

namespace voxshell {

/// Map (with both channels) and shells of the scene's own voxel edge, shells' grid as it is; each made when
/// it is first asked for.
class StepAssets {
  public:
    StepAssets(const AccuracyScene &scene, const AccuracyPath &path, Progress &progress)
        : scene_(scene), path_(path), progress_(progress)
    {
    }
    const vxs_voxmap &map();
    const vxs_pointshell &shell(ShellKind kind);

  private:
    const AccuracyScene &scene_;
    const AccuracyPath &path_;
    Progress &progress_;
    MadePart map_, shells_[2];
};

/// Which points are passed over without a look.
struct CullingRow {
    std::string config, mode; ///< "every point, plain C", "every point", "culled", "coherent"
    double poses, differing;  ///< wrenches with other bits than plain C's
    double probed;            ///< points looked at in a tick, mean
    Durations ns;             ///< of vxs_contact_evaluate(), least of three passes
};
std::vector<CullingRow> run_culling(const AccuracyScene &scene, const AccuracyPath &path, StepAssets &assets,
                                    FinishedWork &work, Progress &progress);

/// The runtime (points stored and probed in floats) against the same law in doubles throughout.
struct RoundingRow {
    std::string config;
    std::string
        poses;     ///< "as they are", "moved": by a part of a cell along each axis, off planes between cells
    double wrench; ///< rms of the difference, a share
    double worst;  ///< largest, of the rms
    double other_cells; ///< points in another cell, of all that collide
    double moved;       ///< largest way from a stored point to its double [m]
    double in_planes;   ///< points that rounding can put into another cell: so near to a plane between cells
    double cancelled;   ///< sum of all points' |force| over |their sum|
};
std::vector<RoundingRow> run_rounding(const AccuracyScene &scene, const AccuracyPath &path,
                                      StepAssets &assets, FinishedWork &work, Progress &progress);

/// The pt2 filter on the force along the path's longest part in contact, there and back at the hand's own
/// speed. None where no part has two poses.
struct FilterRow {
    AccuracyConfig config;
    double hertz;       ///< damping 1; 0: no filter
    double delay_ideal; ///< 2 d / w0 [s]
    double delay;       ///< of the filtered reference: the shift that fits best [s]
    double noise;       ///< rms of the filtered error without its mean, a share of the reference's rms
};
std::vector<FilterRow> run_filter(const AccuracyScene &scene, const AccuracyPath &path,
                                  const std::vector<AccuracyConfig> &configs, StepAssets &assets,
                                  FinishedWork &work, Progress &progress);
inline constexpr double filter_hertz[] = {5, 10, 20, 50, 100, 200};

/// The scene's own law with more points, or with more that stands.
struct ScaleRow {
    std::string kind;     ///< "points", "copies" (of what stands, out of reach), "finer" (its cells)
    double factor;        ///< copies, or times as many cells; points: asked for
    double points, cells; ///< of the shell; surface cells of what stands
    double map_bytes, shell_bytes, hits, probed, error;
    double differing;        ///< copies: poses with another wrench than with one copy
    double mean_ns, most_ns; ///< most: of any pass
    Durations ns;            ///< each tick the least of its passes
};
std::vector<ScaleRow> run_scale(const AccuracyScene &scene, const AccuracyPath &path, bool quick,
                                FinishedWork &work, Progress &progress);
std::size_t scale_rows(bool quick);

} // namespace voxshell
