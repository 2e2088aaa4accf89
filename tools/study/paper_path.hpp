// SPDX-License-Identifier: GPL-3.0-or-later
// A scenario's bodies, and the poses that it prescribes, tick by tick.
#pragma once

#include "study/force_metrics.hpp"
#include "study/paper_scenarios.hpp"

#include "voxshell/pose.h"

#include <cstddef>
#include <string>

namespace voxshell {

/// What a scenario needs of the pipeline. Bodies of the same name are the same.
struct Body {
    std::string name;
    Mesh mesh;
    double voxel;
    ShellKind shell; ///< of what moves
    bool stands;
};
Body standing_body(const Scenario &scenario, double level, unsigned seed);
Body moving_body(const Scenario &scenario, double level, ShellKind shell);

/// Motions circle, press, insert and coupled.
class Path {
  public:
    Path(const Scenario &scenario, double level, unsigned seed);

    struct Step {
        vxs_pose pose;
        Point axes[3];                   ///< of the contact's frame: normal, across, across
        Point ideal_force, ideal_torque; ///< scene frame, up to one factor
        double progress;                 ///< what a figure draws over: time [s], depth [e], way in [mm]
    };
    std::size_t ticks() const { return ticks_; }
    Step at(std::size_t tick) const;
    double radius() const { return radius_; }        ///< of what moves [m]
    double crossing_hz() const { return crossing_; } ///< speed / e; 0 where it has none
    bool is_periodic() const { return scenario_.motion == Motion::circle; }

  private:
    Step circle(double turn, double depth) const;
    Step press(double share) const;
    Step insert(double way) const;
    const Scenario &scenario_;
    double level_, radius_, height_;
    Draw draw_;
    std::size_t ticks_;
    double crossing_ = 0;
};

/// Shell, grid and surface lie along each other: the errors of all points repeat in step, or cancel, and say
/// nothing of another pose.
bool is_degenerate(const Path::Step &step);

/// v of the scene in the frame of a step.
Point along(const Path::Step &step, const double v[3]);

/// Height of the plane under figure 8's path [m].
double plane_height(const Scenario &scenario, unsigned seed);

} // namespace voxshell
