// SPDX-License-Identifier: GPL-3.0-or-later
// The scene file (.scene.json, "voxshell-scene/1"; formats/schema/scene.schema.json; `voxshell convert
// --example-scene`): what stands, what moves, how it feels, and where the hand goes.
//
//   {
//     "scene": "voxshell-scene/1",
//     "voxel": "2mm",                   edge of a cell, of both assets
//     "static": [{
//        "file": "cup.glb",             relative, inside the scene's own folder
//        "unit": "mm", "up": "z",       STL only / where the file is Z-up
//        "node": "Cup",                 glTF: only this node and what is below it, in its own frame; without
//                                       a pose it stands where the node does
//        "pose": {"position": ["0mm", "0mm", "0mm"], "rotation": [0, 0, 0, 1]},      x y z w, as in glTF
//        "path": [{"t": "0s", "position": [..]}, {"t": "1s", "position": [..], "rotation": [..]}]
//                                       in place of a pose: the part moves (effect motion, effect.h) and has
//                                       a map of its own; at least one part has none
//     }],
//     "dynamic": [{                     exactly one
//        "file": "sphere.glb",
//        "density": "1g/cm^3"           for effects that ask what it weighs: mass, com and inertia that they
//     }],                               do not say
//     "contact": {
//        "law": "average",              original|average|patch|gradient
//        "field": "surface",            surface|layers|distance: its map gets that channel; with gradient
//                                       distance alone, and of itself
//        "weighting": "count",          count|count-capped (stiffness in N/m per point)|area (N/m^3)
//        "stiffness": "500N/m",
//        "most_stiffness": "5N/mm",     bounds the whole contact
//        "budget": "20us"               what contact may take in a tick, at coarser levels of detail if need
//     },                                be; with weighting area only
//     "coupling": {"kind": "pt2", "frequency": "5Hz", "damping": 1},
//        none, or pt2 with "prewarp": true if its frequency is to be exact; in place of these also
//          "stiffness": "500N/m", "viscosity": "10Ns/m", "mass": "50g", then "gain": unity|physical (1/c)
//        {"kind": "spring-damper", "stiffness": "1N/mm", "mass": "50g", "damping": 0.7, "radius": "20mm"}
//        {"kind": "quasi-static", "stiffness": "1N/mm", "radius": "20mm", "evaluations": 3}
//        {"kind": "pt2", "design": "auto"} (or quasi-static): what the device carries, held by anybody or
//          nobody; refused if nothing is stable; "assume": free|pen|hand|arm: only that one counts
//        {"design": "auto"}: picks the kind as well: pt2 if it is stable and stops the hand's own path before
//          the middle of what it pushes against; else quasi-static, where what feels the contact is not the
//          device and cannot be pushed through; prewarp, radius, evaluations may be said for either
//     "guards": [
//        {"kind": "start-inside"},      no force until the object was free once
//        {"kind": "soft-start", "time": "0.5s"},
//        {"kind": "slew", "force": "2N/ms", "torque": "50Nm/s"},
//        {"kind": "passivity", "most_damping": "5Ns/m", "least_speed": "1mm/s", "radius": "30mm"}],
//        Without the key the first two guard, as safe by default; a list replaces them: what it does not name
//        is not there. Clamp and fault latch are always there.
//     "effects": [],                    none; what is not named costs nothing
//        What guards and effects do and what their constants are by default: voxshell/effect.h; each is
//        optional, its key is its name there (of three that end in _x, _y and _z: what comes before, and a
//        list). Passivity's are the device's by default.
//     "device": "sim:phantom-premium-1.5",
//     "arm": "hand",                    free|pen|hand|arm
//     "rate": "1kHz",
//     "hand": {"path": [
//        {"t": "0s", "position": ["60mm", "40mm", "0mm"], "rotation": [0, 0, 0, 1]},      straight to here
//        {"t": "2s", "turn": {"about": ["0mm", "40mm", "0mm"], "axis": [0, 1, 0], "angle": "90deg"}}]} an arc
//   }
//
// NAME.scene.glb and NAME.scene.gltf are whole scenes too: the "extras" of the glTF's scene hold "voxshell":
// the object above without static and dynamic; those of a node hold "voxshell": "static", or "dynamic", or
// {"role": "dynamic", "density": "1g/cm^3"} (or text that holds such an object: some editors of properties
// know nothing else). A node with a role is a part, with all below it, in its own frame; nodes without are
// not of the scene. Where it stands, its animation if it has one (LINEAR, moved and turned), is pose or path;
// of what is dynamic: where the hand goes, unless "hand" says it. A turn between two keys is the motion's
// (effect.h).
//
// Comments (// and /* */) are read over. Only voxel, static, dynamic and hand have no default. A value with a
// dimension is a string with its unit.
#pragma once

#include "cli/failure.hpp"
#include "import/scene.hpp"
#include "scene/effect_reader.hpp"

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

using Quaternion = std::array<double, 4>; ///< x y z w, unit

struct Pose {
    Point position{}; ///< [m]
    Quaternion rotation{0, 0, 0, 1};
};

struct ScenePart {
    std::filesystem::path file; ///< the scene's folder / what it says
    ImportOptions import;
    Pose pose;                     ///< scene from part
    bool stands_as_stored = false; ///< where its node stands in its file, in place of a pose
    double density = 0;            ///< of what moves [kg/m^3]; 0: not said
    struct Stop {
        double t; ///< [s], ascending
        Pose pose;
    };
    std::vector<Stop> path; ///< of what stands: where it goes; empty: nowhere
};

/// Where the hand is, over time: straight lines and arcs from one keyframe to the next, constant before the
/// first and after the last.
struct HandPath {
    struct Keyframe {
        double t; ///< [s], ascending
        Pose pose;
        /// Reached by an arc: from the last keyframe's position about `about`, by `angle` about `axis`
        /// (unit).
        struct Turn {
            Point about;
            Point axis;
            double angle; ///< [rad]
        };
        std::optional<Turn> turn;
    };
    std::vector<Keyframe> keyframes; ///< at least one
    Pose at(double t) const;
};

enum class ContactLaw { original, average, patch, gradient };
enum class ContactField { surface, layers, distance };
enum class Weighting { count, count_capped, area };
enum class CouplingKind { none, pt2, spring_damper, quasi_static, designed };

struct SceneFile {
    std::filesystem::path path;
    std::array<std::uint8_t, 32> source_hash{}; ///< SHA-256 of the file
    double voxel = 0;                           ///< [m]
    std::vector<ScenePart> statics;
    ScenePart dynamic; ///< its pose turns the part into the frame that the device moves
    ContactLaw law = ContactLaw::average;
    ContactField field = ContactField::surface;
    Weighting weighting = Weighting::count;
    double budget = 0;         ///< of contact in a tick [s], 0: none
    double most_stiffness = 0; ///< of the contact as a whole [N/m], 0: no bound
    double stiffness = 500;    ///< count: [N/m] per point, area: [N/m^3]
    CouplingKind coupling = CouplingKind::pt2;
    bool design =
        false; ///< pt2, quasi_static: their numbers come from an automatic design; designed: the kind too
    std::string assume;         ///< of the design: the arm that counts; empty: all
    double frequency = 5;       ///< pt2 [Hz]
    double damping = 1;         ///< pt2, spring_damper: ratio
    bool prewarp = false;       ///< pt2
    bool by_impedance = false;  ///< pt2: from stiffness, viscosity and mass in place of frequency and damping
    bool physical_gain = false; ///< pt2 by impedance: 1 / stiffness, else 1
    double spring_stiffness = 1000;   ///< spring_damper, quasi_static, pt2 by impedance [N/m]
    double viscosity = 0;             ///< pt2 by impedance [N s/m]
    double mass = 0.05;               ///< spring_damper, pt2 by impedance [kg]
    double radius = 0.02;             ///< spring_damper, quasi_static: of gyration [m]
    unsigned evaluations = 3;         ///< quasi_static: of contact in a tick at most
    std::vector<SceneEffect> effects; ///< guards first
    std::string device = "sim:phantom-premium-1.5";
    std::string arm = "hand";
    double rate = 1000; ///< [Hz]
    HandPath hand;
};

/// Reads and checks all of it. Throws Failure(system) if it cannot be read, and Failure(invalid) with the
/// place as a JSON pointer ("/static/0/pose/positon: unknown key; did you mean position?"): an unknown or
/// doubled key, a wrong type, a wrong unit, a file outside the scene's folder, nesting deeper than 16, more
/// than 16 MiB.
SceneFile read_scene(const std::filesystem::path &path);

/// NAME.scene.json, NAME.scene.gltf or NAME.scene.glb: decided by the ending alone.
bool is_scene(const std::filesystem::path &path);

/// "; did you mean cup.scene.json?" for a scene that is there, named without its ending; else nothing.
std::string meant_scene(const std::filesystem::path &path);
/// Of glTF.
bool is_gltf_scene(const std::filesystem::path &path);
/// NAME: what its assets are called.
std::string scene_name(const std::filesystem::path &path);

/// v turned by q.
Point rotate(const Quaternion &q, const Point &v);

} // namespace voxshell
