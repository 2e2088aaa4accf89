// SPDX-License-Identifier: GPL-3.0-or-later
// What single points do in a contact: figures 2 and 5. The runtime tells the sum; each point's share follows
// from the definition, and their sum is compared with the runtime's.
#pragma once

#include "cli/progress.hpp"
#include "pointshell/shell.hpp"
#include "study/study_report.hpp"

#include <vector>

namespace voxshell {

/// In the slice 0 <= y < e that is drawn; lengths in e, forces in k e. x to the right, z upwards.
struct DrawnPoint {
    double x, z;
    double force_x, force_z; ///< 0: it does not push
    bool collides;           ///< in a surface cell
};

struct SliceRun {
    ShellKind shell;
    std::vector<DrawnPoint> points;
    std::vector<std::array<double, 2>> raster; ///< middles of the ball's own surface cells
    double pushing;                            ///< of all points, not of the slice alone
    double size, across;                       ///< of the runtime's force [k e]
    double off;                                ///< sum of the single forces off the runtime's, of its size
};

/// One point on its way over the plane, by both laws.
struct CrossingRun {
    std::vector<DrawnPoint> original, average; ///< one an eighth of e
};

struct PointRuns {
    std::vector<SliceRun> slices; ///< naive, exact
    CrossingRun crossing;
};

inline constexpr double drawn_radius_e = 6, drawn_depth_e = 0.9, drawn_top_e = 0.95;
inline constexpr double drawn_turn = 0.35; ///< of the ball and its raster about y [rad]

PointRuns run_points(Progress &progress);
std::vector<StudyFigure> point_figures(const PointRuns &runs);
StudyTable point_table(const PointRuns &runs);

} // namespace voxshell
