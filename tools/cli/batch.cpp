// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell batch: folders, lists and assemblies, each distinct part once.
#include "batch/batch.hpp"
#include "batch/archive.hpp"
#include "batch/slurm.hpp"
#include "cli/batch_report.hpp"
#include "cli/part_options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "pipeline/depfile.hpp"
#include "pipeline/estimate.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <thread>

#include <unistd.h>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

struct BatchChoice : SharedOptions, PartChoice {
    std::vector<std::string> inputs;
    std::string list, folder, cache, cache_size, executor = "local", shard, archive;
    std::vector<std::string> sbatch;
    unsigned shards = 8;
    bool per_part = false, fail_fast = false, retry_failed = false;
};

/// One file a line; empty lines and those that begin with # are none. Relative to the list's own folder.
void add_list(const std::string &list, std::vector<std::string> &inputs)
{
    std::ifstream file(list);
    if (!file) throw Failure(ExitCode::system, list, "cannot read");
    for (std::string line; std::getline(file, line);) {
        while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
        if (line.empty() || line[0] == '#') continue;
        const fs::path path(line);
        inputs.push_back(path.is_absolute() ? line : (fs::path(list).parent_path() / path).string());
    }
}

/// On stderr, one part after another.
class Watch {
  public:
    explicit Watch(const BatchChoice &o)
        : json_(o.progress == ProgressMode::json),
          line_(!json_ && (o.progress == ProgressMode::always ||
                           (o.progress == ProgressMode::automatic && !o.quiet && isatty(STDERR_FILENO))))
    {
    }

    void begin(std::size_t parts)
    {
        parts_ = parts;
        began_ = std::chrono::steady_clock::now();
    }

    void done(const BatchPart &part, double seconds)
    {
        ++done_;
        const std::uint64_t bytes = part.bytes();
        bytes_ += bytes;
        if (line_) fmt::print(stderr, "\r\033[K");
        if (part.failure && part.remembered)
            tell_failure("batch",
                         {part.failure->code, part.failure->file,
                          std::string(part.failure->what()) + " (as before; --retry-failed tries again)"});
        else if (part.failure)
            tell_failure("batch", *part.failure);
        if (json_)
            fmt::print(stderr, "{}\n",
                       json{{"part", part.name},
                            {"state", name_of(part.state)},
                            {"seconds", seconds},
                            {"bytes", bytes},
                            {"done", done_},
                            {"total", parts_},
                            {"seconds_left", seconds_left()}}
                           .dump(-1, ' ', false, json::error_handler_t::replace));
        if (!line_) return;
        fmt::print(stderr, "{}/{} parts, {}, {:.0f} s left  {}", done_, parts_, format_size(bytes_),
                   seconds_left(), part.name);
        std::fflush(stderr);
        if (done_ == parts_) fmt::print(stderr, "\r\033[K");
    }

  private:
    double seconds_left() const
    {
        const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - began_;
        return spent.count() / static_cast<double>(done_) * static_cast<double>(parts_ - done_);
    }

    bool json_, line_;
    std::size_t parts_ = 0, done_ = 0;
    std::uint64_t bytes_ = 0;
    std::chrono::steady_clock::time_point began_{};
};

/// This program's own arguments, less what is for the one that submits.
std::vector<std::string> own_command()
{
    std::ifstream file("/proc/self/cmdline", std::ios::binary);
    std::vector<std::string> all;
    for (std::string word; std::getline(file, word, '\0');) all.push_back(word);
    std::vector<std::string> kept{fs::read_symlink("/proc/self/exe").string()};
    for (std::size_t n = 1; n < all.size(); ++n) {
        const std::string name = all[n].substr(0, all[n].find('='));
        if (name == "--executor" || name == "--shards" || name == "--sbatch" || name == "--report" ||
            name == "--format" || name == "--progress" || name == "--depfile" || name == "--archive") {
            if (name == all[n]) ++n; // its value is the next word
            continue;
        }
        kept.push_back(all[n]);
    }
    return kept;
}

/// "3/8:0123456789abcdef"
Shard parse_shard(const std::string &text)
{
    Shard shard;
    char hash[17] = "";
    int end = 0;
    if (std::sscanf(text.c_str(), "%u/%u:%16[0-9a-f]%n", &shard.index, &shard.of, hash, &end) != 3 ||
        text.size() != static_cast<std::size_t>(end) || shard.index >= shard.of)
        throw Failure(ExitCode::usage, "", fmt::format("--shard: '{}' is not K/N:HASH", text));
    shard.hash = hash;
    return shard;
}

ExitCode run(const BatchChoice &o)
{
    std::vector<std::string> named = o.inputs;
    BatchInputs all; // of a shard: they are in its plan
    if (o.shard.empty()) {
        if (!o.list.empty()) add_list(o.list, named);
        all = batch_inputs(named);
    }
    const std::vector<BatchInput> &inputs = all.files;
    if (!o.archive.empty()) check_archive_name(o.archive);
    if (o.voxel == 0 && !o.voxel_auto)
        throw Failure(ExitCode::usage, "", "--voxel is required, as in --voxel 0.5mm or --voxel auto");
    const bool lacks_unit = std::any_of(inputs.begin(), inputs.end(),
                                        [](const BatchInput &input) { return !input.format->has_unit; });
    if (lacks_unit && o.unit.empty())
        throw Failure(ExitCode::usage, "", "an STL file has no unit; say --unit mm (or cm, m, in)");

    BatchOptions options;
    options.part = part_options(o, o);
    options.part.import.z_up = o.up == "z";
    if (!o.unit.empty()) options.part.import.unit = parse_unit(o.unit);
    json effective = part_options_json(o, o);
    options.effective = effective;
    options.effective.erase("max_memory_bytes");
    if (o.voxel_auto) // the only choice that memory has a part in
        options.effective["memory_for_auto"] = o.max_memory.value_or(machine_memory());
    options.per_part = o.per_part;
    options.fail_fast = o.fail_fast;
    options.force = o.force;
    options.jobs = o.jobs;
    options.output = o.folder;
    options.list_sources = !o.depfile.empty();
    options.keep_about = o.json || !o.report.empty();
    options.retry_failed = o.retry_failed;
    options.dry_run = o.dry_run;
    const char *shared = std::getenv("VOXSHELL_CACHE");
    options.cache = !o.cache.empty()    ? fs::path(o.cache)
                    : shared && *shared ? fs::path(shared)
                                        : fs::path(o.folder) / ".voxshell-cache";
    if (!o.cache_size.empty()) options.cache_limit = parse_size(o.cache_size);

    if (!o.shard.empty()) options.shard = parse_shard(o.shard);
    if (o.executor == "slurm")
        options.fill = [&](const WorkPlan &plan) {
            const auto most = static_cast<unsigned>(std::min<std::size_t>(o.shards, plan.missing));
            run_on_slurm(plan, {own_command(), o.sbatch, most, 3, [&](const std::string &line) {
                                    if (!o.quiet) fmt::print(stderr, "voxshell batch: {}\n", line);
                                }});
        };

    const auto begin = std::chrono::steady_clock::now();
    Watch told(o);
    const BatchResult result =
        run_batch(inputs, options,
                  {[&](std::size_t parts) { told.begin(parts); },
                   [&](const BatchPart &part, double seconds) { told.done(part, seconds); },
                   [](const Part &part) {
                       json described = part_json(part, part.voxel);
                       described.erase("name"); // of the first place that it was made for
                       return described;
                   }});

    if (o.dry_run) {
        tell_dry_run(result, o.jobs ? o.jobs : std::max(1u, std::thread::hardware_concurrency()), o.json);
        return result.worst;
    }
    if (!o.shard.empty()) return result.worst;
    if (!result.unstored.empty() && !o.quiet)
        tell_warning("batch", options.cache.string(), {"", "results are not stored: " + result.unstored});
    if (!o.archive.empty()) {
        const std::unique_ptr<Progress> progress = make_progress(ProgressMode::never, true);
        write_archive(options.output, o.archive, o.force, *progress);
    }
    if (!o.depfile.empty()) {
        std::vector<fs::path> sources(all.folders.begin(), all.folders.end());
        if (!o.list.empty()) sources.push_back(o.list);
        sources.insert(sources.end(), result.sources.begin(), result.sources.end());
        Depfile depfile;
        depfile.add({options.output / "manifest.json"}, sources);
        depfile.write(o.depfile, result.worst == ExitCode::ok);
    }
    effective["per_part"] = o.per_part;
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
    const BatchReport report{inputs, result, options.output, effective, o.reproducible, spent.count()};
    if (!o.report.empty())
        write_report(o.report, o.force, [&](const Outputs::Sink &sink) { report.write(sink); });
    if (o.json)
        report.write([](std::string_view text) { fmt::print("{}", text); });
    else if (!o.quiet)
        fmt::print("{}\n", tally(result));
    return result.worst;
}

} // namespace

VerbAction add_batch(CLI::App &verb)
{
    auto o = std::make_shared<BatchChoice>();
    verb.add_option("INPUT", o->inputs, "folders with .stl, .gltf and .glb below them, and such files");
    verb.add_option("--filelist", o->list, "a file that names inputs, one a line, relative to its own folder")
        ->type_name("FILE");
    verb.add_option("-o,--output", o->folder,
                    "folder of the results and of manifest.json, made if it is not there")
        ->required()
        ->type_name("DIR");
    verb.add_flag(
        "--per-part", o->per_part,
        "a glTF, and an STL of several solids, is an assembly: each distinct part once, NAME/assembly.json "
        "says where each stands");
    verb.add_option("--cache", o->cache,
                    "results under what they were made of, for all runs and machines that share the folder "
                    "(default: $VOXSHELL_CACHE, or DIR/.voxshell-cache)")
        ->type_name("DIR");
    verb.add_option("--cache-size", o->cache_size,
                    "then drop what was unused for longest until the cache is no larger")
        ->type_name("SIZE");
    verb.add_option(
            "--archive", o->archive,
            "then also write the results as one file, NAME.tar.zst or NAME.tar: the same bytes each time")
        ->type_name("FILE");
    verb.add_option("--executor", o->executor,
                    "where parts are converted: local, or slurm: an array job fills the cache, which all its "
                    "nodes must see, as DIR and the inputs (default local)")
        ->check(CLI::IsMember({"local", "slurm"}))
        ->type_name("WHERE");
    verb.add_option("--shards", o->shards, "tasks of the array job (default 8; 1 to 10000)")
        ->check(CLI::Range(1u, 10000u))
        ->type_name("N");
    verb.add_option("--sbatch", o->sbatch, "one more argument for sbatch, as --sbatch=--partition=night")
        ->expected(1)
        ->take_all()
        ->type_name("ARG");
    verb.add_option("--shard", o->shard, "what such a task is called with: K/N:HASH")->type_name("SHARD");
    verb.add_flag("--fail-fast", o->fail_fast, "end at the first part that fails (default: go on)");
    verb.add_flag("--retry-failed", o->retry_failed,
                  "try again what failed by its geometry before (default: say so again)");
    add_part_options(verb, *o);
    std::string of_parts = "of each part, as voxshell convert --help tells:";
    for (const char *name : {"--close-gaps", "--weld", "--inspect-mesh", "--shell", "--shell-spacing",
                             "--thin-shell", "--channels"}) {
        verb.get_option(name)->group("");
        of_parts += std::string(" ") + name;
    }
    verb.get_option("--shard")->group(""); // the program itself says it
    verb.footer(of_parts);
    add_shared(verb, *o,
               {Shared::unit, Shared::jobs, Shared::max_memory, Shared::dry_run, Shared::strict,
                Shared::force, Shared::format, Shared::report, Shared::reproducible, Shared::progress,
                Shared::quiet});
    return [o] { return run(*o); };
}

} // namespace voxshell
