// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell view: assets, meshes, a scene and what was recorded of it, as a page.
#include "cli/asset_facts.hpp"
#include "cli/asset_kind.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/scene_assets.hpp"
#include "cli/verb.hpp"
#include "import/point.hpp"
#include "mesh/report.hpp"
#include "pipeline/convert_scene.hpp"
#include "view/assembly_bodies.hpp"
#include "view/layers.hpp"
#include "view/page.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <memory>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::ordered_json;

struct ViewOptions : SharedOptions {
    std::vector<std::string> inputs;
    std::string output, assets, up = "y";
};

std::string ending_of(const fs::path &path)
{
    std::string ending = path.extension().string();
    std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
    return ending;
}

bool is_record(const fs::path &path)
{
    const std::string ending = ending_of(path);
    return ending == ".csv" || ending == ".rec";
}

json pose_json(const Pose &pose)
{
    const auto &p = pose.position;
    const auto &q = pose.rotation;
    return {p[0], p[1], p[2], q[0], q[1], q[2], q[3]};
}

/// "459.6 cm2", "133.3 cm3": metres to the power of `dimension`, in the unit that suits.
std::string format_measure(double value, int dimension)
{
    const double edge = std::pow(value, 1.0 / dimension);
    const auto [unit, name] =
        edge < 1e-2 ? std::pair{1e-3, "mm"} : std::pair{edge < 1 ? 1e-2 : 1.0, edge < 1 ? "cm" : "m"};
    return fmt::format("{:.5g} {}{}", value / std::pow(unit, dimension), name, dimension);
}

class View {
  public:
    explicit View(const ViewOptions &o) : o_(o), progress_(make_progress(o.progress, o.quiet)) {}

    ExitCode run()
    {
        if (ending_of(o_.output) != ".html")
            throw Failure(ExitCode::usage, o_.output, "a page's name ends in .html");
        // What moves it is read after what is moved: whatever order they were given in.
        for (const bool record : {false, true}) {
            for (const std::string &input : o_.inputs) {
                if (is_record(input) == record) add(input);
                progress_->check();
            }
        }
        if (bodies_.empty()) {
            throw Failure(ExitCode::usage, o_.inputs[0],
                          "a trace alone moves nothing: name the scene or the .pointshell that it is of too");
        }
        if (recorded_)
            move();
        else if (hand_)
            plan_to_move();
        const std::string title = fs::path(o_.inputs[0]).filename().string();
        json view = {{"title", title},
                     {"version", tool_version()},
                     {"bodies", bodies_},
                     {"figures", figures_},
                     {"recorded", recorded_json_}};
        return write(view);
    }

  private:
    void add(const fs::path &path)
    {
        progress_->stage("read", 0);
        if (is_record(path)) {
            if (recorded_) throw Failure(ExitCode::usage, path.string(), "one trace at a time");
            recorded_ = read_recorded(path, hand_ ? &*hand_ : nullptr);
        } else if (is_scene(path)) {
            add_scene(path);
        } else if (format_of(path)) {
            add_mesh(path);
        } else if (ending_of(path) == ".json") {
            add_assembly(path);
        } else if (asset_kind(path) == AssetKind::plan) {
            add_plan(path);
        } else {
            add_body(path.filename().string(), {path}, nullptr, "",
                     asset_kind(path) == AssetKind::pointshell);
        }
    }

    using Rows = std::vector<std::pair<std::string, std::string>>;
    void figures(const std::string &title, const std::string &says, Rows rows)
    {
        json table = json::array();
        for (const auto &[name, value] : rows) table.push_back(json::array({name, value}));
        figures_.push_back({{"title", title}, {"says", says}, {"rows", table}});
    }

    void asset_figures(const fs::path &path)
    {
        const AssetFacts facts = asset_facts(path);
        Rows rows;
        const auto number = [&](const char *name, const char *key) {
            if (facts.as_json.contains(key))
                rows.push_back({name, format_count(facts.as_json[key].get<std::uint64_t>())});
        };
        number("surface cells", "surface_cells");
        number("interior cells", "interior_cells");
        number("points", "points");
        if (facts.as_json.contains("voxel_m"))
            rows.push_back({"voxel", format_length(facts.as_json["voxel_m"].get<double>())});
        if (facts.as_json.contains("interior_cells") && facts.as_json["interior_cells"] != 0) {
            const double cell = std::pow(facts.as_json["voxel_m"].get<double>(), 3);
            const double inside = cell * facts.as_json["interior_cells"].get<double>();
            rows.push_back(
                {"volume",
                 fmt::format(
                     "{} to {}", format_measure(inside, 3),
                     format_measure(inside + cell * facts.as_json["surface_cells"].get<double>(), 3))});
        }
        if (facts.as_json.contains("bytes"))
            rows.push_back({"file", format_size(facts.as_json["bytes"].get<std::uint64_t>())});
        for (const AssetFacts::Row &row : facts.rows) {
            if (row.name != "meta") rows.push_back({row.name, row.value});
        }
        figures(path.filename().string(), facts.first, std::move(rows));
    }

    void mesh_figures(const std::string &title, const Mesh &mesh)
    {
        const MeshReport found = report(mesh);
        Rows rows = {{"triangles", format_count(found.triangles)},
                     {"shells", format_count(found.shells)},
                     {"mesh", found.closed ? "closed" : "open"},
                     {"area", format_measure(found.area, 2)}};
        if (found.closed) rows.push_back({"volume", format_measure(std::abs(found.volume), 3)});
        figures(title, "", std::move(rows));
    }

    /// Of one frame: cells, points and a mesh, as far as they are there.
    json &add_body(const std::string &name, const std::vector<fs::path> &assets, const Mesh *mesh,
                   const std::string &mesh_name, bool moves)
    {
        json body = {{"name", name}, {"moves", moves}};
        for (const fs::path &path : assets) {
            const AssetKind kind = asset_kind(path);
            if (kind == AssetKind::plan) throw Failure(ExitCode::invalid, path.string(), "is a plan");
            if (kind == AssetKind::pointshell)
                body["points"] = points_layer(read_pointshell(path), data_);
            else
                body["cells"] = cells_layer(read_cells(path, kind), data_);
            asset_figures(path);
            progress_->check();
        }
        if (mesh) {
            body["mesh"] = mesh_layer(*mesh, data_);
            mesh_figures(mesh_name, *mesh);
        }
        body["poses"] = json::array({pose_json({})});
        bodies_.push_back(std::move(body));
        return bodies_.back();
    }

    void add_mesh(const fs::path &path)
    {
        ImportOptions options;
        if (!format_of(path)->has_unit) {
            if (o_.unit.empty())
                throw Failure(ExitCode::usage, path.string(),
                              "an STL file has no unit; say --unit mm (or cm, m, in)");
            options.unit = parse_unit(o_.unit);
        }
        options.z_up = o_.up == "z";
        const Mesh mesh = flatten(import_scene(path, options));
        add_body(path.filename().string(), {}, &mesh, path.filename().string(), false);
    }

    void one_world(const fs::path &path)
    {
        if (world_) throw Failure(ExitCode::usage, path.string(), "one scene or plan at a time");
        world_ = true;
    }

    void add_scene(const fs::path &path)
    {
        one_world(path);
        const SceneFile scene = read_scene(path);
        const SceneGeometry geometry = read_geometry(scene);
        const SceneAssets assets(scene, o_.assets, o_.max_memory.value_or(0), *progress_);
        const std::vector<fs::path> paths = assets.paths();
        const Mesh statics = flatten(geometry.statics);
        add_body("what stands", {paths[0]}, &statics, "mesh of what stands", false);
        std::vector<const ScenePart *> moving;
        for (const ScenePart &part : scene.statics)
            if (!part.path.empty()) moving.push_back(&part);
        for (std::size_t n = 0; n < geometry.moving.size(); ++n) {
            const Mesh mesh = flatten(geometry.moving[n]);
            const std::string name = fmt::format("part on a path {}", n + 1);
            add_body(name, {paths[n + 1]}, &mesh, "mesh of " + name, false);
            ways_.push_back({bodies_.size() - 1, {}});
            for (const ScenePart::Stop &stop : moving[n]->path)
                ways_.back().stops.push_back({stop.t, stop.pose});
        }
        const Mesh dynamic = flatten(geometry.dynamic);
        add_body("what moves", {paths.back()}, &dynamic, "mesh of what moves", true);
        hand_ = scene.hand;
    }

    void add_plan(const fs::path &path)
    {
        one_world(path);
        const PlanFile plan = read_plan(path);
        const fs::path folder = o_.assets.empty() ? path.parent_path() : fs::path(o_.assets);
        for (std::size_t n = 0; n < plan.assets.size(); ++n) {
            const vxs_plan_asset &asset = plan.assets[n];
            const bool dynamic = asset.role == VXS_PLAN_ROLE_DYNAMIC;
            const fs::path file = folder / text_of(asset.name);
            const Sha256 found =
                AssetFile(file, dynamic ? VXS_ASSET_POINTSHELL : VXS_ASSET_VOXMAP).content_hash();
            if (!std::ranges::equal(found, asset.content_hash)) {
                throw Failure(ExitCode::invalid, path.string(),
                              fmt::format("was made for another {} than {}; convert the scene again",
                                          text_of(asset.name), file.string()));
            }
            add_body(text_of(asset.name), {file}, nullptr, "", dynamic);
            Way way{bodies_.size() - 1, {}};
            for (const vxs_plan_motion &move : plan.moves) {
                const auto &q = move.orientation;
                if (move.asset == n)
                    way.stops.push_back(
                        {move.time,
                         {{move.position[0], move.position[1], move.position[2]}, {q[1], q[2], q[3], q[0]}}});
            }
            if (!way.stops.empty()) ways_.push_back(std::move(way));
        }
        asset_figures(path);
        if (!plan.hand.empty()) hand_ = hand_of(plan.hand);
    }

    void add_assembly(const fs::path &path)
    {
        const AssemblyBodies assembly = read_assembly(path);
        figures(assembly.name,
                fmt::format("{} parts in {} places{}", format_count(assembly.parts.size()),
                            format_count(assembly.instances),
                            assembly.failed ? fmt::format(", {} without files", assembly.failed) : ""),
                {{"parts", format_count(assembly.parts.size())},
                 {"instances", format_count(assembly.instances)},
                 {"failed", format_count(assembly.failed)}});
        for (const AssemblyBodies::Part &part : assembly.parts) {
            progress_->check();
            if (part.poses.empty()) continue;
            json &body = add_body(part.name, part.assets, nullptr, "", false);
            body["poses"] = json::array();
            for (const Pose &pose : part.poses) body["poses"].push_back(pose_json(pose));
        }
    }

    /// Where what goes by itself is at the rows' times.
    void follow(const Recorded &recorded)
    {
        for (const Way &way : ways_) {
            std::vector<Pose> poses;
            for (const Moment &moment : recorded.rows) poses.push_back(on_the_way(way.stops, moment.t));
            bodies_[way.body]["track"] = track_layer(poses, data_);
        }
        recorded_json_ = recorded_layer(recorded, data_);
    }

    void plan_to_move()
    {
        double end = hand_->keyframes.back().t;
        for (const Way &way : ways_) end = std::max(end, way.stops.back().t);
        if (end > 0) follow(planned(*hand_, end));
    }

    void move()
    {
        const bool anything =
            std::ranges::any_of(bodies_, [](const json &body) { return body["moves"] == true; });
        if (!anything)
            throw Failure(ExitCode::usage, recorded_->source,
                          "moves a .pointshell: name the one that it is of, or the scene");
        follow(*recorded_);
        const auto &rows = recorded_->rows;
        const auto peak = [&](Point Moment::*force) {
            const auto most =
                std::ranges::max_element(rows, {}, [&](const Moment &m) { return length(m.*force); });
            return fmt::format("{:.4g} N at {:.4g} s", length((*most).*force), most->t);
        };
        const auto most = std::ranges::max_element(rows, {}, &Moment::contacts);
        Rows said = {
            {"rows", format_count(recorded_->of)},
            {"seconds", fmt::format("{:.6g}", rows.back().t - rows.front().t)},
            {"peak force of contact", peak(&Moment::collision_force)},
            {"peak force at the hand", peak(&Moment::output_force)},
            {"most points touching", fmt::format("{} at {:.4g} s", format_count(most->contacts), most->t)}};
        if (rows.size() < recorded_->of) said.push_back({"rows shown", format_count(rows.size())});
        figures(recorded_->source, "", std::move(said));
    }

    ExitCode write(const json &view)
    {
        std::uint64_t size = 0;
        Sha256Stream hash;
        Outputs outputs(o_.force);
        progress_->stage("write", 0);
        const auto write_to = [&](const Outputs::Sink &sink) {
            write_page(view, data_, [&](std::string_view piece) {
                progress_->check();
                size += piece.size();
                hash.update({reinterpret_cast<const std::uint8_t *>(piece.data()), piece.size()});
                sink(piece);
            });
        };
        if (o_.dry_run)
            write_to([](std::string_view) {});
        else
            outputs.add_stream(o_.output, write_to);
        outputs.commit();
        const Sha256 digest = hash.digest();
        if (o_.json) {
            fmt::print("{}", json_text(told(size, digest)));
        } else if (!o_.quiet) {
            fmt::print("{}: {}, {}{}\n", o_.output, format_size(size),
                       bodies_.size() == 1 ? "1 body" : format_count(bodies_.size()) + " bodies",
                       o_.dry_run ? "; not written" : "");
        }
        return ExitCode::ok;
    }

    json told(std::uint64_t size, const Sha256 &digest) const
    {
        json out = {{"schema", "voxshell-view/1"},
                    {"version", tool_version()},
                    {"page", {{"path", o_.output}, {"bytes", size}, {"sha256", hex(digest)}}},
                    {"written", !o_.dry_run},
                    {"bodies", json::array()},
                    {"recorded", nullptr}};
        for (const json &body : bodies_) {
            json one = {
                {"name", body["name"]}, {"moves", body["moves"]}, {"instances", body["poses"].size()}};
            if (body.contains("cells")) one["surface_cells"] = body["cells"]["surface_cells"];
            if (body.contains("points")) one["points"] = body["points"]["at"]["n"].get<std::size_t>() / 3;
            if (body.contains("mesh"))
                one["triangles"] = body["mesh"]["triangles"]["n"].get<std::size_t>() / 3;
            out["bodies"].push_back(one);
        }
        if (!recorded_json_.is_null()) {
            out["recorded"] = {{"source", recorded_json_["source"]},
                               {"rows", recorded_json_["rows"]},
                               {"of", recorded_json_["of"]}};
        }
        return out;
    }

    struct Way {
        std::size_t body;
        std::vector<Stop> stops;
    };
    const ViewOptions &o_;
    std::unique_ptr<Progress> progress_;
    PageData data_;
    json bodies_ = json::array(), figures_ = json::array(), recorded_json_;
    std::optional<Recorded> recorded_;
    std::optional<HandPath> hand_;
    std::vector<Way> ways_;
    bool world_ = false;
};

} // namespace

VerbAction add_view(CLI::App &verb)
{
    auto o = std::make_shared<ViewOptions>();
    verb.add_option("FILE", o->inputs,
                    "assets: .voxmap, .vdb, .pointshell; meshes: .stl, .gltf, .glb; a scene: .scene.json, "
                    ".scene.gltf, .scene.glb, a .plan with its assets beside it, an assembly.json; and a "
                    "trace or recording of simulate (.csv, .rec), which moves the scene's object or the "
                    ".pointshell")
        ->required();
    verb.add_option("-o,--output", o->output, "the page, which opens from disk and needs no other file")
        ->required()
        ->type_name("PAGE.html");
    verb.add_option("--assets", o->assets,
                    "folder with the scene's NAME.voxmap and NAME.pointshell (default: made for this page), "
                    "or with those that the plan names")
        ->type_name("DIR");
    verb.add_option("--up", o->up, "axis that points up in the mesh: y or z (default y)")
        ->check(CLI::IsMember({"y", "z"}));
    add_shared(verb, *o,
               {Shared::unit, Shared::jobs, Shared::max_memory, Shared::dry_run, Shared::force,
                Shared::format, Shared::progress, Shared::quiet});
    return [o] {
        const JobLimit jobs(o->jobs);
        return View(*o).run();
    };
}

} // namespace voxshell
