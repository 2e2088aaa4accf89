// SPDX-License-Identifier: GPL-3.0-or-later
// The clearance of every block and the plane of every brick against their definitions in formats/voxmap.md,
// cell by cell.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "voxmap/clearance.hpp"
#include "voxmap/voxmap_file.hpp"

#include "container/asset_file.hpp"
#include "written_file.hpp"

#include <algorithm>
#include <cmath>
#include <random>

using namespace voxshell;

namespace {

using Ints = std::array<int, 3>;

/// Squared distance from a point to the closed box [low, low + edge]; whole cells, as both ends are.
long long squared(const Ints &point, const Ints &low, int edge)
{
    long long sum = 0;
    for (int a = 0; a < 3; ++a) {
        const long long away = std::max({low[a] - point[a], point[a] - low[a] - edge, 0});
        sum += away * away;
    }
    return sum;
}

/// The cells of a map that do not have the state.
struct Others {
    const vxs_voxmap &map;
    const std::uint32_t state;
    std::vector<bool> block; ///< which blocks hold one, in the box and 17 blocks around it
    Ints blocks{};

    Others(const vxs_voxmap &m, std::uint32_t s) : map(m), state(s)
    {
        for (int a = 0; a < 3; ++a) blocks[a] = static_cast<int>(map.cells[a]) / 4 + 34;
        for (int i = 0; i < blocks[0]; ++i)
            for (int j = 0; j < blocks[1]; ++j)
                for (int k = 0; k < blocks[2]; ++k)
                    block.push_back(any({4 * (i - 17), 4 * (j - 17), 4 * (k - 17)}));
    }

    bool is_other(const Ints &at) const
    {
        return vxs_voxmap_state_at(&map, map.origin_cell[0] + at[0], map.origin_cell[1] + at[1],
                                   map.origin_cell[2] + at[2]) != state;
    }

    bool any(const Ints &corner) const
    {
        for (int c = 0; c < 64; ++c)
            if (is_other({corner[0] + (c >> 4), corner[1] + (c >> 2 & 3), corner[2] + (c & 3)})) return true;
        return false;
    }

    /// f(corner) for the corners from low to high by `step` along each axis.
    template<typename F>
    static void each(const Ints &low, const Ints &high, int step, F f)
    {
        for (int i = low[0]; i <= high[0]; i += step)
            for (int j = low[1]; j <= high[1]; j += step)
                for (int k = low[2]; k <= high[2]; k += step) f(Ints{i, j, k});
    }

    /// What the format says, in half cells.
    int clearance_at(const Ints &center) const
    {
        const auto around = [&](int reach, int step, auto f) {
            each({center[0] - reach, center[1] - reach, center[2] - reach},
                 {center[0] + reach - 1, center[1] + reach - 1, center[2] + reach - 1}, step, f);
        };
        long long near = 1 << 20, far = 1 << 20;
        around(16, 1, [&](const Ints &at) {
            if (is_other(at)) near = std::min(near, squared(center, at, 1));
        });
        if (near < 16 * 16) return static_cast<int>(std::floor(2 * std::sqrt(static_cast<double>(near))));
        around(66, 4, [&](const Ints &at) {
            const std::size_t index =
                (static_cast<std::size_t>(at[0] / 4 + 17) * static_cast<std::size_t>(blocks[1]) +
                 static_cast<std::size_t>(at[1] / 4 + 17)) *
                    static_cast<std::size_t>(blocks[2]) +
                static_cast<std::size_t>(at[2] / 4 + 17);
            if (block[index]) far = std::min(far, squared(center, at, 4));
        });
        return std::min(127,
                        std::max(32, static_cast<int>(std::floor(2 * std::sqrt(static_cast<double>(far))))));
    }
};

VoxmapFile random_cells(std::uint32_t seed)
{
    std::mt19937 dice(seed);
    VoxmapFile file;
    Cells &cells = file.cells;
    cells.voxel = 0.001;
    cells.origin = {-64, 0, 64};
    const int span = seed % 3 == 0 ? 23 : 15; // bricks: two or three chunks along each axis
    std::vector<BrickAt> places;
    for (int n = 0; n < 3 + static_cast<int>(seed % 4); ++n)
        places.push_back({static_cast<int>(dice() % span), static_cast<int>(dice() % span),
                          static_cast<int>(dice() % span)});
    std::ranges::sort(places);
    places.erase(std::unique(places.begin(), places.end()), places.end());
    for (const BrickAt &at : places) {
        Brick brick;
        brick.at = at;
        for (int n = 0; n < 4; ++n) brick.surface[dice() % 8] |= std::uint64_t{1} << dice() % 64;
        for (int i = 0; i < 8; ++i)
            brick.interior[i] = (dice() % 3 ? 0 : dice() & 0xff00ff) & ~brick.surface[i];
        cells.bricks.push_back(brick);
    }
    if (seed % 2) // a solid slab that no brick is in
        for (int i = 0; i < 14; ++i)
            for (int j = 0; j < 13; ++j) {
                std::int32_t first = 0;
                for (const BrickAt &at : places)
                    if (at[0] == i && at[1] == j) first = std::max(first, at[2] + 1);
                if (first < 12) cells.solid.push_back({i, j, first, 12});
            }
    recount(cells);
    return file;
}

} // namespace

TEST_CASE("every block's clearance is the one that the format defines")
{
    std::size_t blocks = 0, deep = 0, beyond = 0, exact = 0;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        const WrittenFile file(voxmap_bytes(random_cells(seed)));
        const AssetFile asset(file.path(), VXS_ASSET_VOXMAP);
        vxs_voxmap map;
        REQUIRE(vxs_voxmap_open(&asset.asset(), &map) == VXS_OK);
        REQUIRE(map.clearance_index);
        const Others solid(map, VXS_CELL_FREE), open(map, VXS_CELL_INTERIOR);
        std::mt19937 dice(seed);
        for (int n = 0; n < 500; ++n) {
            Ints block;
            for (int a = 0; a < 3; ++a) block[a] = 4 * static_cast<int>(dice() % (map.cells[a] / 4));
            const Ints center{block[0] + 2, block[1] + 2, block[2] + 2};
            std::uint32_t size = 0;
            const float radius = vxs_voxmap_clearance(&map, static_cast<std::uint32_t>(block[0]),
                                                      static_cast<std::uint32_t>(block[1]),
                                                      static_cast<std::uint32_t>(block[2]), &size);
            if (size != 4) continue; // the next test
            const int value = static_cast<int>(2 * radius);
            const int outside = solid.clearance_at(center);
            const int expected = outside ? outside : -open.clearance_at(center);
            REQUIRE(value == expected);
            ++blocks;
            deep += value < 0;
            beyond += value == 127 || value == -127;
            exact += std::abs(value) < 32;
        }
    }
    CHECK(deep > blocks / 50);
    CHECK(exact > blocks / 20);
    MESSAGE(blocks << " blocks, " << deep << " in the interior, " << exact << " nearer than 16 cells, "
                   << beyond << " beyond");
}

namespace {

/// What the format says of the brick whose first cell is `corner`, from all cells in question.
vxs_voxmap_plane plane_at(const Others &solid, const Ints &corner, std::uint32_t entry)
{
    const vxs_voxmap_plane nothing{{0, 0, 0}, -1};
    if (entry == VXS_CELL_INTERIOR) return nothing;
    const Ints center{corner[0] + 4, corner[1] + 4, corner[2] + 4};
    std::vector<Ints> touched;
    std::array<long long, 3> sum{};
    Others::each({-8, -8, -8}, {7, 7, 7}, 1, [&](const Ints &a) {
        if (!solid.is_other({center[0] + a[0], center[1] + a[1], center[2] + a[2]})) return;
        if (squared({0, 0, 0}, a, 1) < 64) touched.push_back(a);
        long long middle = 0; // in quarters
        for (int x = 0; x < 3; ++x) middle += (2 * a[x] + 1) * (2 * a[x] + 1);
        for (std::size_t x = 0; x < 3 && middle < 4 * 64; ++x) sum[x] += 2 * a[x] + 1;
    });
    if (touched.empty()) return {{0, 0, 0}, 0};
    const long long most = std::max({std::abs(sum[0]), std::abs(sum[1]), std::abs(sum[2])});
    if (most == 0) return nothing;
    vxs_voxmap_plane out{};
    for (std::size_t x = 0; x < 3; ++x) out.normal[x] = static_cast<std::int8_t>(127 * sum[x] / most);
    int least = 1 << 20;
    for (const Ints &a : touched)
        Others::each(a, {a[0] + 1, a[1] + 1, a[2] + 1}, 1, [&](const Ints &x) {
            least = std::min(least, out.normal[0] * x[0] + out.normal[1] * x[1] + out.normal[2] * x[2]);
        });
    const int offset = static_cast<int>(std::floor(least / 16.0));
    if (offset < -128) return nothing;
    out.offset = static_cast<std::int8_t>(offset);
    return out;
}

} // namespace

TEST_CASE("every brick's plane is the one that the format defines")
{
    int planes = 0, free = 0, silent = 0;
    for (std::uint32_t seed = 1; seed <= 8; ++seed) {
        const WrittenFile file(voxmap_bytes(random_cells(seed)));
        const AssetFile asset(file.path(), VXS_ASSET_VOXMAP);
        vxs_voxmap map;
        REQUIRE(vxs_voxmap_open(&asset.asset(), &map) == VXS_OK);
        REQUIRE(map.planes);
        const Others solid(map, VXS_CELL_FREE);
        Others::each({0, 0, 0},
                     {static_cast<int>(map.cells[0]) - 1, static_cast<int>(map.cells[1]) - 1,
                      static_cast<int>(map.cells[2]) - 1},
                     8, [&](const Ints &at) {
                         const auto i = static_cast<std::uint32_t>(at[0]),
                                    j = static_cast<std::uint32_t>(at[1]),
                                    k = static_cast<std::uint32_t>(at[2]);
                         const std::uint32_t chunk = map.root[vxs_voxmap_root_index(map.root_dims, i, j, k)];
                         if (chunk < VXS_VOXMAP_ENTRY_FIRST) return;
                         const std::size_t n = (chunk - VXS_VOXMAP_ENTRY_FIRST) * std::size_t{512} +
                                               vxs_voxmap_chunk_slot(i, j, k);
                         const vxs_voxmap_plane right = plane_at(solid, at, map.chunks[n]),
                                                found = map.planes[n];
                         REQUIRE(std::ranges::equal(found.normal, right.normal));
                         REQUIRE(found.offset == right.offset);
                         const bool none = std::ranges::count(right.normal, 0) == 3;
                         ++(!none ? planes : right.offset ? silent : free);
                     });
    }
    CHECK(planes > 500);
    CHECK(free > 500);
    CHECK(silent > 100);
    MESSAGE(planes << " planes, " << free << " bricks in the free, " << silent << " without a plane");
}

TEST_CASE("far from everything a chunk's clearance is the one that the format defines")
{
    // A solid block of 7 x 6 x 8 chunks in a box of 17 x 6 x 9, and a lone cell at the other end.
    VoxmapFile file;
    Cells &cells = file.cells;
    cells.voxel = 0.001;
    cells.origin = {640, -64, 0};
    for (std::int32_t i = 0; i < 56; ++i)
        for (std::int32_t j = 0; j < 48; ++j) cells.solid.push_back({i, j, 0, 63});
    Brick lone;
    lone.at = {130, 5, 70};
    lone.surface[3] = 1;
    cells.bricks.push_back(lone);
    recount(cells);
    const WrittenFile written(voxmap_bytes(file));
    const AssetFile asset(written.path(), VXS_ASSET_VOXMAP);
    vxs_voxmap map;
    REQUIRE(vxs_voxmap_open(&asset.asset(), &map) == VXS_OK);
    const std::array<int, 3> dims{17, 6, 9};
    for (int a = 0; a < 3; ++a) REQUIRE(map.root_dims[a] == static_cast<std::uint32_t>(dims[a]));
    const auto root = [&](int i, int j, int k) {
        const bool inside = i >= 0 && j >= 0 && k >= 0 && i < dims[0] && j < dims[1] && k < dims[2];
        return inside ? map.root[(i * dims[1] + j) * dims[2] + k] : std::uint32_t{VXS_CELL_FREE};
    };
    int far[2] = {0, 0}, most = 0;
    for (int i = 0; i < dims[0]; ++i)
        for (int j = 0; j < dims[1]; ++j)
            for (int k = 0; k < dims[2]; ++k) {
                long long nearest = 1LL << 40;
                bool alone = root(i, j, k) < VXS_VOXMAP_ENTRY_FIRST;
                for (int x = -20; x < 40; ++x)
                    for (int y = -20; y < 40; ++y)
                        for (int z = -20; z < 40; ++z) {
                            if (root(x, y, z) == root(i, j, k)) continue;
                            if (std::max({std::abs(x - i), std::abs(y - j), std::abs(z - k)}) <= 1)
                                alone = false;
                            nearest = std::min(nearest, squared({64 * i + 32, 64 * j + 32, 64 * k + 32},
                                                                {64 * x, 64 * y, 64 * z}, 64));
                        }
                std::uint32_t size = 0;
                const float radius = vxs_voxmap_clearance(&map, static_cast<std::uint32_t>(64 * i),
                                                          static_cast<std::uint32_t>(64 * j),
                                                          static_cast<std::uint32_t>(64 * k), &size);
                REQUIRE((size == 64) == alone);
                if (!alone) continue;
                const int expected = static_cast<int>(std::floor(std::sqrt(static_cast<double>(nearest))));
                const bool is_free = root(i, j, k) == VXS_CELL_FREE;
                REQUIRE(static_cast<int>(radius) == (is_free ? expected : -expected));
                ++far[is_free];
                most = std::max(most, expected);
            }
    CHECK(far[0] > 50);
    CHECK(far[1] > 50);
    CHECK(most > 250);
}

TEST_CASE("whether a map has a clearance is kept")
{
    VoxmapFile file = random_cells(3);
    for (const bool with : {false, true}) {
        file.clearance = with;
        const auto bytes = voxmap_bytes(file);
        const WrittenFile written(bytes);
        const VoxmapFile read = read_voxmap(written.path());
        CHECK(read.clearance == with);
        CHECK(voxmap_bytes(read) == bytes);
    }
}
