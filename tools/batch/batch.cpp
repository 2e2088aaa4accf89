// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch.hpp"

#include "batch/assembly.hpp"
#include "batch/manifest.hpp"
#include "batch/scheduler.hpp"
#include "pipeline/estimate.hpp"
#include "pipeline/output.hpp"
#include "voxshell/format/pointshell.h"
#include "voxshell/format/voxmap.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <set>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

constexpr const char *manifest_name = "manifest.json", *assembly_name = "assembly.json",
                     *work_folder = ".voxshell-work";

/// What is converted once, and all places where it is wanted.
struct Job {
    std::vector<std::size_t> parts;   ///< indices into BatchResult::parts; the first is its name in messages
    const BatchInput *file = nullptr; ///< a whole file
    std::shared_ptr<const Scene> assembly; ///< else the scene, and
    AssemblyPart part;                     ///< which of its parts
    double weight = 0;                     ///< about the work: bytes of the file, triangles of the part
};

class Batch {
  public:
    Batch(const BatchOptions &o, const BatchWatch &watch)
        : o_(o), watch_(watch), cache_(o.cache), manifest_path_(o.output / manifest_name),
          before_(Manifest::read(manifest_path_)),
          budget_(o.part.max_memory ? o.part.max_memory : machine_memory()),
          progress_(make_progress(ProgressMode::never, true))
    {
    }

    BatchResult run(const std::vector<BatchInput> &inputs)
    {
        for (const BatchInput &input : inputs) {
            progress_->check();
            plan(input);
        }
        if (watch_.begin) watch_.begin(result_.parts.size());
        for (const BatchPart &part : result_.parts)
            if (part.state == PartState::failed && watch_.done) watch_.done(part, 0);
        std::vector<double> weights;
        for (const Job &job : jobs_) weights.push_back(job.weight);
        if (o_.shard) {
            work_on(*o_.shard, weights);
            return finished();
        }
        if (o_.fill) fill_elsewhere(weights);
        each_heaviest_first(weights, o_.jobs, [&](std::size_t n) { work(jobs_[n]); });
        for (const Plan &assembly : assemblies_) write(assembly);
        write_manifest();
        if (o_.cache_limit) cache_.shrink(o_.cache_limit);
        return finished();
    }

  private:
    BatchResult finished()
    {
        for (const BatchPart &part : result_.parts)
            if (part.failure) result_.worst = std::max(result_.worst, part.failure->code);
        return std::move(result_);
    }

    WorkPlan work_plan() const
    {
        Sha256Stream all;
        for (const Sha256 &key : keys_) all.update(key);
        WorkPlan plan;
        plan.hash = hex(all.digest()).substr(0, 16);
        plan.folder = o_.output / work_folder / plan.hash;
        plan.parts = jobs_.size();
        return plan;
    }

    /// Parts take turns, the heaviest first: shards are of about the same weight.
    void work_on(const Shard &shard, const std::vector<double> &weights)
    {
        const WorkPlan plan = work_plan();
        if (plan.hash != shard.hash)
            throw Failure(ExitCode::system, plan.folder.string(),
                          "the inputs are not those that the work was planned for");
        const std::vector<std::size_t> order = heaviest_first(weights);
        std::vector<std::size_t> mine;
        std::vector<double> of_mine;
        for (std::size_t n = shard.index; n < order.size(); n += shard.of) {
            mine.push_back(order[n]);
            of_mine.push_back(weights[order[n]]);
        }
        each_heaviest_first(of_mine, o_.jobs, [&](std::size_t n) { work(jobs_[mine[n]]); });
        Outputs outputs(true);
        outputs.add(plan.done(shard.index, shard.of), std::string());
        outputs.commit();
    }

    void fill_elsewhere(const std::vector<double> &weights)
    {
        WorkPlan plan = work_plan();
        const std::vector<std::size_t> order = heaviest_first(weights);
        json parts = json::array();
        for (const std::size_t n : order) {
            if (!cache_.find(keys_[n])) missing_.insert(n);
            parts.push_back({{"name", result_.parts[jobs_[n].parts[0]].name},
                             {"key", hex(keys_[n])},
                             {"missing", missing_.count(n) > 0}});
        }
        plan.missing = missing_.size();
        if (plan.missing == 0) return;
        const json out = {{"schema", "voxshell-work/1"}, {"version", tool_version()}, {"parts", parts}};
        Outputs outputs(true);
        outputs.add(plan.folder / "plan.json",
                    out.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
        outputs.commit();
        o_.fill(plan);
        std::error_code ignored;
        fs::remove_all(plan.folder, ignored);
        fs::remove(plan.folder.parent_path(), ignored); // unless there is other work in it
    }

    struct Plan {
        fs::path input;
        std::string name;
        Sha256 source;
        Assembly assembly;
        std::size_t first; ///< of its parts in the result
    };

    /// What a result depends on: the geometry, what was asked for, and who makes it.
    Sha256 key(const Sha256 &geometry, const BatchInput *file) const
    {
        json options = o_.effective;
        if (!file || !file->stl) options["unit"] = nullptr; // it is in metres
        const json text = {{"version", tool_version()},
                           {"formats",
                            {VXS_VOXMAP_VERSION_MAJOR, VXS_VOXMAP_VERSION_MINOR, VXS_POINTSHELL_VERSION_MAJOR,
                             VXS_POINTSHELL_VERSION_MINOR}},
                           {"geometry", hex(geometry)},
                           {"of", file ? "file" : "part"},
                           {"options", options}};
        const std::string bytes = text.dump();
        return sha256({reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size()});
    }

    void plan(const BatchInput &input)
    {
        try {
            if (o_.per_part) {
                plan_assembly(input);
                return;
            }
            Sha256 source{};
            if (input.stl) {
                const std::optional<Sha256> hash = hash_of_file(input.path);
                if (!hash) throw Failure(ExitCode::system, "", "cannot read");
                source = *hash;
            } else {
                source = import_scene(input.path, import(input)).source_hash; // with what it refers to
            }
            std::error_code ignored;
            add(input, input.name, source, source,
                {{}, &input, {}, {}, static_cast<double>(fs::file_size(input.path, ignored))});
        } catch (...) {
            const Failure failure = current_failure();
            if (failure.code == ExitCode::interrupted) throw;
            BatchPart part{input.path, input.name};
            part.state = PartState::failed;
            part.failure = failure;
            if (part.failure->file.empty()) part.failure->file = input.path.string();
            result_.parts.push_back(std::move(part));
            failed_ = true;
        }
    }

    void plan_assembly(const BatchInput &input)
    {
        const auto scene =
            std::make_shared<const Scene>(split_solids(import_scene(input.path, import(input))));
        Plan all{input.path, input.name, scene->source_hash, assemble(*scene), result_.parts.size()};
        for (const AssemblyPart &part : all.assembly.parts)
            add(input, input.name + "/" + part.name, scene->source_hash, part.hash,
                {{}, nullptr, scene, part, static_cast<double>(scene->meshes[part.mesh].triangles.size())});
        assemblies_.push_back(std::move(all));
    }

    ImportOptions import(const BatchInput &input) const
    {
        ImportOptions import = o_.part.import;
        if (!input.stl) import.unit.reset();
        return import;
    }

    void add(const BatchInput &input, const std::string &name, const Sha256 &source, const Sha256 &geometry,
             Job job)
    {
        const std::size_t index = result_.parts.size();
        BatchPart part{input.path, name};
        part.input_hash = source;
        result_.parts.push_back(std::move(part));
        const auto [known, is_new] = job_of_.try_emplace(key(geometry, job.file), jobs_.size());
        if (is_new) {
            keys_.push_back(known->first);
            jobs_.push_back(std::move(job));
        }
        jobs_[known->second].parts.push_back(index);
    }

    void work(Job &job)
    {
        const auto begin = std::chrono::steady_clock::now();
        {
            const std::lock_guard lock(mutex_);
            if (failed_ && o_.fail_fast) return;
        }
        progress_->check();
        const Sha256 &made = keys_[static_cast<std::size_t>(&job - jobs_.data())];
        std::optional<Failure> failure;
        std::optional<Cache::Entry> entry;
        bool built = false;
        try {
            entry = cache_.find(made);
            if (!entry) {
                entry = convert(job, made);
                built = true;
            }
            built |=
                missing_.count(static_cast<std::size_t>(&job - jobs_.data())) > 0; // elsewhere, in this run
        } catch (...) {
            failure = current_failure();
            if (failure->code == ExitCode::interrupted) throw;
        }
        job.assembly.reset(); // the last part of an assembly lets go of its meshes
        for (const std::size_t index : job.parts) {
            BatchPart part = result_.parts[index];
            if (entry && o_.shard) {
                part.state = built ? PartState::built : PartState::cached;
            } else if (entry) {
                try {
                    part.about = entry->about.dump(-1, ' ', false, json::error_handler_t::replace);
                    part.state = place(*entry, part) ? PartState::cached : PartState::up_to_date;
                    if (built) part.state = PartState::built;
                } catch (...) {
                    failure = current_failure();
                }
            }
            if (failure) {
                part.state = PartState::failed;
                part.failure = failure;
                if (part.failure->file.empty())
                    part.failure->file = job.file ? part.input.string()
                                                  : fmt::format("{} ({})", part.input.string(), part.name);
            }
            built = false; // the others of the same geometry are not built again
            const std::lock_guard lock(mutex_);
            failed_ |= part.failure.has_value();
            result_.parts[index] = std::move(part);
            const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
            if (watch_.done) watch_.done(result_.parts[index], spent.count());
        }
    }

    Cache::Entry convert(const Job &job, const Sha256 &made)
    {
        const Scene scene =
            job.file ? import_scene(job.file->path, import(*job.file)) : part_scene(*job.assembly, job.part);
        PartOptions options = o_.part;
        options.max_memory = budget_.total();
        options.import = job.file ? import(*job.file) : ImportOptions{};
        std::optional<MemoryBudget::Share> share; // until the files are written
        options.admit = [&](double bytes) { share.emplace(budget_, static_cast<std::uint64_t>(bytes)); };
        const Part part = convert_part(scene, options, *progress_);
        json about = watch_.describe ? watch_.describe(part) : json::object();
        about["warnings"] = json::array();
        for (const Warning &warning : part.warnings)
            about["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
        return cache_.put(made, about,
                          {{"vdb", part.vdb}, {"voxmap", part.voxmap}, {"pointshell", part.pointshell}});
    }

    /// Puts the entry's files where the part's results belong; whether any was not there.
    bool place(const Cache::Entry &entry, BatchPart &part)
    {
        Outputs outputs(o_.force);
        bool any = false;
        for (const Cache::File &file : entry.files) {
            const std::string name = part.name + "." + file.name;
            const fs::path target = o_.output / name;
            const auto mine = before_.files.find(name);
            any |= outputs.link(file.path, target, [&] {
                if (mine == before_.files.end()) return false;
                const std::optional<Sha256> now = hash_of_file(target);
                return now && hex(*now) == mine->second.sha256;
            });
            part.files.push_back({file.name, file.bytes, file.sha256, target});
        }
        outputs.commit();
        return any;
    }

    void write(const Plan &plan)
    {
        json parts = json::array(), instances = json::array();
        for (std::size_t n = 0; n < plan.assembly.parts.size(); ++n) {
            const AssemblyPart &part = plan.assembly.parts[n];
            const BatchPart &made = result_.parts[plan.first + n];
            json files = json::object();
            for (const Cache::File &file : made.files)
                files[file.name] = {{"path", made.files.empty() ? "" : file.path.filename().string()},
                                    {"sha256", file.sha256}};
            parts.push_back({{"name", part.name},
                             {"geometry_sha256", hex(part.hash)},
                             {"shape", part.shape},
                             {"instances", part.instances},
                             {"files", files},
                             {"failed", made.failure ? json(made.failure->what()) : json(nullptr)}});
        }
        for (const AssemblyInstance &each : plan.assembly.instances)
            instances.push_back({{"name", each.name},
                                 {"part", each.part},
                                 {"position_m", each.position},
                                 {"orientation_wxyz", each.orientation}});
        const json out = {
            {"schema", "voxshell-assembly/1"},
            {"version", tool_version()},
            {"name", plan.name},
            {"source", {{"path", plan.input.filename().string()}, {"sha256", hex(plan.source)}}},
            {"pose_error_m", plan.assembly.pose_error},
            {"parts", parts},
            {"instances", instances}};
        const std::string text = out.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
        const fs::path path = o_.output / plan.name / assembly_name;
        Outputs outputs(true); // it says what is there now, whatever was
        outputs.add(path, text);
        outputs.commit();
        result_.assemblies.push_back(
            {plan.input, path, plan.assembly.parts.size(), plan.assembly.instances.size(), text.size(),
             hex(sha256({reinterpret_cast<const std::uint8_t *>(text.data()), text.size()}))});
    }

    /// What was made here before and is still there stays in it.
    void write_manifest()
    {
        Manifest now;
        std::error_code ignored;
        for (const auto &[name, file] : before_.files)
            if (fs::exists(o_.output / name, ignored)) now.files[name] = file;
        for (const BatchPart &part : result_.parts)
            for (const Cache::File &file : part.files)
                now.files[part.name + "." + file.name] = {file.bytes, file.sha256};
        for (const BatchAssembly &each : result_.assemblies)
            now.files[each.file.lexically_relative(o_.output).generic_string()] = {each.bytes, each.sha256};
        Outputs outputs(true);
        outputs.add(manifest_path_, now.text());
        outputs.commit();
    }

    const BatchOptions &o_;
    const BatchWatch &watch_;
    Cache cache_;
    const fs::path manifest_path_;
    const Manifest before_;
    MemoryBudget budget_;
    std::unique_ptr<Progress> progress_;
    std::vector<Job> jobs_;
    std::vector<Sha256> keys_; ///< of the jobs
    std::map<Sha256, std::size_t> job_of_;
    std::set<std::size_t>
        missing_; ///< jobs whose results the cache did not have, where it is filled elsewhere
    std::vector<Plan> assemblies_;
    std::mutex mutex_; ///< of result_ while there is work, and of failed_
    bool failed_ = false;
    BatchResult result_;
};

} // namespace

fs::path WorkPlan::done(unsigned shard, unsigned of) const
{
    return folder / fmt::format("{}-of-{}.done", shard, of);
}

const char *name_of(PartState state)
{
    constexpr const char *names[] = {"built", "from the cache", "up to date", "failed", "not begun"};
    return names[static_cast<std::size_t>(state)];
}

std::size_t BatchResult::count(PartState state) const
{
    return static_cast<std::size_t>(std::count_if(
        parts.begin(), parts.end(), [&](const BatchPart &part) { return part.state == state; }));
}

BatchResult run_batch(const std::vector<BatchInput> &inputs, const BatchOptions &options,
                      const BatchWatch &watch)
{
    return Batch(options, watch).run(inputs);
}

} // namespace voxshell
