// SPDX-License-Identifier: GPL-3.0-or-later
// voxshell bench: how long a tick's contact takes with these assets on this machine.
#include "cli/asset_kind.hpp"
#include "cli/options.hpp"
#include "cli/run_report.hpp"
#include "cli/verb.hpp"
#include "container/asset_file.hpp"
#include "study/contact_bench.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;

struct BenchOptions : SharedOptions {
    std::vector<std::string> files;
    std::uint64_t ticks = 2000;
};

struct Opened {
    std::string name;
    std::unique_ptr<AssetFile> file;
    vxs_voxmap map{};
    vxs_pointshell shell{};
};

class Bench {
  public:
    explicit Bench(const BenchOptions &o) : o_(o), progress_(make_progress(o.progress, o.quiet))
    {
        for (const std::string &path : o.files) open(path);
        if (maps_.empty() || shells_.empty())
            throw Failure(
                ExitCode::usage, "",
                "a tick needs what stands and what moves: give a .voxmap and a .pointshell at least");
    }

    ExitCode run()
    {
        for (const Opened &map : maps_)
            for (const Opened &shell : shells_) measure(map, shell);
        progress_.reset();
        if (o_.json) fmt::print("{}", json_text(json_));
        return ExitCode::ok;
    }

  private:
    void open(const std::string &path)
    {
        if (asset_kind(path) == AssetKind::vdb)
            throw Failure(ExitCode::usage, path,
                          "the servo loop does not read .vdb: voxshell pack makes a .voxmap of it");
        Opened asset{
            std::filesystem::path(path).filename().string(), std::make_unique<AssetFile>(path), {}, {}};
        const bool is_map = asset.file->asset().kind == VXS_ASSET_VOXMAP;
        const vxs_result result = is_map ? vxs_voxmap_open(&asset.file->asset(), &asset.map)
                                         : vxs_pointshell_open(&asset.file->asset(), &asset.shell);
        if (result != VXS_OK) throw Failure(ExitCode::bug, path, "a checked asset has no view");
        (is_map ? maps_ : shells_).push_back(std::move(asset));
    }

    void measure(const Opened &map, const Opened &shell)
    {
        const std::vector<ContactBench> runs = bench_contact(map.map, shell.shell, o_.ticks, *progress_);
        const double cost = contact_point_cost(shell.shell);
        const std::string asset = map.name + " x " + shell.name;
        for (const ContactBench &r : runs)
            json_["runs"].push_back({{"asset", asset},
                                     {"shell_points", shell.shell.point_count},
                                     {"motion", r.motion},
                                     {"mode", r.mode},
                                     {"field", r.field},
                                     {"p50_ns", r.ns.p50},
                                     {"p99_ns", r.ns.p99},
                                     {"p999_ns", r.ns.p999},
                                     {"max_ns", r.ns.max},
                                     {"points_touched", r.touched},
                                     {"points_in_contact", r.hits},
                                     {"ticks", r.ticks}});
        json_["points_in_1ms"].push_back(
            {{"asset", asset}, {"worst_case", std::floor(1e-3 / cost)}, {"sliding_p99", fit(runs, shell)}});
        if (o_.json) return;
        fmt::print("{}: {} points, voxel {}, on {}\n", asset, format_count(shell.shell.point_count),
                   format_length(map.map.voxel), processor_name());
        fmt::print("  {:<9}{:<10}{:<14}{:>10}{:>10}{:>10}{:>10}{:>12}{:>12}\n", "motion", "field", "mode",
                   "p50 us", "p99", "p99.9", "max", "looked at", "in contact");
        for (const ContactBench &r : runs)
            fmt::print("  {:<9}{:<10}{:<14}{:>10.2f}{:>10.2f}{:>10.2f}{:>10.1f}{:>12.0f}{:>12.0f}\n",
                       r.motion, r.field, r.mode, r.ns.p50 / 1e3, r.ns.p99 / 1e3, r.ns.p999 / 1e3,
                       r.ns.max / 1e3, r.touched, r.hits);
        fmt::print("  in 1 ms: {} points if all are in contact ({:.2f} ns each); of a shell like this one, "
                   "sliding, {} (by p99)\n",
                   format_count(static_cast<std::uint64_t>(1e-3 / cost)), 1e9 * cost,
                   format_count(static_cast<std::uint64_t>(fit(runs, shell))));
    }

    /// How many points a shell may have whose sliding tick takes a millisecond, if time grows with the
    /// points.
    static double fit(const std::vector<ContactBench> &runs, const Opened &shell)
    {
        for (const ContactBench &r : runs)
            if (r.motion == "sliding" && r.field == "states" && r.mode == "coherent")
                return std::floor(1e6 / r.ns.p99 * shell.shell.point_count);
        return 0;
    }

    const BenchOptions &o_;
    std::unique_ptr<Progress> progress_;
    std::vector<Opened> maps_, shells_;
    json json_ = {{"schema", "voxshell-bench/1"},
                  {"version", tool_version()},
                  {"machine", processor_name()},
                  {"runs", json::array()},
                  {"points_in_1ms", json::array()}};
};

} // namespace

VerbAction add_bench(CLI::App &verb)
{
    auto o = std::make_shared<BenchOptions>();
    verb.add_option("FILE", o->files, "what stands (.voxmap) and what moves (.pointshell): each with each")
        ->required();
    verb.add_option(
            "--ticks", o->ticks,
            "of each motion and mode, fewer if they take more than 2 s (default 2000; 100 to 1000000)")
        ->check(CLI::Range(std::uint64_t{100}, std::uint64_t{1'000'000}))
        ->type_name("N");
    add_shared(verb, *o, {Shared::format, Shared::progress, Shared::quiet});
    return [o] { return Bench(*o).run(); };
}

} // namespace voxshell
