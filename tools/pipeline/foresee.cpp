// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/foresee.hpp"

#include "mesh/orient.hpp"
#include "mesh/thickness.hpp"
#include "pipeline/choose_voxel.hpp"

namespace voxshell {

Foreseen foresee(const Scene &scene, const PartOptions &options, Progress &progress)
{
    const std::uint64_t budget = options.max_memory ? options.max_memory : machine_memory();
    Mesh mesh = flatten(scene);
    if (options.weld > 0) stitch_within(mesh, options.weld);
    Foreseen foreseen;
    foreseen.triangles = mesh.triangles.size();
    foreseen.voxel = options.voxel;
    if (!(foreseen.voxel > 0)) {
        orient(mesh);
        const VoxelChoice choice = choose_voxel(mesh, thickness(mesh, progress), budget, options.channels);
        foreseen.voxel = choice.voxel;
        foreseen.voxel_why = choice.why;
    }
    foreseen.estimate = estimate(mesh, foreseen.voxel, options.channels, options.shell_spacing);
    check_budget(mesh, foreseen.voxel, budget, options.channels);
    if (options.shell_spacing > 0) check_budget(mesh, options.shell_spacing, budget, {}, "shell spacing");
    return foreseen;
}

} // namespace voxshell
