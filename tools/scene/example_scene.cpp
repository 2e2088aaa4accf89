// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/example_scene.hpp"

#include "voxshell/servo.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace voxshell {
namespace {

constexpr const char *above =
    R"(// A scene: what stands, what moves, how contact feels, on which device, and where the hand goes.
// Comments are read over. A number with a dimension is a string with its unit. What has no default is marked *.
// In a NAME.scene.glb the same object, without static and dynamic, is the custom property (extras) "voxshell" of the
// glTF's scene, and the objects (nodes) that are parts have "voxshell": "static" or "dynamic"; animations are paths.
{
  "scene": "voxshell-scene/1",                   // * version of this format
  "voxel": "2mm",                                // * edge of a cell (m, cm, mm, um, in)

  // * What stands: one or more parts. "unit" is needed for STL and for nothing else; "up": "z" turns a Z-up file.
  "static": [{
    "file": "cup.glb",                           // .glb .gltf .stl, inside this file's folder
    // "node": "Cup",                            // of glTF only this node; without a pose it stands where the node does
    "pose": {"position": ["0mm", "0mm", "0mm"], "rotation": [0, 0, 0, 1]}   // quaternion x y z w
    // "path": [{"t": "0s", "position": [...]}, {"t": "1s", "position": [...], "rotation": [...]}]   in place of a pose: it moves
  }],

  // * What moves with the device: exactly one part.
  "dynamic": [{
    "file": "sphere.glb"
    // "density": "1g/cm^3"                      // for effects that ask what it weighs
  }],

  "contact": {
    "law": "average",                            // original | average | patch | gradient
    "field": "surface",                          // surface | layers | distance; with gradient: distance
    "weighting": "count",                        // count | count-capped | area
    "stiffness": "50N/m"                         // * of a point (N/m, N/mm); with area of the surface (N/m^3, N/mm^3)
    // "most_stiffness": "5N/mm",                // bound on the contact as a whole
    // "budget": "20us"                          // what contact may take in a tick; with area only
  },

  // None, pt2, spring-damper or quasi-static; or {"design": "auto"}: what the device carries.
  "coupling": {"kind": "pt2", "frequency": "5Hz", "damping": 1},
  // "coupling": {"kind": "pt2", "stiffness": "500N/m", "viscosity": "10Ns/m", "mass": "50g", "gain": "unity", "prewarp": false},
  // "coupling": {"kind": "spring-damper", "stiffness": "1N/mm", "mass": "50g", "damping": 0.7, "radius": "20mm"},
  // "coupling": {"kind": "quasi-static", "stiffness": "1N/mm", "radius": "20mm", "evaluations": 3},
  // "coupling": {"design": "auto", "assume": "hand"},

  // What protects the hand. Without this key the first two do; a list replaces them.
)";

constexpr const char *below = R"(
  "device": "sim:phantom-premium-1.5",           // sim:NAME; a wrong NAME is told those that there are
  "arm": "hand",                                 // free | pen | hand | arm: who holds it
  "rate": "1kHz",                                // ticks a second, 10Hz to 100kHz

  // * Where the hand goes in a simulated run: straight to a position, or along an arc.
  "hand": {"path": [
    {"t": "0s", "position": ["75mm", "40mm", "0mm"]},
    {"t": "0.5s", "position": ["48mm", "40mm", "0mm"], "rotation": [0, 0, 0, 1]},
    {"t": "1s", "turn": {"about": ["0mm", "40mm", "0mm"], "axis": [0, 1, 0], "angle": "20deg"}}
  ]}
}
)";

std::string value(const vxs_effect_constant &constant)
{
    const std::string number = fmt::format("{}", constant.standard);
    return *constant.unit ? fmt::format("\"{}{}\"", number, constant.unit) : number;
}

/// {"kind": "slew", "force": "0N/s", "torque": "0Nm/s"}, all constants as by default.
std::string item(std::uint32_t kind)
{
    std::uint32_t count = 0;
    const vxs_effect_constant *constants = vxs_effect_constants(kind, &count);
    std::string text = fmt::format("{{\"kind\": \"{}\"", vxs_effect_kind_name(kind));
    for (std::uint32_t n = 0; n < count; ++n) {
        const std::string name = constants[n].name;
        const bool is_vector = n + 2 < count && name.ends_with("_x");
        if (is_vector) {
            text += fmt::format(", \"{}\": [{}, {}, {}]", name.substr(0, name.size() - 2),
                                value(constants[n]), value(constants[n + 1]), value(constants[n + 2]));
            n += 2;
        } else {
            text += fmt::format(", \"{}\": {}", name, value(constants[n]));
        }
    }
    return text + "}";
}

} // namespace

std::string example_scene()
{
    vxs_servo_config standard;
    vxs_servo_config_default(&standard);
    std::string guards, more_guards, effects;
    for (std::uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; ++n) {
        const std::span defaults(standard.effects, standard.effect_count);
        if (vxs_effect_is_guard(kind) &&
            std::ranges::find(defaults, kind, &vxs_effect::kind) != defaults.end()) {
            guards += (guards.empty() ? "    " : ",\n    ") + item(kind);
        } else {
            (vxs_effect_is_guard(kind) ? more_guards : effects) += "    // " + item(kind) + "\n";
        }
    }
    return fmt::format("{}  \"guards\": [\n{}\n{}  ],\n\n{}  \"effects\": [\n{}  ],\n{}", above, guards,
                       more_guards,
                       "  // What the tick does besides, each with its constants as by default. What is not "
                       "listed costs nothing.\n",
                       effects, below);
}

} // namespace voxshell
