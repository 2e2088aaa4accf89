// SPDX-License-Identifier: GPL-3.0-or-later
// The one file of the contact benchmarks that knows the runtime: a map and a shell through files, as users
// have them, and vxs_contact_evaluate() as a rival.
#pragma once

#include "contact_rival.hpp"

namespace voxshell::bench {

/// A way to run our contact: a row of the table.
struct OurMode {
    const char *name;
    std::uint32_t kernel;          ///< VXS_CONTACT_SCALAR ...
    std::uint32_t culling;         ///< VXS_CONTACT_BRUTE, VXS_CONTACT_CULLED, VXS_CONTACT_COHERENT
    std::uint32_t law;             ///< VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE, VXS_CONTACT_GRADIENT
    bool distance;                 ///< needs a map with the distance channel
    std::uint32_t most_points = 0; ///< time-critical: looks at no more than these, at levels of detail
};
std::vector<OurMode> our_modes(); ///< those that this processor can run

/// An open voxmap of a mesh; with `distance` up to three cells from its surface.
class OurMap;
std::shared_ptr<const OurMap> make_our_map(const Mesh &mesh, double voxel, bool distance);
double mib_of(const OurMap &map);

std::unique_ptr<Rival> make_our_rival(const OurMode &mode, std::shared_ptr<const OurMap> map,
                                      const Points &points);

} // namespace voxshell::bench
