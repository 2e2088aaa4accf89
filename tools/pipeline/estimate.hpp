// SPDX-License-Identifier: GPL-3.0-or-later
// What a conversion will take, told from the mesh alone, before anything is allocated for it.
#pragma once

#include "import/scene.hpp"
#include "voxmap/channels.hpp"

#include <cstdint>

namespace voxshell {

struct Estimate {
    double surface_cells = 0; ///< a surface of area vector (x, y, z) crosses (|x| + |y| + |z|) / h^2 cells
    double pairs = 0;         ///< of triangle and brick of 8^3 cells, from above
    double memory_bytes = 0;  ///< peak of the process
    double file_bytes = 0;    ///< .vdb, .voxmap and .pointshell together
    double seconds = 0;       ///< on two cores of 2020; a guess
};

Estimate estimate(const Mesh &mesh, double voxel, const ChannelRequest &channels = {});

/// With a shell of another spacing [m].
Estimate estimate(const Mesh &mesh, double voxel, const ChannelRequest &channels, double shell_spacing);

/// Throws Failure(requirement), naming the smallest voxel that fits, where estimate() asks for more memory
/// than `budget` [bytes] or for more points than a .pointshell holds. `length`: what the message calls the
/// voxel.
void check_budget(const Mesh &mesh, double voxel, std::uint64_t budget, const ChannelRequest &channels = {},
                  const char *length = "voxel");

/// What this process may use [bytes]: the machine's memory, or less where the process is limited.
std::uint64_t machine_memory();

/// Largest resident size so far [bytes].
std::uint64_t peak_memory();

} // namespace voxshell
