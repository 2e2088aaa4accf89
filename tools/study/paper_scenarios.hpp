// SPDX-License-Identifier: GPL-3.0-or-later
// The experiments of the paper and ours beside them, as data: one row of a table a scenario.
//
// Lengths are in metres, `e` is the edge of a cell. k is 1 N per e for each point, but where a row says
// otherwise.
#pragma once

#include "pointshell/shell.hpp"

#include "voxshell/contact.h"

#include <span>
#include <string>
#include <vector>

namespace voxshell {

enum class Stands {
    plane,        ///< along the grid; its height within a cell is drawn
    middle_plane, ///< along the grid, in the middle of its cells
    tilted_plane,
    cylinder,
    tilted_cylinder,
    groove, ///< 60 degrees, tilted
    hole,   ///< of 20 mm in a block
    cup,
    plate ///< tilted; a level says how thick
};

enum class Moves {
    ball,
    peg ///< a level says how thick
};

enum class Motion {
    circle,  ///< on a plane, or round a cylinder: one turn in 3 s at constant depth (a level) under a given
             ///< pose
    press,   ///< into the groove, to 2 e in 3 s; a level: depth at the other wall, as a share
    insert,  ///< 15 mm into the hole at 50 mm/s, tilted by a degree
    coupled, ///< circle with an approach of 0.5 s, through a coupling: what would be felt
    push,    ///< a device held by a hand that goes 8 mm inside at a speed (or a level), and stays
    slide    ///< a device held by a hand that goes round the cup 2 mm inside at a speed for 4 s
};

/// How force is computed.
struct Method {
    ShellKind shell;
    std::uint32_t law, field, weighting; ///< VXS_CONTACT_*
};
std::string law_name(std::uint32_t law);
std::string field_name(std::uint32_t field);
std::string weighting_name(std::uint32_t weighting);
std::string shell_name(ShellKind kind);
std::string method_text(const Method &method); ///< "exact, average, surface"

/// What is between contact and hand.
struct Coupled {
    enum Kind { none, spring_damper, pt2, automatic } kind;
    double hertz = 0;     ///< pt2, damping 1
    bool bounded = false; ///< the contact as a whole is half as stiff as the loop carries with this coupling
};
std::string coupled_text(const Coupled &coupled);

struct Variant {
    Method method;
    Coupled coupled{Coupled::none};
};

struct Scenario {
    const char *id;    ///< "fig8c"
    const char *group; ///< "fig8": scenarios that are shown together
    Stands stands;
    Moves moves;
    double voxel;  ///< e [m]
    double radius; ///< of the ball [m]
    Motion motion;
    bool turned; ///< the moving shell is turned at random
    std::vector<double> levels;
    const char *level; ///< what a level is: "depth_e", "peg_mm", "plate_e"; "" where there is but one
    std::vector<double> speeds; ///< push and slide [m/s]
    const char *device;         ///< push, slide and coupled: "sim:NAME"
    std::vector<Variant> variants;
};

std::span<const Scenario> paper_scenarios();
const Scenario &paper_scenario(const std::string &id);

bool is_loop(const Scenario &scenario); ///< push or slide: a device closes the loop

/// What a seed draws, the same for every scenario, so that laws meet the same shells on the same paths.
struct Draw {
    double orientation[4]; ///< evenly among all turns
    double offset[4];      ///< [0, 1)
};
Draw draw(unsigned seed);

/// Cup of figure 12 [m].
inline constexpr double cup_outer = 0.040, cup_inner = 0.034, cup_height = 0.080, cup_floor = 0.006;
/// Of figures 9 and 11 [e].
inline constexpr double cylinder_radius_e = 30, circle_radius_e = 15;
inline constexpr double hole_radius = 0.010, hole_height = 0.020, peg_length = 0.030;
inline constexpr double study_rate = 1000; ///< [Hz]
inline constexpr double turn_seconds = 3, approach_seconds = 0.5;
inline constexpr double push_depth = 0.008, slide_depth = 0.002; ///< of the hand's target [m]

} // namespace voxshell
