// SPDX-License-Identifier: GPL-3.0-or-later
// One part's way from triangles to asset files: the only place that knows the order.
#pragma once

#include "cli/progress.hpp"
#include "import/scene.hpp"
#include "mesh/mend.hpp"
#include "mesh/orient.hpp"
#include "mesh/report.hpp"
#include "mesh/thickness.hpp"
#include "pointshell/shell.hpp"
#include "voxmap/channels.hpp"
#include "voxmap/classify.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

struct PartOptions {
    double voxel = 0; ///< edge of a cell [m]; 0: as choose_voxel() says
    ShellKind shell = ShellKind::exact;
    double shell_spacing = 0; ///< edge of the cells that the shell is made with [m]; 0: voxel
    double thin_shell =
        0; ///< normals within this angle share a point (pointshell/thin.hpp) [degrees]; 0: none does
    ChannelRequest channels; ///< of the map; none
    bool areas = true;       ///< of the points: what weighting area reads
    ImportOptions import;    ///< how the scene was read; the files record it
    double close_gap = 0;    ///< holes narrower than this do not let the outside in [m]; 0: every hole does
    bool strict = false;  ///< an open, leaking or wrongly wound mesh is a Failure(requirement), not a warning
    double weld = 0;      ///< border vertices that are nearer than this are stitched [m]; 0: none
    bool inspect = false; ///< look for self-intersections however long it takes
    bool stands = true;   ///< thin walls matter: a point of what moves passes through them
    std::uint64_t max_memory = 0; ///< [bytes]; 0: the machine's
    /// Called once the voxel is known, with what the part will take [bytes]; may wait until there is room.
    std::function<void(double)> admit{};
};

struct Part {
    std::string name;
    MeshReport mesh; ///< of the mesh as it came; `volume` after it was turned outwards
    OrientReport orient;
    StitchReport stitch; ///< with PartOptions::weld; `mesh` is of what came out of it
    std::optional<std::uint64_t> self_intersections; ///< triangles; nothing: not checked
    std::optional<std::uint64_t> open_on_lattice;    ///< open edges left after the snap, if the mesh is open
    Thickness thickness;
    double voxel = 0;      ///< edge of a cell [m]
    std::string voxel_why; ///< why this one, if it was chosen here
    Classification cells;  ///< what filling found; `leak` where the outside leaks in
    std::uint64_t surface_cells = 0, interior_cells = 0, points = 0;
    double shell_voxel = 0;    ///< edge of the cells of the shell [m]
    Thinning thinning;         ///< with PartOptions::thin_shell
    double distance_error = 0; ///< bound, with a distance channel [m]
    double gap_max = 0;        ///< [m]
    double surface_error = 0;  ///< [m]
    std::vector<Warning> warnings;
    std::vector<std::uint8_t> vdb, voxmap,
        pointshell; ///< the files' bytes: a pure function of input and options
};

/// stitch() for --weld [m]. Throws Failure(usage) where that is more than a hundredth of the mesh's longest
/// side.
StitchReport stitch_within(Mesh &mesh, double weld);

/// Throws Failure: requirement (--strict, memory, limits of the formats), interrupted.
Part convert_part(const Scene &scene, const PartOptions &options, Progress &progress);
/// The same, and the scene's meshes are gone: there is no second copy of a huge one while it is converted.
Part convert_part(Scene &&scene, const PartOptions &options, Progress &progress);

/// Version of the tools, as in META sections and reports.
const char *tool_version();

} // namespace voxshell
