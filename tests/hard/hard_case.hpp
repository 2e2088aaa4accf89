// SPDX-License-Identifier: GPL-3.0-or-later
// The suite of hard cases (METHOD section 5): what a case is, and what it finds to work with.
//
// A case is one file in cases/ and one row in hard_suite.cpp. It measures one number, its worst over poses or
// ticks, on every pair of a law and a field; where it claims to hold, that must stay within the bound. What
// no pair may ever do, whether claimed or not: give a number that is not finite, force without contact,
// another wrench with another kernel or culling. Assets are made by the real pipeline, contact and servo are
// the runtime's.
#pragma once

#include "import/scene.hpp"

#include "voxshell/servo.h"
#include "voxshell/simulated.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace hard {

using voxshell::Mesh;
using voxshell::Point;

/// A column of the map.
struct Pair {
    const char *name; ///< "patch/layers"
    std::uint32_t law, field;
};
const std::vector<Pair> &pairs();

/// What a case has measured on a pair.
class Measured {
  public:
    /// Keeps the largest; `where` says at which pose or tick.
    void note(double value, const std::string &where = {});
    /// A promise of all pairs: the first one broken is kept.
    void must(bool holds, const std::string &what);
    /// The pair cannot run the case, and says so: an asset without the channel.
    void refuse(const std::string &why);

    double worst = 0;
    std::string where, broken, refused;
};

struct Options {
    long ticks = 20'000; ///< of the long walk; METHOD's 10^7 by --ticks
};

struct Case {
    const char *name;
    const char *what;  ///< the case, in a line
    const char *worst; ///< what is measured, and its unit
    double bound;
    std::function<bool(const Pair &)> claims; ///< whether the bound must hold
    std::function<void(const Pair &, const Options &, Measured &)> run;
};

bool all(const Pair &pair);
bool none(const Pair &pair);
bool reads_distance(const Pair &pair); ///< field distance
bool reads_surface(const Pair &pair);  ///< field surface: an inside does not matter
/// Law average, or field distance, where the sides of a wall's cells cancel.
bool has_common_normal(const Pair &pair);
bool keeps_opposed(const Pair &pair); ///< laws patch and gradient: opposed normals do not cancel
/// The same with field distance, which knows the depth at a slant and at an edge as well.
bool keeps_slanted(const Pair &pair);
bool is_conservative(const Pair &pair); ///< law gradient: the force is the slope of an energy

/// A part's files, open: layers +-4 and a distance band of 4 cells where the part has an inside.
struct Asset {
    std::vector<std::byte> map_bytes, shell_bytes;
    vxs_asset map_file, shell_file;
    vxs_voxmap map;
    vxs_pointshell shell;
    double area; ///< of the mesh [m^2]
};
/// Made once for each name.
const Asset &asset(const std::string &name, double voxel, const std::function<Mesh()> &mesh);

constexpr double h = 1e-3;        ///< edge of a cell, unless a case says otherwise [m]
constexpr double stiffness = 1e8; ///< [N/m^3] of area

/// Contact of a shell and a map; each wrench is checked against what all pairs promise.
class Touch {
  public:
    Touch(const Asset &fixed, const Asset &moving, const Pair &pair, Measured &measured,
          double foundation = stiffness);
    const vxs_contact_result &at(const vxs_pose &pose);
    vxs_contact_config config;
    vxs_contact_static statics; ///< of the fixed part; its pose may be set

  private:
    struct Engine {
        std::vector<std::max_align_t> memory;
        vxs_contact *contact = nullptr;
    };
    void open(Engine &engine, const Asset &moving, std::uint32_t kernel, std::uint32_t culling);
    Engine fastest_, plain_;
    Measured *measured_;
    unsigned count_ = 0;
    vxs_contact_result result_{};
};

vxs_pose pose_at(const Point &position, const std::array<double, 4> &wxyz = {1, 0, 0, 0});
vxs_pose turned(const Point &position, const Point &axis, double angle);
double length(const double v[3]);
double apart(const double a[3], const double b[3]);
/// Wrenches that should be the same: notes the largest difference over the largest wrench, torque by `arm`
/// [m].
class Comparison {
  public:
    Comparison(Measured &measured, double arm) : measured_(&measured), arm_(arm) {}
    ~Comparison();
    Comparison(const Comparison &) = delete;
    Comparison &operator=(const Comparison &) = delete;
    void add(const vxs_wrench &a, const vxs_wrench &b, const std::string &where);

  private:
    Measured *measured_;
    double arm_, most_ = 0, size_ = 0;
    std::string where_;
};
std::string number(double value);

/// The largest change of the force from one of `steps` poses to the next, over the largest force on the way.
double worst_jump(Touch &touch, Measured &measured, int steps,
                  const std::function<vxs_pose(double share)> &path);

/// A press and a slide of the moving part over both fixed ones: the difference() of their wrenches.
void compare(const Asset &clean, const Asset &other, const Asset &moving, const Pair &pair,
             Measured &measured);
/// The same with `other` for a moving part that should be the same as `moving`.
void compare_moving(const Asset &fixed, const Asset &moving, const Asset &other, const Pair &pair,
                    Measured &measured);

/// Servo and simulated device, a ball of 5 mm over a floor whose top is y = 0, start at y = 6 mm.
class Loop {
  public:
    Loop(const Pair &pair, Measured &measured,
         const std::function<void(vxs_servo_config &, vxs_simulated_config &)> &change = {});
    ~Loop();
    Loop(const Loop &) = delete;
    Loop &operator=(const Loop &) = delete;
    /// One sample with the hand there; checks what every tick must keep.
    std::uint32_t tick(const Point &hand, const double *orientation = nullptr);
    /// The tick on a state that a test has changed.
    std::uint32_t tick_on(const vxs_device_state &state);
    vxs_device *device = nullptr;
    vxs_servo *servo = nullptr;
    vxs_device_state state{};
    vxs_device_command command{};
    vxs_device_report report{};
    vxs_servo_trace row{};

  private:
    std::vector<std::max_align_t> device_memory_, servo_memory_;
    vxs_contact_static statics_{};
    Measured *measured_;
    double max_force_ = 0, max_torque_ = 0;
};

} // namespace hard
