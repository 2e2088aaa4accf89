// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell convert: each input to NAME.vdb, NAME.voxmap and NAME.pointshell. Of a scene, what stands becomes
// the cells and what moves the points, and all that its servo needs besides NAME.plan.
#include "cli/explain_assets.hpp"
#include "cli/foreseen.hpp"
#include "cli/part_options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "pipeline/choose_voxel.hpp"
#include "pipeline/convert_scene.hpp"
#include "pipeline/depfile.hpp"
#include "pipeline/estimate.hpp"
#include "pipeline/output.hpp"
#include "plan/scene_plan.hpp"
#include "scene/example_scene.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include <unistd.h>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

struct ConvertOptions : SharedOptions, PartChoice {
    std::vector<std::string> inputs;
    std::string folder;
    bool explain = false;
};

/// What an input is, decided by its ending alone.
struct Input {
    fs::path path;
    const FileFormat *format; ///< none: a scene
    std::string name;         ///< of its outputs
};

Input input_of(const std::string &text)
{
    const fs::path path(text);
    std::string name = path.filename().string();
    const std::size_t dot = name.rfind('.');
    const std::string ending = dot == std::string::npos ? "" : name.substr(dot);
    if (dot != std::string::npos) name.resize(dot);
    std::error_code ignored;
    if (fs::is_directory(path, ignored))
        throw Failure(ExitCode::system, text,
                      "is a folder; name the files in it, or give it to voxshell batch");
    if (name.empty()) throw Failure(ExitCode::usage, text, "has no name before its ending");
    if (is_scene(path)) return {path, nullptr, scene_name(path)};
    if (const FileFormat *format = format_of(path)) return {path, format, name};
    throw Failure(
        ExitCode::unsupported, text,
        ending.empty()
            ? fmt::format("has no ending; {}, .scene.json, .scene.gltf or .scene.glb is needed{}",
                          import_endings(), meant_scene(path))
            : fmt::format(
                  "the ending '{}' is not one of {}, .scene.json; save the part as one of these where "
                  "it was made",
                  ending, import_endings()));
}

std::vector<Input> inputs_of(const ConvertOptions &o)
{
    std::vector<Input> inputs;
    std::map<std::string, std::string> names;
    bool lacks_unit = false;
    for (const std::string &text : o.inputs) {
        inputs.push_back(input_of(text));
        const Input &input = inputs.back();
        const auto [other, is_new] = names.emplace(input.name, text);
        if (!is_new)
            throw Failure(ExitCode::usage, text,
                          fmt::format("and {} would both write {}.voxmap", other->second, input.name));
        if (!input.format || input.format->has_unit) continue;
        lacks_unit = true;
        if (o.unit.empty())
            throw Failure(ExitCode::usage, text, "an STL file has no unit; say --unit mm (or cm, m, in)");
    }
    const auto is_scene = [](const Input &input) { return !input.format; };
    if (o.voxel == 0 && !o.voxel_auto && !std::all_of(inputs.begin(), inputs.end(), is_scene))
        throw Failure(ExitCode::usage, "", "--voxel is required, as in --voxel 0.5mm or --voxel auto");
    if ((o.voxel != 0 || o.voxel_auto || o.up != "y") && std::any_of(inputs.begin(), inputs.end(), is_scene))
        throw Failure(ExitCode::usage, "", "--voxel and --up: not for a scene, it says these itself");
    if (!o.unit.empty() && !lacks_unit)
        throw Failure(ExitCode::usage, "", "--unit: only for STL, glTF is in metres");
    return inputs;
}

/// Refuses now what could not be written after minutes of work.
void check_writable(const fs::path &path)
{
    fs::path at = path.empty() ? fs::path(".") : path;
    std::error_code ignored;
    while (!fs::exists(at, ignored) && at.has_parent_path() && at != at.parent_path()) at = at.parent_path();
    if (!fs::exists(at, ignored)) at = ".";
    if (!fs::is_directory(at)) throw Failure(ExitCode::system, at.string(), "is not a folder");
    if (access(at.c_str(), W_OK | X_OK) != 0)
        throw Failure(ExitCode::system, at.string(), "no permission to write here");
}

class Convert {
  public:
    explicit Convert(const ConvertOptions &o)
        : o_(o), progress_(make_progress(o.progress, o.quiet)), report_(o.reproducible)
    {
    }

    ExitCode run()
    {
        const std::vector<Input> inputs = inputs_of(o_);
        part_options_ = part_options(o_, o_);
        check_writable(o_.folder);
        if (!o_.report.empty()) check_writable(fs::path(o_.report).parent_path());
        if (!o_.depfile.empty()) check_writable(fs::path(o_.depfile).parent_path());
        json effective = part_options_json(o_, o_);
        report_.options(effective);
        ExitCode worst = ExitCode::ok;
        for (const Input &input : inputs) {
            try {
                o_.dry_run ? foresee(input) : convert(input);
            } catch (...) {
                Failure failure = current_failure();
                if (failure.file.empty() && failure.code != ExitCode::interrupted)
                    failure.file = input.path.string();
                if (failure.code == ExitCode::interrupted) throw failure;
                report_.failed(input.path, failure);
                worst = std::max(worst, failure.code);
                tell_failure("convert", failure);
            }
        }
        progress_.reset();
        if (o_.dry_run) {
            if (o_.json) fmt::print("{}", json_text(foreseen_));
            return worst;
        }
        if (!o_.depfile.empty()) depfile_.write(o_.depfile);
        if (o_.voxel_auto && chosen_.size() == 1) effective["voxel_m"] = *chosen_.begin();
        report_.options(effective);
        const std::string text = report_.text();
        if (!o_.report.empty())
            write_report(o_.report, o_.force, [&](const Outputs::Sink &sink) { sink(text); });
        if (o_.json) fmt::print("{}", text);
        return worst;
    }

  private:
    Scene read(const Input &input)
    {
        progress_->stage("read", 0);
        ImportOptions import = import_options(input);
        Scene scene = import_scene(input.path, import);
        scene.name = input.name;
        progress_->check();
        return scene;
    }

    ImportOptions import_options(const Input &input) const
    {
        ImportOptions import;
        if (input.format && !input.format->has_unit) import.unit = parse_unit(o_.unit);
        import.z_up = o_.up == "z";
        return import;
    }

    void convert(const Input &input)
    {
        PartOptions options = part_options_;
        options.import = import_options(input);
        if (input.format) {
            Scene scene = read(input);
            const Part part = convert_part(std::move(scene), options, *progress_); // leaves hash and files
            chosen_.insert(part.voxel);
            write(input, part.voxel, {{input.path.filename().string(), scene.source_hash, part}}, scene.files,
                  part.vdb, part.voxmap, part.pointshell);
            return;
        }
        const SceneFile scene = read_scene(input.path);
        check_scene(scene);
        const SceneGeometry geometry = read_geometry(scene);
        const SceneParts parts = convert_scene(scene, geometry, options, *progress_);
        const Bytes plan = plan_of(scene, geometry, parts);
        std::vector<Made> made{{parts.statics.name, geometry.statics.source_hash, parts.statics},
                               {parts.dynamic.name, geometry.dynamic.source_hash, parts.dynamic}};
        std::vector<std::pair<std::string, const Bytes *>> more{{".plan", &plan}};
        for (std::size_t n = 0; n < parts.moving.size(); ++n) {
            made.push_back({parts.moving[n].name, geometry.moving[n].source_hash, parts.moving[n]});
            more.emplace_back(moving_ending(n), &parts.moving[n].voxmap);
        }
        std::vector<fs::path> sources{input.path};
        for (const Scene *half : {&geometry.statics, &geometry.dynamic})
            sources.insert(sources.end(), half->files.begin(), half->files.end());
        for (const Scene &goes : geometry.moving)
            sources.insert(sources.end(), goes.files.begin(), goes.files.end());
        write(input, scene.voxel, made, sources, parts.statics.vdb, parts.statics.voxmap,
              parts.dynamic.pointshell, more);
        if (!o_.explain || o_.json) return;
        fmt::print("why each byte is there:\n");
        explain_asset(scene, input.name + ".voxmap", parts.statics.voxmap);
        for (std::size_t n = 0; n < parts.moving.size(); ++n)
            explain_asset(scene, input.name + moving_ending(n), parts.moving[n].voxmap);
        explain_asset(scene, input.name + ".pointshell", parts.dynamic.pointshell);
        explain_asset(scene, input.name + ".plan", plan);
        fmt::print("  {:<24}      {:>12} bytes  people and other programs: no run reads it\n",
                   input.name + ".vdb", format_count(parts.statics.vdb.size()));
    }

    using Bytes = std::vector<std::uint8_t>;
    struct Made {
        std::string label;
        const Sha256 &source;
        const Part &part;
    };

    void write(const Input &input, double voxel, const std::vector<Made> &made,
               const std::vector<fs::path> &sources, const Bytes &vdb, const Bytes &voxmap,
               const Bytes &pointshell, const std::vector<std::pair<std::string, const Bytes *>> &more = {})
    {
        Outputs outputs(o_.force);
        const fs::path base = fs::path(o_.folder) / input.name;
        std::vector<std::pair<std::string, const Bytes *>> files{
            {".vdb", &vdb}, {".voxmap", &voxmap}, {".pointshell", &pointshell}};
        files.insert(files.end(), more.begin(), more.end());
        for (const auto &[ending, bytes] : files)
            outputs.add(base.string() + ending, *bytes, progress_.get());
        progress_->check(); // the last chance: from here on the files are there
        outputs.commit();
        std::vector<fs::path> targets;
        for (const auto &[ending, bytes] : files) targets.push_back(base.string() + ending);
        depfile_.add(targets, sources);

        for (const auto &[label, source, part] : made) {
            report_.input(input.path, source);
            report_.part(part, voxel);
            warn(input, part.warnings);
            if (!o_.json) tell(label, part, voxel);
        }
        for (const auto &[ending, bytes] : files) report_.output(base.string() + ending, *bytes);
        std::string wrote;
        for (const auto &[ending, bytes] : files)
            wrote += fmt::format("{}{} ({})", wrote.empty() ? base.string() : ", ", ending,
                                 format_size(bytes->size()));
        if (!o_.json) fmt::print("  wrote   {}\n", wrote);
        std::fflush(stdout);
    }

    void tell(const std::string &label, const Part &part, double voxel) const
    {
        std::string solid =
            part.mesh.closed ? fmt::format("closed, {:.6g} cm3", part.mesh.volume * 1e6) : "open";
        fmt::print("{}: {} triangles, {}, {:.6g} cm2\n", label, format_count(part.mesh.triangles), solid,
                   part.mesh.area * 1e4);
        tell_mesh(part);
        fmt::print("  cells   {} surface, {} interior of {}\n", format_count(part.surface_cells),
                   format_count(part.interior_cells), format_length(voxel));
        tell_points(part);
    }

    /// What is worth a line: all of it if asked, else what is out of the ordinary.
    void tell_mesh(const Part &part) const
    {
        const MeshReport &mesh = part.mesh;
        if (!part.voxel_why.empty())
            fmt::print("  voxel   {}: {}\n", format_length(part.voxel), part.voxel_why);
        std::string said;
        const auto count = [&](std::uint64_t n, const char *what) {
            if (n || o_.inspect_mesh)
                said += fmt::format("{}{} {}", said.empty() ? "" : ", ", format_count(n), what);
        };
        count(mesh.boundary_edges, "boundary edges");
        count(mesh.non_manifold_edges, "non-manifold edges");
        count(mesh.badly_wound_edges, "badly wound edges");
        count(mesh.duplicate, "duplicates");
        count(mesh.degenerate, "without area");
        count(part.orient.flipped, "turned");
        count(part.self_intersections.value_or(0),
              part.self_intersections ? "cut others" : "cut others (not checked)");
        if (part.stitch.vertices || o_.weld > 0)
            said += fmt::format("{}{} edges closed by moving {} vertices at most {}",
                                said.empty() ? "" : ", ", format_count(part.stitch.closed_edges),
                                format_count(part.stitch.vertices), format_length(part.stitch.farthest));
        if (!said.empty()) fmt::print("  mesh    {} shells: {}\n", format_count(mesh.shells), said);
        const Thickness &walls = part.thickness;
        const bool thin = walls.share_below(wall_of(3, part.voxel)) > 0.01;
        if (!o_.inspect_mesh && !o_.voxel_auto && !thin) return;
        if (!walls.meaningful()) {
            if (o_.inspect_mesh) fmt::print("  walls   no interior that could be measured\n");
            return;
        }
        std::string shares;
        for (const double voxels : thickness_classes)
            shares += fmt::format("{}{:.3g} % below {:g}", shares.empty() ? "" : ", ",
                                  100 * walls.share_below(wall_of(voxels, part.voxel)), voxels);
        fmt::print("  walls   99 % at least {}, half at least {}; thinnest {} at ({:.6g}, {:.6g}, {:.6g}) m; "
                   "{} voxels\n",
                   format_length(walls.quantile(0.01)), format_length(walls.quantile(0.5)),
                   format_length(walls.thinnest), walls.thinnest_at[0], walls.thinnest_at[1],
                   walls.thinnest_at[2], shares);
    }

    void foresee(const Input &input)
    {
        if (input.format) {
            foresee(input, input.path.filename().string(), read(input), o_.voxel);
            return;
        }
        const SceneFile scene = read_scene(input.path);
        check_scene(scene);
        const SceneGeometry geometry = read_geometry(scene);
        foresee(input, input.name + "/static", geometry.statics, scene.voxel);
        for (const Scene &goes : geometry.moving) foresee(input, input.name + "/moving", goes, scene.voxel);
        foresee(input, input.name + "/dynamic", geometry.dynamic, scene.voxel);
    }

    void foresee(const Input &input, const std::string &label, const Scene &scene, double voxel)
    {
        PartOptions options = part_options_;
        options.voxel = voxel;
        warn(input, scene.warnings);
        const Foreseen foreseen = voxshell::foresee(scene, options, *progress_);
        foreseen_["estimates"].push_back(foreseen_json(!input.format ? label : input.name, foreseen));
        if (!o_.json) tell_foreseen(label, foreseen);
    }

    void warn(const Input &input, const std::vector<Warning> &warnings)
    {
        for (const Warning &warning : warnings) {
            report_.warning({warning.code, input.name + ": " + warning.message});
            if (!o_.quiet) tell_warning("convert", input.path.string(), warning);
        }
    }

    const ConvertOptions &o_;
    PartOptions part_options_;
    std::unique_ptr<Progress> progress_;
    RunReport report_;
    Depfile depfile_;
    std::set<double> chosen_; ///< voxels of the parts [m]
    json foreseen_ = {
        {"schema", "voxshell-estimate/1"}, {"version", tool_version()}, {"estimates", json::array()}};
};

} // namespace

VerbAction add_convert(CLI::App &verb)
{
    auto o = std::make_shared<ConvertOptions>();
    verb.add_option("INPUT", o->inputs,
                    "parts: .stl, .gltf, .glb, and scenes: .scene.json, .scene.gltf, .scene.glb; each makes "
                    "NAME.vdb, .voxmap, .pointshell, and a scene NAME.plan")
        ->required();
    verb.add_flag("--explain", o->explain,
                  "of a scene: each section of its files with its bytes, and what reads it");
    verb.add_flag_callback(
            "--example-scene",
            [] {
                fmt::print("{}", example_scene());
                throw CLI::Success();
            },
            "print a scene with a comment on all that it can say, and end")
        ->trigger_on_parse();
    verb.add_option("-o,--output", o->folder, "folder of the results, made if it is not there")
        ->required()
        ->type_name("DIR");
    add_part_options(verb, *o);
    add_shared(verb, *o,
               {Shared::unit, Shared::jobs, Shared::max_memory, Shared::dry_run, Shared::strict,
                Shared::force, Shared::format, Shared::report, Shared::reproducible, Shared::progress,
                Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        return Convert(*o).run();
    };
}

} // namespace voxshell
