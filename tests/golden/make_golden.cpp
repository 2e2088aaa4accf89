// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the golden assets through the real writers: `make_golden DIR` writes them, `make_golden --check DIR`
// compares. A golden's bytes change only with a line in CHANGELOG.md that says why.
#include "plan/plan_file.hpp"
#include "pointshell/pointshell_file.hpp"
#include "voxmap/voxmap_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

using namespace voxshell;

namespace {

using Bytes = std::vector<std::uint8_t>;
const std::string meta = R"({"golden":true})";

/// The smallest voxmap: one cell.
Bytes one_cell()
{
    VoxmapFile file;
    file.meta = meta;
    file.cells.voxel = 0.001;
    file.cells.bricks.resize(1);
    file.cells.bricks[0].surface[0] = 1;
    file.cells.surface_cells = 1;
    file.clearance = false;
    return voxmap_bytes(file);
}

/// Every kind of entry: a solid chunk, a solid brick, free bricks, one brick of its own; negative cells.
VoxmapFile uniform_cells()
{
    VoxmapFile file;
    file.clearance = false;
    file.meta = meta;
    file.source_hash = sha256({});
    Cells &cells = file.cells;
    cells.voxel = 0.0005;
    cells.origin = {-64, 0, 64};
    for (std::int32_t i = 0; i < 8; ++i) {
        for (std::int32_t j = 0; j < 8; ++j) cells.solid.push_back({i, j, 0, i == 0 && j == 0 ? 8 : 7});
    }
    Brick brick;
    brick.at = {0, 0, 9};
    brick.surface[0] = 0xff;
    brick.interior[1] = 0x0f;
    cells.bricks.push_back(brick);
    cells.surface_cells = 8;
    cells.interior_cells = 64 * 64 * 64 + 512 + 4;
    cells.min = {-64, 0, 64};
    cells.max = {-1, 63, 143};
    cells.closed = true;
    return file;
}

Bytes uniform()
{
    return voxmap_bytes(uniform_cells());
}

/// The same with a brick four chunks farther, so that one of the chunks between is far from both.
Bytes clearance()
{
    VoxmapFile file = uniform_cells();
    file.clearance = true;
    Brick brick;
    brick.at = {0, 0, 40};
    brick.surface[0] = 1;
    file.cells.bricks.push_back(brick);
    file.cells.surface_cells += 1;
    file.cells.max[2] = 64 + 8 * 40;
    return voxmap_bytes(file);
}

/// Layers and distances around one cell, over a brick that is free itself.
Bytes channels()
{
    VoxmapFile file;
    file.meta = meta;
    file.clearance = false;
    Cells &cells = file.cells;
    cells.voxel = 0.001;
    cells.bricks.resize(2);
    cells.bricks[0].surface[7] = 1;
    cells.bricks[1].at = {1, 0, 0};
    cells.surface_cells = 1;
    cells.min = cells.max = {7, 0, 0};
    Channels &channels = file.channels;
    channels.layer_count = 2;
    channels.distance_step = 1.0 / 65536;
    channels.distance_band = 128.0 / 65536;
    channels.distance_error = 0.5 / 65536;
    channels.unsigned_distance = true;
    channels.layer.resize(2);
    channels.distance.resize(2);
    for (int b = 0; b < 2; ++b) {
        for (int c = 0; c < 512; ++c) {
            const int i = 8 * b + (c >> 6) - 7, j = c >> 3 & 7, k = c & 7;
            const double steps = std::sqrt(static_cast<double>(i * i + j * j + k * k)) * 65.536;
            channels.layer[b][c] = static_cast<std::int8_t>(std::min(std::max({std::abs(i), j, k}), 3));
            channels.distance[b][c] = static_cast<std::int16_t>(std::min(std::lround(steps), 128L));
        }
    }
    return voxmap_bytes(file);
}

/// The smallest pointshell: one point, 15 of padding.
Bytes one_point()
{
    PointshellFile file;
    file.meta = meta;
    Shell &shell = file.shell;
    shell.voxel = 0.001;
    shell.points.push_back(
        {.position = {0.5f, 0.25f, -2.0f}, .normal = {0, 0, -1}, .area = 1e-6f, .brick = 0, .cell = 0});
    shell.clusters.push_back({{0.5f, 0.25f, -2.0f}, 0, 0, 1});
    shell.area = 1e-6;
    shell.center = {0.5, 0.25, -2};
    shell.surface_cells = 1;
    return pointshell_bytes(file);
}

/// Two clusters with spheres that the points just touch, padding, a normal off the axes.
PointshellFile two_runs()
{
    PointshellFile file;
    file.meta = meta;
    file.source_hash = sha256({});
    Shell &shell = file.shell;
    shell.kind = ShellKind::naive;
    shell.voxel = 0.0625;
    for (int p = 0; p < 70; ++p) {
        const std::array<float, 3> oblique{0.6f, 0, -0.8f}, up{0, 1, 0};
        shell.points.push_back({.position = {static_cast<float>(p) / 16, 0, 0},
                                .normal = p % 2 ? oblique : up,
                                .area = 0.25f,
                                .brick = 0,
                                .cell = 0});
    }
    shell.clusters.push_back({{31.5f / 16, 0, 0}, 31.5f / 16, 0, 64});
    shell.clusters.push_back({{66.5f / 16, 0, 0}, 2.5f / 16, 64, 6});
    shell.area = 17.5;
    shell.gap_max = 0.0625;
    shell.surface_error = 0.03125;
    shell.center = {34.5 / 16, 0, 0};
    shell.radius = 34.5 / 16;
    shell.surface_cells = 70;
    return file;
}

Bytes two_clusters()
{
    return pointshell_bytes(two_runs());
}

Bytes no_area()
{
    PointshellFile file = two_runs();
    file.areas = false;
    return pointshell_bytes(file);
}

vxs_plan_asset planned(std::uint32_t role, const char *name, std::uint8_t hash)
{
    vxs_plan_asset asset{};
    asset.role = role;
    asset.orientation[0] = 1;
    std::ranges::fill(asset.content_hash, hash);
    put_text(asset.name, name);
    return asset;
}

PlanFile plain_plan()
{
    PlanFile file;
    file.meta = meta;
    vxs_plan_info &info = file.info;
    info.rate = 1000;
    info.law = VXS_PLAN_LAW_AVERAGE;
    info.field = VXS_PLAN_FIELD_SURFACE;
    info.weighting = VXS_PLAN_WEIGHT_COUNT;
    info.stiffness = 500;
    info.coupling = VXS_PLAN_COUPLING_NONE;
    info.max_force = 3;
    info.max_torque = 0.25;
    info.max_speed = 20;
    info.decay_time = 0.0078125;
    info.scale = 1;
    info.mount_orientation[0] = info.grip_orientation[0] = 1;
    put_text(info.device, "sim:touch");
    put_text(info.arm, "hand");
    file.assets = {planned(VXS_PLAN_ROLE_STATIC, "a.voxmap", 0xaa),
                   planned(VXS_PLAN_ROLE_DYNAMIC, "b.pointshell", 0xbb)};
    return file;
}

/// The smallest plan: no effect, no hand.
Bytes bare()
{
    return plan_bytes(plain_plan());
}

/// Every section: two statics of which one is turned, a coupling with numbers, effects with and without
/// constants, a hand that goes straight and turns.
Bytes pressed()
{
    PlanFile file = plain_plan();
    file.source_hash = sha256({});
    vxs_plan_info &info = file.info;
    info.law = VXS_PLAN_LAW_PATCH;
    info.field = VXS_PLAN_FIELD_DISTANCE;
    info.weighting = VXS_PLAN_WEIGHT_AREA;
    info.flags = VXS_PLAN_FLAG_DESIGNED;
    info.most_stiffness = 2000;
    info.budget = 0x1p-16;
    info.coupling = VXS_PLAN_COUPLING_PT2;
    info.prewarp = 1;
    info.omega0 = 32;
    info.damping = 1;
    info.gain = 1;
    info.hold_time = 0.001953125;
    info.mount_position[1] = 0.5;
    vxs_plan_asset turned = planned(VXS_PLAN_ROLE_STATIC, "a.voxmap", 0xaa);
    turned.position[0] = -0.25;
    turned.orientation[0] = 0.6;
    turned.orientation[2] = -0.8;
    file.assets.insert(file.assets.begin() + 1, turned);
    vxs_plan_effect plain{}, ramp{};
    put_text(plain.kind, "start-inside");
    put_text(ramp.kind, "soft-start");
    ramp.constant_count = 1;
    ramp.constants[0] = 0.5;
    file.effects = {plain, ramp};
    vxs_plan_keyframe first{}, straight{}, arc{};
    first.position[1] = 0.0625;
    first.orientation[0] = straight.orientation[0] = arc.orientation[0] = 1;
    straight.time = 0.5;
    straight.position[0] = 0.125;
    arc.time = 2;
    arc.position[0] = -0.125;
    arc.move = VXS_PLAN_MOVE_TURN;
    arc.turn_axis[1] = 1;
    arc.turn_angle = 3;
    file.hand = {first, straight, arc};
    return plan_bytes(file);
}

/// A static that moves.
Bytes moved()
{
    PlanFile file = plain_plan();
    file.assets.insert(file.assets.begin(), planned(VXS_PLAN_ROLE_STATIC, "still.voxmap", 0xcc));
    vxs_plan_effect motion{};
    put_text(motion.kind, "motion");
    motion.constant_count = 1;
    motion.constants[0] = 1;
    file.effects = {motion};
    vxs_plan_motion first{}, second{};
    first.asset = second.asset = 1;
    first.orientation[0] = second.orientation[0] = 1;
    second.time = 1.5;
    second.position[2] = 0.03125;
    file.moves = {first, second};
    return plan_bytes(file);
}

const struct {
    const char *name;
    Bytes (*make)();
} goldens[] = {{"one_cell.voxmap", one_cell},       {"uniform.voxmap", uniform},
               {"clearance.voxmap", clearance},     {"channels.voxmap", channels},
               {"one_point.pointshell", one_point}, {"two_clusters.pointshell", two_clusters},
               {"no_area.pointshell", no_area},     {"bare.plan", bare},
               {"pressed.plan", pressed},           {"moved.plan", moved}};

Bytes file_bytes(const std::filesystem::path &path)
{
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

} // namespace

int main(int argc, char **argv)
{
    const bool check = argc == 3 && std::string(argv[1]) == "--check";
    if (argc != 2 && !check) {
        fmt::print(stderr, "make_golden [--check] DIR\n");
        return 1;
    }
    int differ = 0;
    for (const auto &golden : goldens) {
        const std::filesystem::path path = std::filesystem::path(argv[argc - 1]) / golden.name;
        const Bytes bytes = golden.make();
        if (!check) {
            std::ofstream(path, std::ios::binary)
                .write(reinterpret_cast<const char *>(bytes.data()),
                       static_cast<std::streamsize>(bytes.size()));
        } else if (file_bytes(path) != bytes) {
            fmt::print(stderr, "{} is not what the writers write now\n", path.string());
            ++differ;
        }
    }
    return differ ? 1 : 0;
}
