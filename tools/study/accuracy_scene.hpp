// SPDX-License-Identifier: GPL-3.0-or-later
// What the accuracy study looks at: a scene file, or one of its own scenes whose force is a formula.
#pragma once

#include "scene/scene_file.hpp"
#include "study/foundation.hpp"
#include "study/paper_scenarios.hpp"

#include <optional>
#include <string>
#include <vector>

namespace voxshell {

/// A ball against a distance that is known as a formula.
struct BallCase {
    double radius;
    Distance distance;
};

struct AccuracyScene {
    std::string name;      ///< "cup_press", "ball-in-bowl"
    std::string given;     ///< as on the command line
    Mesh statics, dynamic; ///< of what moves: in the frame that the hand moves
    HandPath hand;
    double rate = 1000;       ///< [Hz]
    double voxel = 0;         ///< [m]
    Method method{};          ///< as the scene has it
    unsigned evaluations = 1; ///< of contact in a tick, at most: more than one with a quasi-static coupling
    std::optional<BallCase> ball;
    std::string hash; ///< of all that is above, hexadecimal
};

/// given: NAME.scene.json, or a name of own_scenes(). Throws Failure: as read_scene() and import_scene();
/// usage (neither of the two); unsupported (a part that stands and has a path).
AccuracyScene accuracy_scene(const std::string &given);

/// ball-on-plane, ball-on-cylinder, ball-in-bowl.
std::vector<std::string> own_scenes();

} // namespace voxshell
