// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "cli/failure.hpp"
#include "voxmap/voxmap_file.hpp"
#include "written_file.hpp"

#include <algorithm>
#include <map>
#include <random>
#include <tuple>

using namespace voxshell;

namespace {

using States = std::array<std::uint8_t, 512>;

/// What stands at a brick: its absolute position, and per cell state, layer and distance.
struct Content {
    States state{};
    std::array<std::int8_t, 512> layer{};
    std::array<std::int16_t, 512> distance{};
    bool operator==(const Content &) const = default;
};
using Contents = std::map<Cell, Content>;

constexpr std::uint64_t all_cells = ~std::uint64_t{0};

/// Cells taken apart in the plainest way: the oracle for what a file must keep. Bricks that are free
/// throughout count as there only with channels.
Contents contents_of(const VoxmapFile &file)
{
    Contents contents;
    const Cells &cells = file.cells;
    const auto at = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
        return Cell{cells.origin[0] / 8 + i, cells.origin[1] / 8 + j, cells.origin[2] / 8 + k};
    };
    for (const SolidRun &run : cells.solid) {
        for (std::int32_t k = run.first; k <= run.last; ++k)
            contents[at(run.i, run.j, k)].state.fill(VXS_CELL_INTERIOR);
    }
    const bool channels = !file.channels.layer.empty() || !file.channels.distance.empty();
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        const Brick &brick = cells.bricks[b];
        Content content;
        for (std::size_t c = 0; c < 512; ++c) {
            if (brick.surface[c >> 6] >> (c & 63) & 1) content.state[c] = VXS_CELL_SURFACE;
            if (brick.interior[c >> 6] >> (c & 63) & 1) content.state[c] = VXS_CELL_INTERIOR;
        }
        if (!file.channels.layer.empty()) content.layer = file.channels.layer[b];
        if (!file.channels.distance.empty()) content.distance = file.channels.distance[b];
        if (channels || std::ranges::any_of(content.state, [](auto s) { return s != 0; }))
            contents[at(brick.at[0], brick.at[1], brick.at[2])] = content;
    }
    return contents;
}

void count(Cells &cells, const Contents &contents)
{
    cells.surface_cells = cells.interior_cells = 0;
    cells.min.fill(INT64_MAX);
    cells.max.fill(INT64_MIN);
    for (const auto &[at, content] : contents) {
        for (int c = 0; c < 512; ++c) {
            const auto state = content.state[static_cast<std::size_t>(c)];
            if (state == VXS_CELL_FREE) continue;
            ++(state == VXS_CELL_SURFACE ? cells.surface_cells : cells.interior_cells);
            const int inner[3] = {c >> 6, c >> 3 & 7, c & 7};
            for (std::size_t a = 0; a < 3; ++a) {
                cells.min[a] = std::min(cells.min[a], 8 * at[a] + inner[a]);
                cells.max[a] = std::max(cells.max[a], 8 * at[a] + inner[a]);
            }
        }
    }
}

/// Random bricks and solid runs in a box of 3 x 2 x 5 chunks; some bricks are free or interior throughout.
/// Whole chunks are solid too.
VoxmapFile random_map(std::uint32_t seed)
{
    std::mt19937 random(seed);
    const auto pick = [&](std::uint32_t n) { return static_cast<std::int32_t>(random() % n); };
    VoxmapFile file;
    file.meta = "{\"seed\":" + std::to_string(seed) + "}";
    file.source_hash[5] = static_cast<std::uint8_t>(seed);
    Cells &cells = file.cells;
    cells.voxel = 0.001 * (seed + 1);
    cells.closed = seed % 2;
    for (auto &o : cells.origin) o = 64 * (pick(7) - 3);
    for (std::int32_t i = 0; i < 24; ++i) {
        for (std::int32_t j = 0; j < 16; ++j) {
            for (std::int32_t k = 0; k < 40; ++k) {
                const bool in_solid_chunk = i >= 8 && i < 16 && j < 8 && k >= 16 && k < 32;
                const int kind = in_solid_chunk ? 90 : pick(100);
                if (kind < 85) continue;
                if (kind < 92) {
                    const std::int32_t last = in_solid_chunk ? k : std::min(39, k + pick(12));
                    cells.solid.push_back({i, j, k, last});
                    k = last;
                    continue;
                }
                Brick brick;
                brick.at = {i, j, k};
                for (std::size_t row = 0; row < 8; ++row) {
                    const std::uint64_t a = random() | std::uint64_t{random()} << 32,
                                        b = random() | std::uint64_t{random()} << 32;
                    brick.surface[row] = kind == 92 || kind == 93 ? 0 : a;
                    brick.interior[row] = kind == 92 ? 0 : kind == 93 ? all_cells : b & ~a;
                }
                cells.bricks.push_back(brick);
            }
        }
    }
    count(cells, contents_of(file));
    return file;
}

void add_channels(VoxmapFile &file, std::uint32_t seed)
{
    std::mt19937 random(seed);
    Channels &channels = file.channels;
    channels.layer_count = 3;
    channels.distance_step = 0.1 * file.cells.voxel / 3;
    channels.distance_band = 100 * channels.distance_step;
    channels.distance_error = channels.distance_step;
    for (const Brick &brick : file.cells.bricks) {
        auto &layer = channels.layer.emplace_back();
        auto &distance = channels.distance.emplace_back();
        for (std::size_t c = 0; c < 512; ++c) {
            const bool surface = brick.surface[c >> 6] >> (c & 63) & 1,
                       interior = brick.interior[c >> 6] >> (c & 63) & 1;
            const int ring = surface ? 0 : 1 + static_cast<int>(random() % 4),
                      steps = static_cast<int>(random() % 101);
            layer[c] = static_cast<std::int8_t>(interior ? -ring : ring);
            distance[c] = static_cast<std::int16_t>(interior || (surface && random() % 2) ? -steps : steps);
        }
    }
}

VoxmapFile read_back(std::span<const std::uint8_t> bytes)
{
    const WrittenFile file(bytes);
    return read_voxmap(file.path());
}

void check_same(const VoxmapFile &a, const VoxmapFile &b)
{
    CHECK(a.cells.voxel == b.cells.voxel);
    CHECK(a.cells.surface_cells == b.cells.surface_cells);
    CHECK(a.cells.interior_cells == b.cells.interior_cells);
    CHECK(a.cells.min == b.cells.min);
    CHECK(a.cells.max == b.cells.max);
    CHECK(a.cells.closed == b.cells.closed);
    CHECK(a.source_hash == b.source_hash);
    CHECK(a.meta == b.meta);
    CHECK((contents_of(a) == contents_of(b)));
}

/// The invariants that cells.hpp promises.
void check_sorted(const Cells &cells)
{
    CHECK(std::ranges::is_sorted(cells.bricks, {}, &Brick::at));
    for (std::size_t r = 1; r < cells.solid.size(); ++r) {
        const SolidRun &a = cells.solid[r - 1], &b = cells.solid[r];
        CHECK((std::tie(a.i, a.j) < std::tie(b.i, b.j) ||
               (std::tie(a.i, a.j) == std::tie(b.i, b.j) && a.last + 1 < b.first)));
    }
}

} // namespace

TEST_CASE("cells come back as they were, and their bytes are one sequence")
{
    for (std::uint32_t seed = 0; seed < 6; ++seed) {
        CAPTURE(seed);
        const VoxmapFile written = random_map(seed);
        const auto bytes = voxmap_bytes(written);
        const VoxmapFile read = read_back(bytes);
        check_same(written, read);
        check_sorted(read.cells);
        CHECK(voxmap_bytes(read) == bytes);
        CHECK(std::ranges::none_of(read.cells.bricks, [](const Brick &b) {
            return std::ranges::all_of(b.interior, [](auto row) { return row == all_cells; });
        }));
    }
}

TEST_CASE("channels come back with every brick that they speak in")
{
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
        CAPTURE(seed);
        VoxmapFile written = random_map(seed);
        add_channels(written, seed);
        if (seed == 1) written.channels.layer.clear(), written.channels.layer_count = 0;
        if (seed == 2) {
            written.channels.distance.clear();
            written.channels.distance_step = written.channels.distance_band =
                written.channels.distance_error = 0;
        }
        const auto bytes = voxmap_bytes(written);
        const VoxmapFile read = read_back(bytes);
        check_same(written, read);
        CHECK(read.cells.bricks.size() == written.cells.bricks.size());
        CHECK(read.channels.layer_count == written.channels.layer_count);
        CHECK(read.channels.distance_step == written.channels.distance_step);
        CHECK(read.channels.distance_band == doctest::Approx(written.channels.distance_band).epsilon(1e-15));
        CHECK(voxmap_bytes(read) == bytes);
    }
}

TEST_CASE("a channel's band beyond the cells widens the box")
{
    VoxmapFile file;
    file.cells.voxel = 1;
    file.cells.origin = {-64, 0, 0};
    file.cells.bricks.resize(2);
    file.cells.bricks[0].at = {7, 0, 0}; // free: the ring around the cell at i = 0
    file.cells.bricks[1].at = {8, 0, 0};
    file.cells.bricks[1].surface[0] = 1;
    file.cells.surface_cells = 1;
    file.channels.layer_count = 1;
    file.channels.layer.resize(2);
    file.channels.layer[0].fill(2);
    file.channels.layer[1].fill(2);
    file.channels.layer[1][0] = 0;
    const VoxmapFile read = read_back(voxmap_bytes(file));
    CHECK(read.cells.origin == Cell{-64, 0, 0});
    check_same(file, read);
}

TEST_CASE("the origin of the cells does not show in the bytes")
{
    const VoxmapFile file = random_map(3);
    VoxmapFile moved = file;
    moved.cells.origin[1] -= 128;
    for (Brick &brick : moved.cells.bricks) brick.at[1] += 16;
    for (SolidRun &run : moved.cells.solid) run.j += 16;
    CHECK(voxmap_bytes(moved) == voxmap_bytes(file));
}

TEST_CASE("a solid of a billion cells is a few entries")
{
    VoxmapFile file;
    file.clearance = false; // that of the solid's border is 6 MB
    Cells &cells = file.cells;
    cells.voxel = 1e-4;
    for (std::int32_t i = 0; i < 128; ++i) {
        for (std::int32_t j = 0; j < 128; ++j) cells.solid.push_back({i, j, 0, 127});
    }
    Brick brick;
    brick.at = {128, 0, 0};
    brick.surface[0] = 1;
    cells.bricks.push_back(brick);
    cells.surface_cells = 1;
    cells.interior_cells = std::uint64_t{1} << 30;
    cells.max = {1024, 1023, 1023};
    const auto bytes = voxmap_bytes(file);
    CHECK(bytes.size() < 25000);
    const VoxmapFile read = read_back(bytes);
    CHECK(read.cells.solid == cells.solid);
    CHECK(read.cells.interior_cells == cells.interior_cells);
}

TEST_CASE("what no voxmap can hold is refused with the way out")
{
    const auto refusal = [](const VoxmapFile &file) {
        try {
            voxmap_bytes(file);
        } catch (const Failure &failure) {
            CHECK(failure.code == ExitCode::requirement);
            return std::string(failure.what());
        }
        return std::string();
    };
    VoxmapFile file = random_map(1);
    CHECK(refusal(file).empty());
    file.cells.surface_cells = 0;
    CHECK(refusal(file).find("no surface cell") == 0);
    file = random_map(1);
    file.cells.voxel = 1e-13;
    CHECK(refusal(file).find("voxel") != std::string::npos);
    file = random_map(1);
    file.cells.max[1] = file.cells.min[1] + (1 << 20) + 64;
    CHECK(refusal(file).find("2^20") != std::string::npos);
    file = random_map(1);
    for (std::size_t a = 0; a < 3; ++a) file.cells.max[a] = file.cells.min[a] + 300 * 64;
    CHECK(refusal(file).find("chunks") != std::string::npos);
    file = random_map(1);
    file.cells.max[0] = file.cells.min[0]; // cells outside the stated box
    CHECK_THROWS_AS(voxmap_bytes(file), Failure);
}
