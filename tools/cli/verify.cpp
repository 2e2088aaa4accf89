// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell verify: is an asset what it says it is, and is it still what the mesh is?
#include "batch/batch.hpp"
#include "cli/asset_kind.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "pipeline/convert_scene.hpp"
#include "pipeline/verify_against.hpp"
#include "pipeline/verify_asset.hpp"
#include "pointshell/pointshell_file.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

struct VerifyOptions : SharedOptions {
    std::string path, against, up = "y";
    bool manifest = false;
};

/// The mesh to measure against: of a part the same for cells and points, of a scene what stands and what
/// moves.
struct Reference {
    Mesh cells, points;
    Sha256 cells_hash{}, points_hash{};
};

Reference read_reference(const VerifyOptions &o)
{
    const fs::path path(o.against);
    if (is_scene(path)) {
        const SceneGeometry geometry = read_geometry(read_scene(path));
        return {flatten(geometry.statics), flatten(geometry.dynamic), geometry.statics.source_hash,
                geometry.dynamic.source_hash};
    }
    ImportOptions import;
    if (!o.unit.empty()) import.unit = parse_unit(o.unit);
    import.z_up = o.up == "z";
    const Scene scene = import_scene(path, import);
    Mesh mesh = flatten(scene);
    return {mesh, mesh, scene.source_hash, scene.source_hash};
}

/// What META says of how the asset was made; nothing if it says nothing.
MadeWith made_with(const std::string &meta)
{
    const json all = json::parse(meta, nullptr, false);
    const json options = all.is_object() && all.contains("options") ? all["options"] : json();
    const auto number = [&](const char *key) {
        return options.is_object() && options.contains(key) && options[key].is_number()
                   ? options[key].get<double>()
                   : 0.0;
    };
    return {std::max(0.0, number("weld_m")), number("thin_shell_deg") > 0};
}

json as_json(const Measure &m)
{
    json j = {{"what", m.what},     {"unit", m.unit},     {"worst", m.worst},     {"bound", m.bound},
              {"places", m.places}, {"beyond", m.beyond}, {"binding", m.binding}, {"holds", m.holds()}};
    if (m.beyond) j["at_m"] = m.at;
    return j;
}

void print(const Measure &m)
{
    std::string line = fmt::format("  {}: {:.4g}", m.what, m.worst);
    if (m.unit != "1") line += " " + m.unit;
    line += fmt::format(" (bound {:.4g}, {} places)", m.bound, format_count(m.places));
    if (m.beyond)
        line += fmt::format("; beyond at {}, the worst at ({:.9g}, {:.9g}, {:.9g}) m", format_count(m.beyond),
                            m.at[0], m.at[1], m.at[2]);
    line += m.holds() ? m.binding ? "" : " - told only, the mesh is open" : " - DIFFERS";
    fmt::print("{}\n", line);
}

class Verify {
  public:
    explicit Verify(const VerifyOptions &o) : o_(o), progress_(make_progress(o.progress, o.quiet)) {}

    ExitCode run()
    {
        const bool folder = fs::is_directory(o_.path);
        if (o_.manifest) return shipped(folder ? fs::path(o_.path) / "manifest.json" : fs::path(o_.path));
        if (o_.against.empty() && (!o_.unit.empty() || o_.up != "y"))
            throw Failure(ExitCode::usage, "", "--unit and --up say how to read the mesh of --against");
        if (!o_.against.empty()) reference_ = read_reference(o_);
        const std::vector<fs::path> files = folder ? assets_in(o_.path) : std::vector<fs::path>{o_.path};
        for (const fs::path &file : files) guarded(file, [&] { verify(file); });
        for (const fs::path &file : files) {
            const fs::path twin = fs::path(file).replace_extension(".voxmap");
            if (folder && file.extension() == ".vdb" && fs::exists(twin) && ok_.count(file) &&
                ok_.count(twin))
                guarded(file, [&] { verify_twins(file, twin); });
        }
        progress_.reset();
        json_["ok"] = worst_ == ExitCode::ok;
        if (o_.json) fmt::print("{}", json_text(json_));
        return worst_;
    }

  private:
    /// What another machine has made, and nothing else: sizes and hashes, not the rules of the formats.
    ExitCode shipped(const fs::path &manifest)
    {
        std::uint64_t bytes = 0;
        for (const ManifestCheck &check : check_manifest(manifest)) {
            json entry = {{"path", check.path}, {"ok", check.fault.empty()}, {"bytes", check.bytes}};
            bytes += check.bytes;
            if (!check.fault.empty()) {
                entry["code"] = static_cast<int>(ExitCode::invalid);
                entry["message"] = check.fault;
                worst_ = ExitCode::invalid;
                tell_failure("verify", Failure(ExitCode::invalid,
                                               (manifest.parent_path() / check.path).string(), check.fault));
            }
            json_["files"].push_back(std::move(entry));
        }
        json_["ok"] = worst_ == ExitCode::ok;
        if (o_.json)
            fmt::print("{}", json_text(json_));
        else if (worst_ == ExitCode::ok)
            fmt::print("ok {} {} files, {}\n", manifest.string(), format_count(json_["files"].size()),
                       format_size(bytes));
        return worst_;
    }

    template<typename Work>
    void guarded(const fs::path &file, Work work)
    {
        try {
            work();
        } catch (...) {
            Failure failure = current_failure();
            if (failure.file.empty()) failure.file = file.string();
            if (failure.code == ExitCode::interrupted) throw failure;
            json_["files"].push_back({{"path", file.string()},
                                      {"ok", false},
                                      {"code", static_cast<int>(failure.code)},
                                      {"message", failure.what()}});
            worst_ = std::max(worst_, failure.code);
            tell_failure("verify", failure);
        }
    }

    void verify(const fs::path &path)
    {
        const AssetKind kind = asset_kind(path);
        const VerifiedAsset asset = verify_asset(path);
        ok_.insert(path);
        json entry = {{"path", path.string()}, {"ok", true}, {"kind", asset.kind}, {"bytes", asset.bytes}};
        if (!o_.json)
            fmt::print("ok {} {} {}, {}\n", path.string(), asset.kind, asset.summary,
                       format_size(asset.bytes));
        if (reference_ && kind != AssetKind::plan) {
            bool same_source = false;
            const std::vector<Measure> measures = measure(path, kind, same_source);
            entry["against"] = {
                {"path", o_.against}, {"same_source", same_source}, {"measures", json::array()}};
            for (const Measure &m : measures) {
                entry["against"]["measures"].push_back(as_json(m));
                if (!o_.json) print(m);
                if (m.holds()) continue;
                entry["ok"] = false;
                worst_ = std::max(worst_, ExitCode::differs);
            }
            if (!same_source && !o_.json)
                fmt::print("  note: made from another file than {} (or with other external buffers)\n",
                           o_.against);
        }
        std::fflush(stdout);
        json_["files"].push_back(std::move(entry));
    }

    std::vector<Measure> measure(const fs::path &path, AssetKind kind, bool &same_source)
    {
        if (kind == AssetKind::pointshell) {
            const PointshellFile file = read_pointshell(path);
            same_source = file.source_hash == reference_->points_hash;
            MadeWith made = made_with(file.meta);
            made.areas = file.areas;
            return verify_points(file.shell, reference_->points, made, *progress_);
        }
        const VoxmapFile file = read_cells(path, kind);
        same_source = file.source_hash == reference_->cells_hash;
        return verify_cells(file, reference_->cells, made_with(file.meta), *progress_);
    }

    const VerifyOptions &o_;
    std::unique_ptr<Progress> progress_;
    std::optional<Reference> reference_;
    std::set<fs::path> ok_;
    ExitCode worst_ = ExitCode::ok;
    json json_ = {
        {"schema", "voxshell-verify/1"}, {"version", tool_version()}, {"ok", true}, {"files", json::array()}};
};

} // namespace

VerbAction add_verify(CLI::App &verb)
{
    auto o = std::make_shared<VerifyOptions>();
    verb.add_option("FILE", o->path, ".voxmap, .pointshell, .plan or .vdb, or a folder with such files")
        ->required();
    verb.add_option("--against", o->against,
                    "measure cells and points again on this mesh (.stl .gltf .glb) or scene (.scene.json, "
                    ".scene.glb); "
                    "exit 6 if a bound does not hold")
        ->type_name("MESH");
    verb.add_option("--up", o->up, "axis that points up in the mesh: y or z (default y)")
        ->check(CLI::IsMember({"y", "z"}))
        ->type_name("AXIS");
    verb.add_flag("--manifest", o->manifest,
                  "FILE is the manifest.json of a batch, or its folder: are all files there, and the same?");
    add_shared(verb, *o, {Shared::unit, Shared::jobs, Shared::format, Shared::progress, Shared::quiet});
    return [o] {
        if (o->manifest && !o->against.empty())
            throw Failure(ExitCode::usage, "", "--manifest and --against: one at a time");
        const JobLimit jobs(o->jobs);
        return Verify(*o).run();
    };
}

} // namespace voxshell
