// SPDX-License-Identifier: GPL-3.0-or-later
// Many parts to assets: each distinct one once, the rest from the cache or left as it is.
#pragma once

#include "batch/cache.hpp"
#include "batch/text_store.hpp"
#include "batch/work_plan.hpp"
#include "cli/failure.hpp"
#include "pipeline/convert_part.hpp"
#include "pipeline/foresee.hpp"

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

struct BatchOptions {
    PartOptions part;                 ///< of every part; its `import.unit` is for STL only
    nlohmann::ordered_json effective; ///< all that makes a result what it is, for the key
    bool per_part = false;            ///< a file is an assembly: its parts one by one
    bool fail_fast = false;           ///< the first part that fails ends the work
    bool retry_failed = false;        ///< what failed before is tried again
    bool force = false;               ///< files that this did not make are overwritten
    bool dry_run = false;             ///< nothing is written anywhere: what would be done
    unsigned jobs = 0;                ///< 0: one a core
    std::filesystem::path output, cache;
    std::uint64_t cache_limit = 0; ///< [bytes]; 0: none
    /// Called where parts are missing in the cache, to fill it elsewhere; what it leaves out is converted
    /// here.
    std::function<void(const WorkPlan &)> fill;
    std::optional<Shard> shard; ///< convert only these, into the cache and nothing else
    bool list_sources = false;  ///< BatchResult::sources is wanted
    bool keep_about = false;    ///< BatchResult::about() is wanted
};

struct BatchInput {
    std::string path;
    std::string name;         ///< of its results below the output folder, with '/': "gears/left"
    const FileFormat *format; ///< by its ending
};

struct BatchInputs {
    std::vector<BatchInput> files;
    std::vector<std::string> folders; ///< that were looked through: a file more there is a part more
};

/// Files as they are named, folders with all that importers read below them (sorted, hidden ones left out).
/// Two that would write the same results are told apart by their ending ("a.stl", "a.glb"), else refused.
/// Throws Failure: system (cannot be read), usage (nothing to do, the same twice).
BatchInputs batch_inputs(const std::vector<std::string> &arguments);

/// `wanted`: would be built, were it not a dry run.
enum class PartState : std::uint8_t { built, cached, up_to_date, failed, not_begun, wanted };
const char *name_of(PartState state); ///< "built", "from the cache", ...

/// Endings of a part's files, in the order of BatchPart::files.
inline constexpr std::array<const char *, 3> asset_endings{"vdb", "voxmap", "pointshell"};

/// One conversion that was wanted, and what became of it. There may be a million.
struct BatchPart {
    struct File {
        std::uint64_t bytes = 0;
        Sha256 sha256{};
    };
    std::uint32_t input = 0; ///< index of the input
    PartState state = PartState::not_begun;
    bool has_files = false;  ///< in the output folder: NAME.vdb, ...
    bool remembered = false; ///< failed in an earlier run and was not tried
    std::string name;        ///< "gears/left", "robot/arm"
    std::array<File, asset_endings.size()> files{};
    std::shared_ptr<const Failure> failure{};
    std::uint64_t about = ~std::uint64_t{0}; ///< for BatchResult::about()

    std::string file_name(std::size_t n) const { return name + "." + asset_endings[n]; }
    std::uint64_t bytes() const { return has_files ? files[0].bytes + files[1].bytes + files[2].bytes : 0; }
};

struct BatchAssembly {
    std::filesystem::path file; ///< assembly.json in the output folder
    std::uint64_t bytes = 0;
    Sha256 sha256{};
};

class BatchResult {
  public:
    std::vector<Sha256> inputs;   ///< hash of each and what it refers to; zero if it could not be read
    std::vector<BatchPart> parts; ///< in the order of inputs, and of parts in their assembly
    std::vector<BatchAssembly> assemblies;
    std::vector<std::pair<std::size_t, Foreseen>> foreseen; ///< of a dry run: parts that would be built
    std::vector<std::string> sources; ///< with `list_sources`: inputs and what they refer to
    std::string unstored;             ///< why results were not put into the cache; empty: they were
    ExitCode worst = ExitCode::ok;

    std::size_t count(PartState state) const;
    /// With `keep_about`: JSON, as `describe` told, with "warnings"; null if there is none.
    nlohmann::ordered_json about(const BatchPart &part) const;
    void put_about(BatchPart &part, const nlohmann::ordered_json &about);

  private:
    std::unique_ptr<TextStore> texts_ = std::make_unique<TextStore>();
};

/// What the work tells while it goes on, from any thread, one at a time.
struct BatchWatch {
    std::function<void(std::size_t parts)> begin;
    std::function<void(const BatchPart &part, double seconds)> done;
    std::function<nlohmann::ordered_json(const Part &part)> describe; ///< what the report says of a part
};

/// Makes NAME.vdb, NAME.voxmap, NAME.pointshell of each part below the output folder, NAME/assembly.json of
/// each assembly, and manifest.json of all files. A file that is there with other content is replaced if the
/// manifest says that it was made here, or with `force`. A part that fails is told and left out; where its
/// geometry, the options or the memory are the reason, it fails the same way without being tried until one of
/// these is another, or with `retry_failed`. Where the cache takes nothing (no room, no permission) results
/// go into the output folder all the same. Throws Failure: system (the output folder, the cache),
/// interrupted.
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
