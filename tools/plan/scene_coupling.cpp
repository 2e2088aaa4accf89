// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/scene_coupling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace voxshell {
namespace {

constexpr double two_pi = 2 * std::numbers::pi;

void check(const SceneFile &scene, vxs_result result)
{
    if (result != VXS_OK) {
        throw Failure(ExitCode::invalid, scene.path.string(),
                      std::string("/coupling: ") + vxs_result_text(result));
    }
}

/// As the scene says; of a design, where it begins from.
vxs_coupling_config said(const SceneFile &scene)
{
    vxs_coupling_config config;
    vxs_coupling_config_default(&config);
    config.sample_time = 1 / scene.rate;
    config.damping = scene.damping;
    config.omega0 = two_pi * (scene.design ? std::min(scene.frequency, 0.1 * scene.rate) : scene.frequency);
    config.prewarp = scene.prewarp;
    config.stiffness = scene.spring_stiffness;
    config.mass = scene.mass;
    config.radius = scene.radius;
    config.evaluations = scene.evaluations;
    switch (scene.coupling) {
    case CouplingKind::none:
        config.kind = VXS_COUPLING_NONE;
        break;
    case CouplingKind::pt2:
    case CouplingKind::designed: // from either
        config.kind = VXS_COUPLING_PT2;
        break;
    case CouplingKind::spring_damper:
        config.kind = VXS_COUPLING_SPRING_DAMPER;
        break;
    case CouplingKind::quasi_static:
        config.kind = VXS_COUPLING_QUASI_STATIC;
        break;
    }
    if (scene.by_impedance) {
        check(scene, vxs_coupling_from_impedance(&config, scene.spring_stiffness, scene.viscosity, scene.mass,
                                                 scene.physical_gain));
    }
    check(scene, vxs_coupling_config_check(&config));
    return config;
}

} // namespace

std::string coupling_text(const vxs_coupling_config &config, bool designed)
{
    const char *mark = designed ? " (auto)" : "";
    if (config.kind == VXS_COUPLING_NONE) return "no coupling";
    const std::string name = vxs_coupling_kind_name(config.kind);
    if (config.kind == VXS_COUPLING_PT2) {
        return fmt::format("{} {:.4g} Hz{}", name, config.omega0 / two_pi, mark);
    }
    if (config.kind == VXS_COUPLING_QUASI_STATIC) {
        return fmt::format("{} {:.4g} N/m{}", name, config.stiffness, mark);
    }
    return name;
}

DesignInput design_input(const SceneFile &scene, const vxs_simulated_config &device, double stiffness)
{
    DesignInput input;
    input.device = device;
    input.stiffness = stiffness;
    input.coupling = said(scene);
    input.automatic = scene.design;
    input.any_kind = scene.coupling == CouplingKind::designed;
    if (!scene.assume.empty()) {
        input.assume = {scene.assume};
    }
    return input;
}

SceneCoupling scene_coupling(const SceneFile &scene, const vxs_simulated_config &device,
                             const SceneContact &known)
{
    SceneCoupling out{said(scene), {}, {}};
    if (scene.design) {
        const ContactStiffness contact = known.stiffness();
        DesignInput input = design_input(scene, device, contact.value);
        if (input.any_kind) input.pushes = known.pushes();
        const Design design = design_coupling(input);
        if (design.refused) {
            const auto bad = std::find_if(design.arms.begin(), design.arms.end(),
                                          [](const ArmDesign &arm) { return arm.counts && !arm.stable(); });
            throw Failure(
                ExitCode::requirement, scene.path.string(),
                fmt::format("/coupling: no {} is stable on {} {}: it carries {:.4g} N/m, contact has {:.4g} "
                            "N/m ({}){}",
                            vxs_coupling_kind_name(design.coupling.kind), design.input.device.profile.name,
                            bad->arm == "free" ? "with the hand off" : "held by a " + bad->arm,
                            bad->largest_stiffness, contact.value, contact.source,
                            scene.assume.empty()
                                ? "; soften the contact, take a quasi-static coupling, or say \"assume\": "
                                  "\"hand\" if the device is always held"
                                : "; soften the contact or take a quasi-static coupling"));
        }
        out.config = design.coupling;
        out.design = design;
    }
    out.text = coupling_text(out.config, scene.design);
    return out;
}

} // namespace voxshell
