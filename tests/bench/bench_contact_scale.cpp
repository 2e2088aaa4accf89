// SPDX-License-Identifier: GPL-3.0-or-later
// What a larger static part costs a tick: bench_contact_scale [ROUNDS [POINTS...]]. The same sphere, the same
// path,
//   cup      one cup in cells of 0.5 mm
//   finer    the cup in cells of 0.05 mm: ten times finer
//   larger   a hundred cups in one map, cells of 0.5 mm: a hundred times larger; the sphere in one in the
//   middle hopping  the same map; every tick in another of the hundred cups: what it touches was last touched
//   100 ticks ago
// One line of JSON per mode, motion, scene and round; scenes alternate.
#include "contact_ours.hpp"

#include "cup.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>

using namespace voxshell;
using namespace voxshell::bench;

namespace {

constexpr int side = 10;        // cups a side
constexpr double spacing = 0.1; // [m]

Vec3 place_of(int cup)
{
    return {(cup / side - side / 2) * spacing, 0, (cup % side - side / 2) * spacing};
}

/// A hundred cups, of longer triangles but the same facets: the cells are those of a hundred cup.hpp.
Mesh hundred_cups()
{
    const Mesh one = bench_cup(300, 5);
    Mesh all;
    all.name = "cups";
    for (int cup = 0; cup < side * side; ++cup) {
        const auto first = static_cast<std::uint32_t>(all.vertices.size());
        const Vec3 place = place_of(cup);
        for (const Point &v : one.vertices)
            all.vertices.push_back({v[0] + place[0], v[1] + place[1], v[2] + place[2]});
        for (const Triangle &t : one.triangles)
            all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return all;
}

struct Setting {
    const char *name;
    std::shared_ptr<const OurMap> map;
    bool hops;
};

/// Tick n of a path in the first cup, carried over to the n-th of a hundred.
std::vector<Pose> hopping(std::vector<Pose> poses)
{
    for (std::size_t n = 0; n < poses.size(); ++n) {
        const Vec3 place = place_of(static_cast<int>(n) % (side * side));
        for (std::size_t a = 0; a < 3; ++a) poses[n].position[a] += place[a];
    }
    return poses;
}

struct Path {
    const char *name;
    double depth; ///< into the inner wall [m]
};
/// 0.25 mm is beneath the layer of cells of 0.05 mm; 0.025 mm is half of it, and what the coarse cells see as
/// grazing.
constexpr Path paths[] = {
    {"slide 0.25 mm deep", 0.00025}, {"slide 0.025 mm deep", 0.000025}, {"free", -0.015}};

void run(const std::vector<Setting> &scenes, const OurMode &mode, std::uint32_t count, int rounds)
{
    const Points points = sphere_points(count);
    std::vector<std::unique_ptr<Rival>> rivals;
    for (const Setting &scene : scenes) rivals.push_back(make_our_rival(mode, scene.map, points));
    for (const Path &path : paths) {
        const std::vector<Pose> poses = slide_at(path.depth), hops = hopping(poses);
        for (int round = 0; round < rounds; ++round)
            for (std::size_t s = 0; s < scenes.size(); ++s) {
                const auto &way = scenes[s].hops ? hops : poses;
                const auto ns = time_ticks(*rivals[s], way);
                const Contact last = rivals[s]->tick(way.back());
                fmt::print("{{\"mode\":\"{}\",\"path\":\"{}\",\"scene\":\"{}\",\"points\":{},\"contacts\":{},"
                           "\"touched\":{},\"map_mib\":{:.1f},\"ns\":[{}]}}\n",
                           mode.name, path.name, scenes[s].name, count, last.contacts, last.touched,
                           mib_of(*scenes[s].map), fmt::join(ns, ","));
            }
    }
}

} // namespace

int main(int argc, char **argv)
{
    const int rounds = argc > 1 ? std::atoi(argv[1]) : 5;
    std::vector<std::uint32_t> sizes;
    for (int i = 2; i < argc; ++i) sizes.push_back(static_cast<std::uint32_t>(std::atoi(argv[i])));
    if (sizes.empty()) sizes = {10000, 100000, 1000000};
    const Mesh cup = static_mesh(Motion::slide);
    const auto larger = make_our_map(hundred_cups(), 0.0005, false);
    const std::vector<Setting> scenes{{"cup", make_our_map(cup, 0.0005, false), false},
                                      {"finer", make_our_map(cup, 0.00005, false), false},
                                      {"larger", larger, false},
                                      {"hopping", larger, true}};
    for (const OurMode &mode : our_modes()) {
        const std::string_view name = mode.name;
        const bool told = name.find("scalar") == name.npos && name.find("law") == name.npos;
        if (!told || mode.distance || mode.most_points) continue; // what the others say holds for these
        for (const std::uint32_t count : sizes) run(scenes, mode, count, rounds);
    }
}
