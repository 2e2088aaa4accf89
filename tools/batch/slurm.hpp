// SPDX-License-Identifier: GPL-3.0-or-later
// Filling the cache on a Slurm cluster: an array job whose tasks are this program on a shard of the parts.
#pragma once

#include "batch/batch.hpp"

#include <functional>
#include <string>
#include <vector>

namespace voxshell {

struct SlurmOptions {
    std::vector<std::string> command; ///< this program and its arguments; --shard and -q are added
    std::vector<std::string> sbatch;  ///< more arguments of sbatch: {"--partition=night"}
    unsigned shards = 8;
    unsigned attempts = 3;                         ///< of a shard whose node was lost or whose job was ended
    std::function<void(const std::string &)> tell; ///< one line
};

/// Submits `shards` tasks that share the work `plan` (a folder that all nodes see), waits for them, and
/// submits those again that did not come to their end. A part that cannot be converted is no reason. Ends
/// the job when interrupted. Throws Failure: system (no sbatch, refused by it), interrupted.
void run_on_slurm(const WorkPlan &plan, const SlurmOptions &options);

} // namespace voxshell
