// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/paper_run.hpp"

#include "study/open_part.hpp"
#include "study/paper_path.hpp"

#include <tbb/parallel_for.h>

#include <cmath>
#include <map>
#include <memory>

namespace voxshell {
namespace {

constexpr int channel_layers = 4;
constexpr double channel_distance = 4;

class Bodies {
  public:
    void make(const Body &body, Progress &progress)
    {
        std::unique_ptr<OpenPart> &found = open_[body.name];
        if (found) return;
        PartOptions options;
        options.voxel = body.voxel;
        options.shell = body.shell;
        options.stands = body.stands;
        if (body.stands) options.channels = {channel_layers, channel_distance};
        found = std::make_unique<OpenPart>(body.name, body.mesh, options, progress);
    }
    const OpenPart &get(const std::string &name) const { return *open_.at(name); }

  private:
    std::map<std::string, std::unique_ptr<OpenPart>> open_;
};

std::vector<RunKey> keys_of(const PaperOptions &options)
{
    std::vector<RunKey> keys;
    for (const Scenario &scenario : paper_scenarios()) {
        const std::size_t speeds = std::max<std::size_t>(1, scenario.speeds.size());
        const std::string group = scenario.group;
        for (std::size_t variant = 0; variant < scenario.variants.size(); ++variant) {
            for (std::size_t level = 0; level < scenario.levels.size(); ++level) {
                for (std::size_t speed = 0; speed < speeds; ++speed) {
                    if (options.quick && group == "control" && scenario.levels[level] != 0.5) continue;
                    if (options.quick && group == "wall" && (level % 2 != 0 || speed % 2 == 0)) continue;
                    for (unsigned seed = 1; seed <= options.seeds; ++seed)
                        keys.push_back({&scenario, variant, level, speed, seed});
                }
            }
        }
    }
    return keys;
}

bool is_path(const RunKey &key)
{
    return !is_loop(*key.scenario) && key.scenario->motion != Motion::coupled;
}

} // namespace

PaperRuns run_paper(const PaperOptions &options, Progress &progress)
{
    std::vector<RunKey> paths, loops;
    for (const RunKey &key : keys_of(options)) (is_path(key) ? paths : loops).push_back(key);
    Bodies bodies;
    for (const auto *keys : {&paths, &loops}) {
        for (const RunKey &key : *keys) {
            bodies.make(standing_body(*key.scenario, key.level_value(), key.seed), progress);
            bodies.make(moving_body(*key.scenario, key.level_value(), key.how().method.shell), progress);
            progress.check();
        }
    }
    PaperRuns runs;
    runs.points = run_points(progress);
    runs.paths.resize(paths.size());
    runs.loops.resize(loops.size());
    progress.stage("runs", paths.size() + loops.size());
    // The long ones first: what is left at the end is short.
    tbb::parallel_for(std::size_t{0}, loops.size() + paths.size(), [&](std::size_t n) {
        progress.check();
        const RunKey &key = n < loops.size() ? loops[n] : paths[n - loops.size()];
        const OpenPart &stands = bodies.get(standing_body(*key.scenario, key.level_value(), key.seed).name);
        const OpenPart &moves =
            bodies.get(moving_body(*key.scenario, key.level_value(), key.how().method.shell).name);
        if (n >= loops.size()) {
            runs.paths[n - loops.size()] = run_path(key, stands, moves);
        } else {
            runs.loops[n] =
                is_loop(*key.scenario) ? run_loop(key, stands, moves) : run_coupled(key, stands, moves);
        }
        progress.advance(1);
    });
    return runs;
}

} // namespace voxshell
