// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch_jobs.hpp"

#include "container/file_hash.hpp"
#include "pipeline/estimate.hpp"
#include "voxshell/format/pointshell.h"
#include "voxshell/format/voxmap.h"

namespace voxshell {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

constexpr std::uint32_t none = Job::none;

BatchJobs::BatchJobs(const std::vector<BatchInput> &all, const BatchOptions &options, BatchResult &result)
    : inputs(options.shard ? own_ : all),
      memory(options.part.max_memory ? options.part.max_memory : machine_memory()), shelf(memory / 4),
      o_(options), result_(result)
{
}

std::vector<double> BatchJobs::weights() const
{
    std::vector<double> all;
    for (const Job &job : jobs) all.push_back(job.weight);
    return all;
}

/// What a result depends on: the geometry, what was asked for, and who makes it.
Sha256 BatchJobs::key(const Sha256 &geometry, const BatchInput *file) const
{
    json options = o_.effective;
    if (!file || file->format->has_unit) options["unit"] = nullptr; // it is in metres
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

ImportOptions BatchJobs::import(const BatchInput &input) const
{
    ImportOptions import = o_.part.import;
    if (input.format->has_unit) import.unit.reset();
    return import;
}

void BatchJobs::note(const std::vector<fs::path> &files)
{
    if (!o_.list_sources) return;
    for (const fs::path &file : files) result_.sources.push_back(file.string());
}

void BatchJobs::plan(std::uint32_t number)
{
    const BatchInput &input = inputs[number];
    try {
        if (o_.per_part) {
            plan_assembly(number);
            return;
        }
        Sha256 &source = result_.inputs[number];
        if (!input.format->refers) {
            const std::optional<Sha256> hash = hash_of_file(input.path);
            if (!hash) throw Failure(ExitCode::system, "", "cannot read");
            source = *hash;
            note({input.path});
        } else {
            const Scene scene = import_scene(input.path, import(input));
            source = scene.source_hash; // with what it refers to
            note(scene.files);
        }
        std::error_code ignored;
        add(input.name, {0, 0, number, none, 0, key(source, &input), source,
                         static_cast<double>(fs::file_size(input.path, ignored))});
    } catch (...) {
        Failure failure = current_failure();
        if (failure.code == ExitCode::interrupted) throw;
        BatchPart part;
        part.input = number;
        part.name = input.name;
        part.state = PartState::failed;
        if (failure.file.empty()) failure.file = input.path;
        part.failure = std::make_shared<const Failure>(failure);
        result_.parts.push_back(std::move(part));
        next.push_back(none);
        note({input.path});
    }
}

Scene BatchJobs::read_assembly(std::uint32_t number) const
{
    return split_solids(import_scene(inputs[number].path, import(inputs[number])));
}

void BatchJobs::plan_assembly(std::uint32_t number)
{
    const BatchInput &input = inputs[number];
    const auto scene = shelf.get(number, [&] { return read_assembly(number); });
    result_.inputs[number] = scene->source_hash;
    note(scene->files);
    Assembly assembly = assemble(*scene);
    const std::size_t first = result_.parts.size(), known = jobs.size();
    const auto index = static_cast<std::uint32_t>(assemblies.size());
    for (std::uint32_t n = 0; n < assembly.parts.size(); ++n) {
        const AssemblyPart &part = assembly.parts[n];
        add(input.name + "/" + part.name, {0, 0, number, index, n, key(part.hash, nullptr), part.hash,
                                           static_cast<double>(scene->meshes[part.mesh].triangles.size())});
    }
    const std::size_t parts = assembly.parts.size();
    assemblies.push_back(
        {{input.name, fs::path(input.path).filename().string(), scene->source_hash, std::move(assembly)},
         first,
         parts,
         jobs.size() - known});
    result_.assemblies.emplace_back();
    if (assemblies.back().jobs == 0) shelf.drop(number); // known from other assemblies
}

void BatchJobs::add(const std::string &name, Job job)
{
    const auto index = static_cast<std::uint32_t>(result_.parts.size());
    BatchPart part;
    part.input = job.input;
    part.name = name;
    result_.parts.push_back(std::move(part));
    next.push_back(none);
    const auto [known, is_new] = job_of_.try_emplace(job.key, jobs.size());
    if (is_new) {
        job.first = job.last = index;
        jobs.push_back(job);
    } else {
        Job &same = jobs[known->second];
        next[same.last] = index;
        same.last = index;
    }
}

WorkItem BatchJobs::item_of(const Job &job, bool missing) const
{
    WorkItem item{result_.parts[job.first].name,
                  inputs[job.input].path,
                  result_.inputs[job.input],
                  job.geometry,
                  job.key,
                  {},
                  missing};
    if (job.assembly != none) {
        const AssemblyPart &part = part_of(job);
        item.part = WorkItem::OfAssembly{part.name, part.mesh, part.shape};
    }
    return item;
}

void BatchJobs::take(const WorkItem &item)
{
    const auto [known, is_new] = input_of_.try_emplace(item.input, own_.size());
    const auto number = static_cast<std::uint32_t>(known->second);
    if (is_new) {
        own_.push_back({item.input, item.name, format_of(item.input)});
        if (!own_.back().format)
            throw Failure(ExitCode::invalid, item.input, "planned, but no importer reads it");
        result_.inputs.push_back(item.source);
        assemblies.emplace_back();
    }
    const BatchInput &input = own_[number];
    Job job{0, 0, number, none, 0, key(item.geometry, item.part ? nullptr : &input), item.geometry, 0};
    if (job.key != item.key)
        throw Failure(ExitCode::system, work_folder(o_.output, o_.shard->hash).string(),
                      "the work was planned with other options");
    if (item.part) {
        std::vector<AssemblyPart> &parts = assemblies[number].file.assembly.parts;
        job.assembly = number;
        job.part_of_assembly = static_cast<std::uint32_t>(parts.size());
        parts.push_back({item.part->name, item.part->mesh, item.part->shape, item.geometry, 0});
        ++assemblies[number].jobs;
    }
    job.weight = -static_cast<double>(jobs.size()); // in the plan's order
    add(item.name, job);
}

const AssemblyPart &BatchJobs::part_of(const Job &job) const
{
    return assemblies[job.assembly].file.assembly.parts[job.part_of_assembly];
}

Scene BatchJobs::scene_of(const Job &job)
{
    const BatchInput &input = inputs[job.input];
    std::shared_ptr<const Scene> assembly;
    Scene file;
    if (job.assembly == none)
        file = import_scene(input.path, import(input));
    else
        assembly = shelf.get(job.input, [&] { return read_assembly(job.input); });
    if ((assembly ? *assembly : file).source_hash != result_.inputs[job.input])
        throw Failure(ExitCode::system, input.path, "changed while the batch ran: run it again");
    return assembly ? part_scene(*assembly, part_of(job)) : std::move(file);
}

PartOptions BatchJobs::options_of(const Job &job) const
{
    PartOptions options = o_.part;
    options.max_memory = memory;
    options.import = job.assembly == none ? import(inputs[job.input]) : ImportOptions{};
    return options;
}

} // namespace voxshell
