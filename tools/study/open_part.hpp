// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh on the pipeline's way to assets, opened by the runtime, without files.
#pragma once

#include "import/scene.hpp"
#include "pipeline/convert_part.hpp"
#include "plan/memory.hpp"

#include "voxshell/pointshell.h"
#include "voxshell/voxmap.h"

namespace voxshell {

class OpenPart {
  public:
    /// Throws Failure as convert_part().
    OpenPart(const std::string &name, const Mesh &mesh, const PartOptions &options, Progress &progress);
    ~OpenPart();
    OpenPart(const OpenPart &) = delete;
    OpenPart &operator=(const OpenPart &) = delete;

    vxs_voxmap map{};
    vxs_pointshell shell{};
    const vxs_asset &map_file() const { return map_file_; }
    const vxs_asset &shell_file() const { return shell_file_; }
    double area = 0; ///< of the mesh [m^2]

  private:
    OpenPart(const Part &part);
    Memory map_bytes_, shell_bytes_;
    vxs_asset map_file_{}, shell_file_{};
};

} // namespace voxshell
