// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch has to convert: each distinct geometry once, and the places where it is wanted.
#pragma once

#include "batch/assembly_file.hpp"
#include "batch/batch.hpp"
#include "batch/scene_shelf.hpp"

#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace voxshell {

/// What is converted once. Its first part is its name in messages, the others follow by BatchJobs::next.
struct Job {
    static constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
    std::uint32_t first, last;          ///< indices into BatchResult::parts
    std::uint32_t input;                ///< the file, or the assembly
    std::uint32_t assembly = none;      ///< index into BatchJobs::assemblies; none: a whole file
    std::uint32_t part_of_assembly = 0; ///< index into its parts
    Sha256 key;                         ///< in the cache
    Sha256 geometry;                    ///< of the part
    double weight;                      ///< about the work: bytes of the file, triangles of the part
};

struct PlannedAssembly {
    AssemblyFile file;
    std::size_t first = 0, left = 0; ///< of its parts in the result; how many of them are to come
    std::size_t jobs = 0;            ///< that still want its scene
    bool is_written = false;         ///< as BatchResult::assemblies of the same index
};

class BatchJobs {
  public:
    /// Parts go into `result` as they are found.
    BatchJobs(const std::vector<BatchInput> &inputs, const BatchOptions &options, BatchResult &result);

    void plan(std::uint32_t input);         ///< all that the input wants; a bad one is a part that failed
    void forget_keys() { job_of_.clear(); } ///< when all is planned

    /// A part of the plan becomes a job of this shard. What the inputs are is in the plan too.
    void take(const WorkItem &item);
    WorkItem item_of(const Job &job, bool missing) const;

    std::vector<double> weights() const;
    const AssemblyPart &part_of(const Job &job) const;
    PartOptions options_of(const Job &job) const;
    Scene scene_of(const Job &job); ///< as the plan was made with it: Failure(system) if it is another

  private:
    std::vector<BatchInput> own_; ///< of a shard
    std::map<std::string, std::size_t> input_of_;

  public:
    const std::vector<BatchInput> &inputs;
    const std::uint64_t memory; ///< that all parts under work share [bytes]
    SceneShelf shelf;
    std::vector<Job> jobs;
    std::vector<std::uint32_t> next; ///< part of the same geometry, by index of the part
    std::vector<PlannedAssembly> assemblies;

  private:
    Sha256 key(const Sha256 &geometry, const BatchInput *file) const;
    ImportOptions import(const BatchInput &input) const;
    void note(const std::vector<std::filesystem::path> &files);
    Scene read_assembly(std::uint32_t number) const;
    void plan_assembly(std::uint32_t number);
    void add(const std::string &name, Job job);

    const BatchOptions &o_;
    BatchResult &result_;
    std::map<Sha256, std::uint32_t> job_of_;
};

} // namespace voxshell
