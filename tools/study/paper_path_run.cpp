// SPDX-License-Identifier: GPL-3.0-or-later
// Contact along a prescribed path.
#include "plan/memory.hpp"
#include "study/open_part.hpp"
#include "study/paper_path.hpp"
#include "study/paper_run.hpp"

#include <algorithm>

namespace voxshell {
namespace {

/// Where a figure draws single ticks: one seed, and of figure 8 all of them.
bool is_drawn(const RunKey &key)
{
    const std::string group = key.scenario->group;
    return group == "fig8" || (key.seed == 1 && group != "degenerate");
}

} // namespace

PathRun run_path(const RunKey &key, const OpenPart &stands, const OpenPart &moves)
{
    const vxs_pointshell &shell = moves.shell;
    const Scenario &scenario = *key.scenario;
    const Path path(scenario, key.level_value(), key.seed);
    const Method &method = key.how().method;
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = method.law;
    config.field = method.field;
    config.weighting = method.weighting;
    config.stiffness = 1 / scenario.voxel;
    if (method.weighting == VXS_CONTACT_AREA)
        config.stiffness /= scenario.voxel * scenario.voxel; // e^2 to a point
    const Memory room(vxs_contact_memory(&shell, 1));
    vxs_contact *contact = nullptr;
    if (vxs_contact_init(room.get(), room.size(), &shell, 1, &contact) != VXS_OK) {
        throw Failure(ExitCode::bug, scenario.id, "no contact");
    }
    const vxs_contact_static statics{&stands.map, nullptr};
    std::vector<ForceSample> samples;
    PathRun run{key, {}, false, path.crossing_hz(), path.radius(), plane_height(scenario, key.seed) / scenario.voxel,
                {},  {}};
    for (std::size_t tick = 0; tick < path.ticks(); ++tick) {
        const Path::Step step = path.at(tick);
        run.degenerate |= is_degenerate(step);
        vxs_contact_result result;
        vxs_contact_evaluate(contact, &statics, 1, &step.pose, &config, &result);
        if (result.flags & (VXS_CONTACT_INVALID | VXS_CONTACT_OUT_OF_MAP)) {
            throw Failure(ExitCode::bug, scenario.id, "a pose that the contact refuses");
        }
        samples.push_back({along(step, result.wrench.force), along(step, result.wrench.torque),
                           along(step, step.ideal_force.data()), along(step, step.ideal_torque.data()),
                           result.points, (result.flags & VXS_CONTACT_DEEP) != 0,
                           (result.flags & VXS_CONTACT_MEAN_CANCELLED) != 0});
        if (is_drawn(key)) run.progress.push_back(step.progress);
    }
    run.metrics = force_metrics(samples, study_rate, path.radius(), path.crossing_hz(), path.is_periodic());
    run.degenerate |= run.metrics.degenerate;
    if (is_drawn(key)) run.samples = std::move(samples);
    return run;
}

} // namespace voxshell
