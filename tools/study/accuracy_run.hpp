// SPDX-License-Identifier: GPL-3.0-or-later
// The accuracy study at work: configurations of a scene through the shipped servo, each with its error and
// its time from the same ticks.
#pragma once

#include "study/accuracy_path.hpp"
#include "study/durations.hpp"
#include "study/open_part.hpp"

#include <array>
#include <memory>
#include <string>
#include <vector>

namespace voxshell {

struct AccuracyOptions {
    bool quick = false;
    std::vector<double> voxels; ///< [m], ascending; empty: by the scene's
    unsigned turns = 0;         ///< of the shell's grid; 0: as `quick` says
};

struct AccuracyConfig {
    double voxel;
    Method method;
    std::string text() const; ///< "2 mm, exact, average, surface, count"
    bool operator==(const AccuracyConfig &other) const;
};

/// What a configuration is worth. Shares are of the reference's force; one factor on all wrenches is free.
struct AccuracyRow {
    AccuracyConfig config;
    double error;               ///< force and torque / radius, rms
    double force, torque, size; ///< of it: the force, the torque / radius, |force| alone
    double angle_mean,
        angle_p95;    ///< between force and reference [degrees], where that is above 5 % of its peak
    double missing;   ///< share of those poses without any force
    double stiffness; ///< the factor: N/m^3 of the reference that the law's k of 1 stands for
    double points, hits, probed, probed_most; ///< of the shell; colliding and looked at in a tick
    double deep;                              ///< share of poses with points deeper than the field reaches
    double asset_bytes, runtime_bytes;        ///< map and shell; and all that the servo needs besides
    double reach;                             ///< of the field's channel [cells]
    Durations tick;                           ///< [ns] of vxs_servo_tick(), each the least of its passes
    double mean_ns, most_ns;                  ///< most: of any pass
    double conversion;                        ///< [s] both assets
    double conversion_bytes; ///< peak of memory on top of what was there; NaN: the system does not tell
};

/// A converted body and what that took.
struct MadePart {
    std::unique_ptr<OpenPart> part;
    double seconds = 0, bytes = 0; ///< bytes: as AccuracyRow::conversion_bytes
};
MadePart make_part(const std::string &name, const Mesh &mesh, const PartOptions &options, Progress &progress);

/// The servo along the poses: its contact alone (no coupling, no effect), from some ticks before each pose
/// on, so that it comes to it as in a loop. Wrenches are of the poses; a tick's time is its least of several
/// passes: what the work takes, and not what interrupts it. The first tick of a window is not counted.
struct Walk {
    std::vector<Wrench> wrenches;
    std::vector<std::uint32_t> flags;
    std::vector<float> ns;
    double most_ns = 0, hits = 0, probed = 0, probed_most = 0;
};
struct WalkOptions {
    unsigned window = 16, passes = 3;
};
double area_of(const Mesh &mesh); ///< [m^2]

/// turn: of the shell within the body (as_is: none).
using Turn = std::array<double, 4>; ///< w x y z, unit
inline constexpr Turn as_is{1, 0, 0, 0};
Walk walk(const AccuracyScene &scene, const AccuracyPath &path, const vxs_voxmap &map,
          const vxs_pointshell &shell, const Method &method, const Turn &turn, const WalkOptions &options);
Mesh turned_mesh(Mesh mesh, const Turn &turn);
Turn turn_of(unsigned seed); ///< 0: as it is
vxs_contact_config contact_of(const Method &method, double voxel);
vxs_pose turned_pose(const vxs_pose &pose, const Turn &turn);

/// Fills in errors and stiffness. Wrenches of all turns, one after the other.
void score(const std::vector<Wrench> &wrenches, const AccuracyPath &path, AccuracyRow &row);

/// Voxel edges of the study.
std::vector<double> accuracy_voxels(const AccuracyScene &scene, const AccuracyPath &path,
                                    const AccuracyOptions &options);
std::vector<Method> valid_methods(); ///< of one voxel, shells naive and exact
/// Reach of a channel that holds the path's depths [cells]; 0 for the field surface.
double reach_of(std::uint32_t field, double voxel, double deepest);

std::vector<AccuracyRow> run_accuracy(const AccuracyScene &scene, const AccuracyPath &path,
                                      const AccuracyOptions &options, FinishedWork &work, Progress &progress);

} // namespace voxshell
