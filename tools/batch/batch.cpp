// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch.hpp"

#include "batch/batch_jobs.hpp"
#include "batch/manifest.hpp"
#include "batch/scheduler.hpp"
#include "pipeline/output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <set>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

constexpr const char *manifest_name = "manifest.json", *assembly_name = "assembly.json";
constexpr std::uint32_t none = Job::none;

/// A result on its way to where it belongs.
struct Made {
    Cache::Entry entry;
    std::optional<Part> unstored; ///< where the cache has not taken it
    std::string unstored_why;
    std::unique_ptr<MemoryBudget::Share> share; ///< while it is only in memory
    bool built = false;
};

class Batch {
  public:
    Batch(const std::vector<BatchInput> &inputs, const BatchOptions &o, const BatchWatch &watch)
        : o_(o), watch_(watch), cache_(o.cache, o.dry_run), manifest_path_(o.output / manifest_name),
          all_(inputs, o, result_), progress_(make_progress(ProgressMode::never, true))
    {
    }

    BatchResult run()
    {
        if (o_.shard) {
            read_work(o_.output, *o_.shard, [&](const WorkItem &item) { all_.take(item); });
            prepare();
            each_heaviest_first(all_.weights(), o_.jobs, [&](std::size_t n) { work(all_.jobs[n]); });
            finish_shard();
            return finished();
        }
        result_.inputs.resize(all_.inputs.size());
        before_ = Manifest::read(manifest_path_);
        for (std::uint32_t n = 0; n < all_.inputs.size(); ++n) {
            progress_->check();
            all_.plan(n);
        }
        all_.forget_keys();
        prepare();
        if (o_.dry_run) {
            each_heaviest_first(all_.weights(), o_.jobs, [&](std::size_t n) { foresee(all_.jobs[n]); });
            std::sort(result_.foreseen.begin(), result_.foreseen.end(),
                      [](const auto &a, const auto &b) { return a.first < b.first; });
            return finished();
        }
        if (o_.fill) fill_elsewhere();
        each_heaviest_first(all_.weights(), o_.jobs, [&](std::size_t n) { work(all_.jobs[n]); });
        for (PlannedAssembly &each : all_.assemblies)
            if (!each.is_written) write(each);
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

    /// All parts are known.
    void prepare()
    {
        budget_.emplace(all_.memory - std::min(all_.memory / 2, all_.shelf.bytes()));
        if (watch_.begin) watch_.begin(result_.parts.size());
        for (const BatchPart &part : result_.parts) {
            failed_ |= part.state == PartState::failed;
            if (part.state == PartState::failed && watch_.done) watch_.done(part, 0);
        }
    }

    // Work elsewhere

    void fill_elsewhere()
    {
        WorkPlan plan;
        WorkHash hash;
        const std::vector<std::size_t> order = heaviest_first(all_.weights());
        for (const std::size_t n : order) {
            hash.add(all_.jobs[n].key);
            if (!find(all_.jobs[n])) missing_.insert(n);
        }
        plan.hash = hash.digits();
        plan.folder = work_folder(o_.output, plan.hash);
        plan.parts = all_.jobs.size();
        plan.missing = missing_.size();
        if (plan.missing == 0) return;
        write_work(plan, [&](std::size_t n) {
            return all_.item_of(all_.jobs[order[n]], missing_.count(order[n]) > 0);
        });
        o_.fill(plan);
        std::error_code ignored;
        fs::remove_all(plan.folder, ignored);
        fs::remove(plan.folder.parent_path(), ignored); // unless there is other work in it
    }

    void finish_shard()
    {
        WorkPlan plan;
        plan.folder = work_folder(o_.output, o_.shard->hash);
        Outputs outputs(true);
        outputs.add(plan.done(o_.shard->index, o_.shard->of), std::string());
        outputs.commit();
    }

    // The work

    /// In the cache: a result, or why there is none (in `about`) that holds here and now.
    std::optional<Cache::Entry> find(const Job &job, bool made_in_this_run = false)
    {
        std::optional<Cache::Entry> entry = cache_.find(job.key);
        if (!entry || !entry->about.contains("failure")) return entry;
        const json &memory = entry->about["failure"]["memory_bytes"];
        const bool holds = memory.is_null() || memory == all_.memory;
        if (!holds || (o_.retry_failed && !made_in_this_run)) return {};
        return entry;
    }

    Made convert(const Job &job)
    {
        Scene scene = all_.scene_of(job);
        PartOptions options = all_.options_of(job);
        Made made;
        options.admit = [&](double bytes) {
            made.share = std::make_unique<MemoryBudget::Share>(*budget_, static_cast<std::uint64_t>(bytes));
        };
        Part part = convert_part(std::move(scene), options, *progress_);
        json about = watch_.describe ? watch_.describe(part) : json::object();
        about["warnings"] = json::array();
        for (const Warning &warning : part.warnings)
            about["warnings"].push_back({{"code", warning.code}, {"message", warning.message}});
        made.built = true;
        try {
            cache_.forget(job.key); // a failure of before
            made.entry =
                cache_.put(job.key, about,
                           {{"vdb", part.vdb}, {"voxmap", part.voxmap}, {"pointshell", part.pointshell}});
            made.share.reset();
        } catch (const Failure &failure) {
            if (failure.code != ExitCode::system || o_.shard) throw;
            made.entry.about = about;
            made.unstored = std::move(part);
            made.unstored_why = failure.what();
        }
        return made;
    }

    /// What fails by its geometry and options fails again; what lacks a disk does not.
    void remember(const Job &job, const Failure &failure)
    {
        const bool by_memory = failure.code == ExitCode::requirement;
        if (!by_memory && failure.code != ExitCode::invalid && failure.code != ExitCode::unsupported) return;
        try {
            cache_.forget(job.key);
            cache_.put(job.key,
                       {{"failure",
                         {{"code", static_cast<int>(failure.code)},
                          {"message", failure.what()},
                          {"memory_bytes", by_memory ? json(all_.memory) : json(nullptr)}}}},
                       {});
        } catch (const Failure &) { // it will be tried again
        }
    }

    void work(const Job &job)
    {
        const auto begin = std::chrono::steady_clock::now();
        {
            const std::lock_guard lock(mutex_);
            if (failed_ && o_.fail_fast) return;
        }
        progress_->check();
        const bool filled = missing_.count(static_cast<std::size_t>(&job - all_.jobs.data())) > 0;
        Made made;
        std::optional<Failure> failure;
        bool remembered = false;
        try {
            if (auto entry = find(job, filled)) {
                made.entry = std::move(*entry);
                made.built = filled; // elsewhere, in this run
                if (made.entry.about.contains("failure")) {
                    const json &why = made.entry.about["failure"];
                    failure.emplace(static_cast<ExitCode>(why["code"].get<int>()), "",
                                    why["message"].get<std::string>());
                    remembered = !filled;
                }
            } else {
                try {
                    made = convert(job);
                } catch (...) {
                    failure = current_failure();
                    if (failure->code == ExitCode::interrupted) throw;
                    remember(job, *failure);
                    failure->file.clear(); // of this place; each has its own
                }
            }
        } catch (...) {
            failure = current_failure();
            if (failure->code == ExitCode::interrupted) throw;
        }
        for (std::uint32_t index = job.first; index != none; index = all_.next[index]) {
            finish(job, result_.parts[index], made, failure, remembered);
            made.built = false; // the others of the same geometry are not built again
            const std::lock_guard lock(mutex_);
            BatchPart &part = result_.parts[index];
            failed_ |= part.failure != nullptr;
            if (o_.keep_about && !part.failure) result_.put_about(part, made.entry.about);
            if (part.has_files && made.unstored) result_.unstored = made.unstored_why;
            const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
            if (watch_.done) watch_.done(part, spent.count());
        }
        close(job);
    }

    /// One of the places where a result is wanted.
    void finish(const Job &job, BatchPart &part, Made &made, std::optional<Failure> failure, bool remembered)
    {
        if (!failure && o_.shard) {
            part.state = made.built ? PartState::built : PartState::cached;
        } else if (!failure) {
            try {
                const bool any = place(job, made, part);
                part.state = made.built ? PartState::built : any ? PartState::cached : PartState::up_to_date;
                part.has_files = true;
            } catch (...) {
                failure = current_failure();
                if (failure->code == ExitCode::interrupted) throw;
            }
        }
        if (!failure) return;
        part.state = PartState::failed;
        part.remembered = remembered;
        if (failure->file.empty()) {
            const std::string &path = all_.inputs[part.input].path;
            failure->file =
                o_.per_part || job.assembly != none ? fmt::format("{} ({})", path, part.name) : path;
        }
        part.failure = std::make_shared<const Failure>(*failure);
    }

    /// Puts the files where the part's results belong; whether any was not there.
    bool place(const Job &job, Made &made, BatchPart &part)
    {
        std::error_code error;
        if (!made.unstored && !fs::exists(made.entry.files.at(0).path, error))
            made = convert(job); // another program has made room in the cache meanwhile
        Outputs outputs(o_.force);
        bool any = made.unstored.has_value();
        for (std::size_t n = 0; n < asset_endings.size(); ++n) {
            const std::string name = part.file_name(n);
            const fs::path target = o_.output / name;
            const auto may_replace = [&] {
                const auto mine = before_.find(name);
                return mine && hash_of_file(target) == mine->sha256;
            };
            if (made.unstored) {
                const Part &bytes = *made.unstored;
                const std::vector<std::uint8_t> *all[] = {&bytes.vdb, &bytes.voxmap, &bytes.pointshell};
                outputs.add(target, *all[n], progress_.get(), may_replace);
                part.files[n] = {all[n]->size(), sha256(*all[n])};
            } else {
                const Cache::File &file = made.entry.files.at(n);
                any |= outputs.link(file.path, target, may_replace);
                part.files[n] = {file.bytes, file.sha256};
            }
        }
        outputs.commit();
        return any;
    }

    /// An assembly whose last part is done is written, and let go.
    void close(const Job &job)
    {
        std::vector<PlannedAssembly *> complete;
        {
            const std::lock_guard lock(mutex_);
            if (job.assembly != none && --all_.assemblies[job.assembly].jobs == 0) all_.shelf.drop(job.input);
            if (o_.shard || all_.assemblies.empty()) return;
            for (std::uint32_t index = job.first; index != none; index = all_.next[index]) {
                const auto after = std::upper_bound(
                    all_.assemblies.begin(), all_.assemblies.end(), index,
                    [](std::size_t part, const PlannedAssembly &each) { return part < each.first; });
                if (after != all_.assemblies.begin() && --std::prev(after)->left == 0)
                    complete.push_back(&*std::prev(after));
            }
        }
        for (PlannedAssembly *each : complete) try {
                write(*each);
            } catch (const Failure &failure) { // run() tries again when all else is done
                if (failure.code == ExitCode::interrupted) throw;
            }
    }

    void write(PlannedAssembly &planned)
    {
        AssemblyFile &file = planned.file;
        const fs::path path = o_.output / file.name / assembly_name;
        Sha256Stream hash;
        std::uint64_t bytes = 0;
        const std::span made(result_.parts.data() + planned.first, file.assembly.parts.size());
        const auto text = [&](const Outputs::Sink &sink) { file.write(made, sink); };
        text([&](std::string_view piece) {
            hash.update({reinterpret_cast<const std::uint8_t *>(piece.data()), piece.size()});
            bytes += piece.size();
        });
        write_file(path, text);
        result_.assemblies[static_cast<std::size_t>(&planned - all_.assemblies.data())] = {path, bytes,
                                                                                           hash.digest()};
        planned.is_written = true;
        file = {};
    }

    /// What was made here before and is still there stays in it.
    void write_manifest()
    {
        Manifest now;
        std::error_code ignored;
        for (std::size_t n = 0; n < before_.size(); ++n) {
            const Manifest::File file = before_[n];
            if (fs::exists(o_.output / file.path, ignored)) now.add(file.path, file.bytes, file.sha256);
        }
        for (const BatchPart &part : result_.parts)
            for (std::size_t n = 0; n < part.files.size() && part.has_files; ++n)
                now.add(part.file_name(n), part.files[n].bytes, part.files[n].sha256);
        for (const BatchAssembly &each : result_.assemblies)
            now.add(each.file.lexically_relative(o_.output).generic_string(), each.bytes, each.sha256);
        now.sort();
        write_file(manifest_path_, [&](const Outputs::Sink &sink) { now.write(sink); });
    }

    /// Says what is so now, whatever was there; not touched if it said that already.
    static void write_file(const fs::path &path, const std::function<void(const Outputs::Sink &)> &text)
    {
        std::ifstream there(path, std::ios::binary);
        bool same = there.is_open();
        std::string block;
        if (same)
            text([&](std::string_view piece) {
                block.resize(piece.size());
                if (same)
                    same = there.read(block.data(), static_cast<std::streamsize>(block.size())) &&
                           block == piece;
            });
        if (same && there.peek() == std::ifstream::traits_type::eof()) return;
        Outputs outputs(true);
        outputs.add_stream(path, text);
        outputs.commit();
    }

    // A dry run

    bool is_there(const Cache::Entry &entry, const BatchPart &part) const
    {
        for (std::size_t n = 0; n < asset_endings.size(); ++n) {
            const fs::path target = o_.output / part.file_name(n);
            std::error_code error;
            if (fs::file_size(target, error) != entry.files.at(n).bytes || error ||
                hash_of_file(target) != entry.files[n].sha256)
                return false;
        }
        return true;
    }

    void foresee(const Job &job)
    {
        progress_->check();
        std::optional<Cache::Entry> entry = find(job);
        std::optional<Failure> failure;
        std::optional<Foreseen> foreseen;
        if (entry && entry->about.contains("failure")) {
            const json &why = entry->about["failure"];
            failure.emplace(static_cast<ExitCode>(why["code"].get<int>()), "",
                            why["message"].get<std::string>());
        } else if (!entry) {
            try {
                foreseen = voxshell::foresee(all_.scene_of(job), all_.options_of(job), *progress_);
            } catch (...) {
                failure = current_failure();
                if (failure->code == ExitCode::interrupted) throw;
                failure->file.clear();
            }
        }
        Made made;
        for (std::uint32_t index = job.first; index != none; index = all_.next[index]) {
            BatchPart &part = result_.parts[index];
            const std::lock_guard lock(mutex_);
            if (failure)
                finish(job, part, made, failure, entry.has_value());
            else if (entry)
                part.state = is_there(*entry, part) ? PartState::up_to_date : PartState::cached;
            else
                part.state = index == job.first ? PartState::wanted : PartState::cached;
            if (part.state == PartState::wanted) result_.foreseen.emplace_back(index, *foreseen);
            if (watch_.done) watch_.done(part, 0);
        }
    }

    const BatchOptions &o_;
    const BatchWatch &watch_;
    Cache cache_;
    const fs::path manifest_path_;
    Manifest before_;
    BatchResult result_;
    BatchJobs all_;
    std::optional<MemoryBudget> budget_;
    std::unique_ptr<Progress> progress_;
    std::set<std::size_t>
        missing_;      ///< jobs whose results the cache did not have, where it is filled elsewhere
    std::mutex mutex_; ///< while there is work: of result_.foreseen and texts, assemblies, failed_, watch_
    bool failed_ = false;
};

} // namespace

const char *name_of(PartState state)
{
    constexpr const char *names[] = {"built",  "from the cache", "up to date",
                                     "failed", "not begun",      "to build"};
    return names[static_cast<std::size_t>(state)];
}

std::size_t BatchResult::count(PartState state) const
{
    return static_cast<std::size_t>(std::count_if(
        parts.begin(), parts.end(), [&](const BatchPart &part) { return part.state == state; }));
}

json BatchResult::about(const BatchPart &part) const
{
    return part.about == BatchPart{}.about ? json(nullptr) : json::parse(texts_->get(part.about));
}

void BatchResult::put_about(BatchPart &part, const json &about)
{
    part.about = texts_->put(about.dump(-1, ' ', false, json::error_handler_t::replace));
}

BatchResult run_batch(const std::vector<BatchInput> &inputs, const BatchOptions &options,
                      const BatchWatch &watch)
{
    return Batch(inputs, options, watch).run();
}

} // namespace voxshell
