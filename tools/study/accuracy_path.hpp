// SPDX-License-Identifier: GPL-3.0-or-later
// Where the accuracy study looks: poses along the hand's path, and the force that ought to be there.
#pragma once

#include "cli/progress.hpp"
#include "study/accuracy_scene.hpp"
#include "study/finished_work.hpp"

namespace voxshell {

struct AccuracyPath {
    std::vector<double> times;     ///< [s] of the hand's path, ascending
    std::vector<double> ways;      ///< [m] from the path's begin
    std::vector<unsigned> parts;   ///< a number more where the path left the contact in between
    std::vector<Wrench> reference; ///< by the mesh's own distance
    std::vector<Wrench> formula;   ///< where the scene has one, else empty
    double radius = 0;             ///< what a torque is divided by to be a force [m]
    double spacing = 0;            ///< of the reference [m]
    double halving = 0; ///< what halving the spacing to this one changed, a share of the force (rms)
    double apart = 0;   ///< formula and mesh, so as well; NaN without a formula
    double pieces = 0;  ///< of the reference at a pose, mean
    double deepest = 0; ///< [m]
    double way = 0;     ///< length of the hand's path [m]
    double touching = 0, usable = 0; ///< shares of it
};

struct PathOptions {
    unsigned poses, least_poses;
    unsigned probes;    ///< where along the whole way it is looked at first
    double most_pieces; ///< of all poses together, about: fewer poses where it were more, least_poses though
    double coarser = 1; ///< pieces' edges before any halving, of what is said below
};

/// At most that many poses evenly spaced along the way of the hand (position, and turns times the moving
/// body's radius) wherever it touches and is not too deep. Too deep: the nearest way out from half a voxel
/// (of the scene) below the deepest point is another one, or more than a hundredth of the pressure pulls
/// (Foundation::wrong): a distance says no longer what is the way back. Spacing of the reference: 16 times as
/// many pieces as the scene's own shell has points, then halved until that changes less than 0.1 %, or four
/// times; fewer poses where it is dear. Throws Failure(invalid) if there is no such pose.
AccuracyPath accuracy_path(const AccuracyScene &scene, const PathOptions &options, FinishedWork &work,
                           Progress &progress);

vxs_pose hand_pose(const AccuracyScene &scene, double t);

/// rms of a - b over rms of b, with torque / radius.
double wrench_difference(const std::vector<Wrench> &a, const std::vector<Wrench> &b, double radius);

} // namespace voxshell
