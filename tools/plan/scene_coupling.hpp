// SPDX-License-Identifier: GPL-3.0-or-later
// The coupling of a scene on a device: as the scene says, or designed. What is compiled into a plan and what
// simulate runs is this.
#pragma once

#include "plan/design.hpp"
#include "scene/scene_file.hpp"

#include <functional>
#include <optional>

namespace voxshell {

/// The largest stiffness of a scene's contact, and how it is known.
struct ContactStiffness {
    double value;       ///< [N/m]
    std::string source; ///< for a sentence: "stated by the scene", "along the hand's path"
};

/// What only the scene's assets tell; asked where a design needs it.
struct SceneContact {
    std::function<ContactStiffness()> stiffness;
    std::function<std::vector<Push>()> pushes;
};

struct SceneCoupling {
    vxs_coupling_config config;
    std::string text;             ///< "pt2 5 Hz", "quasi-static 400 N/m (auto)"
    std::optional<Design> design; ///< where the scene asks for one
};

/// device: with the scene's rate. Throws Failure: invalid (numbers that the rate does not carry), requirement
/// (a design that is unstable with an arm that counts).
SceneCoupling scene_coupling(const SceneFile &scene, const vxs_simulated_config &device,
                             const SceneContact &contact);

/// "pt2 5 Hz", "quasi-static 400 N/m (auto)" if it was designed.
std::string coupling_text(const vxs_coupling_config &config, bool designed);

/// What a design of the scene is given, whether or not the scene asks for one; pushes are the caller's to
/// add.
DesignInput design_input(const SceneFile &scene, const vxs_simulated_config &device, double stiffness);

} // namespace voxshell
