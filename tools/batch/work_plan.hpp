// SPDX-License-Identifier: GPL-3.0-or-later
// The plan of work as a file, from which the machines of a cluster take their shares.
#pragma once

#include "container/container.hpp"

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace voxshell {

/// One conversion: a whole file, or a part of an assembly.
struct WorkItem {
    struct OfAssembly {
        std::string name; ///< its own
        std::uint32_t mesh = 0;
        std::array<double, 9> shape{}; ///< as AssemblyPart has them
    };
    std::string name, input; ///< as the command line has it
    Sha256 source{};         ///< of the input and what it refers to
    Sha256 geometry{};       ///< of the part
    Sha256 key{};            ///< in the cache
    std::optional<OfAssembly> part;
    bool missing = true; ///< in the cache when the plan was made
};

/// All parts of a batch in the order in which shards take turns at them, the heaviest first: shards are of
/// about the same weight.
struct WorkPlan {
    std::string hash;             ///< 16 digits, of all keys in order
    std::filesystem::path folder; ///< DIR/.voxshell-work/HASH, with plan.json
    std::size_t parts = 0;        ///< distinct ones
    std::size_t missing = 0;      ///< in the cache
    /// The file that a shard leaves when it is through.
    std::filesystem::path done(unsigned shard, unsigned of) const;
    std::filesystem::path file() const { return folder / "plan.json"; }
};

struct Shard {
    unsigned index = 0, of = 1;
    std::string hash; ///< of the plan that it is a shard of
};

/// Collects the keys of a plan, in order.
class WorkHash {
  public:
    void add(const Sha256 &key) { stream_.update(key); }
    std::string digits() { return hex(stream_.digest()).substr(0, 16); }

  private:
    Sha256Stream stream_;
};

/// Writes plan.file(); `item(n)` for each n below plan.parts. Throws Failure(system).
void write_work(const WorkPlan &plan, const std::function<WorkItem(std::size_t)> &item);

/// Each missing part of the shard, in order. Throws Failure: system (it is not there, was made by another
/// version), invalid (it is not the plan of that hash).
void read_work(const std::filesystem::path &output, const Shard &shard,
               const std::function<void(const WorkItem &)> &take);

/// DIR/.voxshell-work/HASH.
std::filesystem::path work_folder(const std::filesystem::path &output, const std::string &hash);

} // namespace voxshell
