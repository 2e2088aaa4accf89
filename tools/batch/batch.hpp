// SPDX-License-Identifier: GPL-3.0-or-later
// Many parts to assets: each distinct one once, the rest from the cache or left as it is.
#pragma once

#include "batch/cache.hpp"
#include "cli/failure.hpp"
#include "pipeline/convert_part.hpp"

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

/// All parts of a batch in the order in which shards take turns at them: the same on every machine that sees
/// the same inputs and options.
struct WorkPlan {
    std::string hash;             ///< 16 digits, of all keys
    std::filesystem::path folder; ///< DIR/.voxshell-work/HASH, with plan.json
    std::size_t parts = 0;        ///< distinct ones
    std::size_t missing = 0;      ///< in the cache
    /// The file that a shard leaves when it is through.
    std::filesystem::path done(unsigned shard, unsigned of) const;
};

struct Shard {
    unsigned index = 0, of = 1;
    std::string hash; ///< of the plan that it is a shard of
};

struct BatchOptions {
    PartOptions part;                 ///< of every part; its `import.unit` is for STL only
    nlohmann::ordered_json effective; ///< all that makes a result what it is, for the key
    bool per_part = false;            ///< a file is an assembly: its parts one by one
    bool fail_fast = false;           ///< the first part that fails ends the work
    bool force = false;               ///< files that this did not make are overwritten
    unsigned jobs = 0;                ///< 0: one a core
    std::filesystem::path output, cache;
    std::uint64_t cache_limit = 0; ///< [bytes]; 0: none
    /// Called where parts are missing in the cache, to fill it elsewhere; what it leaves out is converted
    /// here.
    std::function<void(const WorkPlan &)> fill;
    std::optional<Shard> shard; ///< convert only these, into the cache and nothing else
};

struct BatchInput {
    std::filesystem::path path;
    std::string name; ///< of its results below the output folder, with '/': "gears/left"
    bool stl = false; ///< by its ending, of any case; else glTF
};

/// Files as they are named, folders with all .stl, .gltf and .glb below them (sorted, hidden ones left out).
/// Two that would write the same results are told apart by their ending ("a.stl", "a.glb"), else refused.
/// Throws Failure: system (cannot be read), usage (nothing to do, the same twice).
std::vector<BatchInput> batch_inputs(const std::vector<std::string> &arguments);

enum class PartState { built, cached, up_to_date, failed, not_begun };
const char *name_of(PartState state); ///< "built", "from the cache", ...

/// One conversion that was wanted, and what became of it.
struct BatchPart {
    std::filesystem::path input;
    std::string name; ///< "gears/left", "robot/arm"
    PartState state = PartState::not_begun;
    Sha256 input_hash{};              ///< of the file and what it refers to; zero if it could not be read
    std::string about{};              ///< JSON: as `describe` told, with "warnings"; text takes a fifth
    std::vector<Cache::File> files{}; ///< paths in the output folder
    std::optional<Failure> failure{};
};

struct BatchAssembly {
    std::filesystem::path input, file; ///< assembly.json in the output folder
    std::size_t parts = 0, instances = 0;
    std::uint64_t bytes = 0;
    std::string sha256;
};

struct BatchResult {
    std::vector<BatchPart> parts; ///< in the order of inputs, and of parts in their assembly
    std::vector<BatchAssembly> assemblies;
    std::size_t count(PartState state) const;
    ExitCode worst = ExitCode::ok;
};

/// What the work tells while it goes on, from any thread, one at a time.
struct BatchWatch {
    std::function<void(std::size_t parts)> begin;
    std::function<void(const BatchPart &part, double seconds)> done;
    std::function<nlohmann::ordered_json(const Part &part)> describe; ///< what the report says of a part
};

/// Makes NAME.vdb, NAME.voxmap, NAME.pointshell of each part below the output folder, NAME/assembly.json of
/// each assembly, and manifest.json of all files. A file that is there with other content is replaced if the
/// manifest says that it was made here, or with `force`. A part that fails is told and left out. Throws
/// Failure: system (the output folder, the cache), interrupted.
BatchResult run_batch(const std::vector<BatchInput> &inputs, const BatchOptions &options,
                      const BatchWatch &watch);

/// Files of a manifest against what is there.
struct ManifestCheck {
    std::string path; ///< as in the manifest
    std::uint64_t bytes = 0;
    std::string fault; ///< empty: it is the file that the manifest means
};
/// Throws Failure: system, invalid (not a manifest).
std::vector<ManifestCheck> check_manifest(const std::filesystem::path &manifest);

} // namespace voxshell
