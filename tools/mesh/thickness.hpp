// SPDX-License-Identifier: GPL-3.0-or-later
// How thick the walls of a solid are: what the voxel must suit. (The paper: no part of what stands may be
// thinner than three voxels, or a point passes through it within one step.)
#pragma once

#include "cli/progress.hpp"
#include "import/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace voxshell {

/// Bounds of the classes that walls are told in, in voxels.
inline constexpr std::array<double, 5> thickness_classes{1, 2, 3, 5, 10};

struct Thickness {
    std::uint32_t samples = 0;    ///< places looked at, each for the same share of the area
    std::uint32_t buried = 0;     ///< of these, within another shell of the part: no skin of it
    std::uint32_t sorted_out = 0; ///< of these, with no wall behind them: sheets, and places before a hole
    std::vector<double> walls;    ///< what the others measured [m], ascending
    double thinnest = 0;          ///< [m]; 0 if there are no walls
    Point thinnest_at{};          ///< place on the surface, in the mesh's frame [m]

    /// Whether it says something about the part: a wall behind at least half of its skin.
    bool meaningful() const { return !walls.empty() && walls.size() >= sorted_out; }
    /// Thickness [m] that a share `q` of the area is thinner than. Needs walls.
    double quantile(double q) const;
    /// Share of the measured area that is thinner than `length` [m].
    double share_below(double length) const;
};

/// Looks from 4096 places, spread over the area, straight against the outward normal (orient() the mesh
/// first), for the place where the solid ends: nested, overlapping and touching parts are one, a cavity ends
/// a wall. A ray that meets more than some ten thousand boxes is given up as sorted out. A pure function of
/// the mesh.
Thickness thickness(const Mesh &mesh, Progress &progress);

/// The voxel that gives walls of `wall` [m] three cells, rounded down to 1, 2 or 5 times a power of ten. A
/// wall may be 2 % too thin for it: what is round is cut from polygons.
double voxel_for_wall(double wall);

/// So many voxels less the 2 % of voxel_for_wall() [m]. Walls below three are thin.
double wall_of(double voxels, double voxel);

/// 1, 2 or 5 times a power of ten: the nearest below (or at) and above (or at) x > 0.
double round_down_125(double x);
double round_up_125(double x);

} // namespace voxshell
