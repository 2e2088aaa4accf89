// SPDX-License-Identifier: GPL-3.0-or-later
// The .nvdb as NanoVDB's own readers see it, in C++ and in C, cell by cell.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "voxmap/channels.hpp"
#include "voxmap/classify.hpp"
#include "voxmap/nvdb.hpp"
#include "voxmap/voxelize.hpp"
#include "voxmap/voxmap_file.hpp"

#include "pnanovdb_values.h"
#include "solids.hpp"

#include <cstring>
#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>
#include <nanovdb/util/GridValidator.h>
#include <nanovdb/util/IO.h>
#include <tbb/global_control.h>
#include <unistd.h>

using namespace voxshell;

namespace {

struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("voxshell_test_nvdb." + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
    std::filesystem::path write(const char *name, const std::vector<std::uint8_t> &bytes) const
    {
        std::ofstream(path / name, std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        return path / name;
    }
};

const Folder folder;

/// As the runtime would get it: through a .voxmap, in whose bricks the channels speak.
VoxmapFile map_of(const Mesh &mesh, double voxel, const ChannelRequest &request)
{
    Progress silent;
    const LatticeMesh lattice = snap(mesh, voxel);
    const BrickTriangles binned = bin_triangles(lattice, silent);
    const WindingNumber winding(mesh);
    VoxmapFile map;
    map.cells = voxelize(lattice, binned, silent);
    classify(map.cells, winding, silent);
    map.cells.closed = true;
    if (request.layers > 0 || request.distance_cells > 0)
        map.channels = make_channels(map.cells, lattice, binned, winding, true, request, silent);
    return read_voxmap(folder.write("map.voxmap", voxmap_bytes(map)));
}

template<typename Visit>
void each_cell(const Cells &cells, Visit visit)
{
    for (std::int64_t i = cells.min[0] - 9; i <= cells.max[0] + 9; ++i)
        for (std::int64_t j = cells.min[1] - 9; j <= cells.max[1] + 9; ++j)
            for (std::int64_t k = cells.min[2] - 9; k <= cells.max[2] + 9; ++k) visit(Cell{i, j, k});
}

/// A channel's value of a cell by the format: stored, or beyond with the sign of the state.
template<typename T>
double channel_value(const VoxmapFile &map, const std::vector<std::array<T, 512>> &channel, const Cell &at,
                     double beyond)
{
    BrickAt brick;
    for (std::size_t a = 0; a < 3; ++a)
        brick[a] = static_cast<std::int32_t>((at[a] - map.cells.origin[a]) >> 3);
    const auto found = std::lower_bound(map.cells.bricks.begin(), map.cells.bricks.end(), brick,
                                        [](const Brick &b, const BrickAt &key) { return b.at < key; });
    if (found == map.cells.bricks.end() || found->at != brick)
        return cell_state(map.cells, at) == VXS_CELL_INTERIOR ? -beyond : beyond;
    return channel[static_cast<std::size_t>(found - map.cells.bricks.begin())][vxs_voxmap_brick_cell(
        static_cast<std::uint32_t>(at[0] & 7), static_cast<std::uint32_t>(at[1] & 7),
        static_cast<std::uint32_t>(at[2] & 7))];
}

template<typename Value>
const nanovdb::NanoGrid<Value> *grid_of(const nanovdb::GridHandle<> &handle)
{
    const auto *grid = handle.grid<Value>();
    REQUIRE(grid);
    CHECK(nanovdb::isValid(*grid, true));
    CHECK(grid->hasMinMax());
    CHECK(grid->hasBBox());
    return grid;
}

} // namespace

TEST_CASE("NanoVDB's readers see every cell and every channel, through tiles and at negative indices")
{
    const struct {
        const char *what;
        Mesh mesh;
        double voxel;
        ChannelRequest request;
    } parts[] = {
        {"a ball around the origin", solids::sphere({0, 0, 0}, 0.04), 0.001, {}},
        {"a box of solid tiles at negative indices",
         solids::box({-0.3, -0.25, -0.2}, {-0.05, 0.01, 0.011}),
         0.004,
         {}},
        {"solid blocks of 128^3 cells", solids::box({-0.2, -0.1, -0.2}, {0.2, 0.3, 0.2}), 0.0015, {}},
        {"a hollow ball with channels",
         solids::join(solids::sphere({0, 0.1, 0}, 0.03),
                      solids::turned_inside_out(solids::sphere({0, 0.1, 0}, 0.02))),
         0.001,
         {3, 4}},
        {"finer than OpenVDB's transforms", solids::sphere({0, 0, 0}, 2e-8), 1e-9, {2, 2}},
    };
    for (const auto &part : parts) {
        CAPTURE(part.what);
        const VoxmapFile map = map_of(part.mesh, part.voxel, part.request);
        const Cells &cells = map.cells;
        const auto bytes = nvdb_bytes(cells, map.channels);
        const auto path = folder.write("part.nvdb", bytes);
        const auto handles = nanovdb::io::readGrids(path.string());
        REQUIRE(handles.size() == (part.request.layers ? 3 : 1));

        const auto *state = grid_of<std::int32_t>(handles[0]);
        CHECK(std::string(state->gridName()) == "state");
        CHECK(state->activeVoxelCount() == cells.surface_cells + cells.interior_cells);
        const auto accessor = state->getAccessor();
        std::uint64_t wrong = 0;
        each_cell(cells, [&](const Cell &at) {
            const int i = static_cast<int>(at[0]), j = static_cast<int>(at[1]), k = static_cast<int>(at[2]);
            const int expected = cell_state(cells, at);
            wrong += accessor.getValue(nanovdb::Coord(i, j, k)) != expected ||
                     pnanovdb_int(handles[0].data(), i, j, k) != expected ||
                     accessor.isActive(nanovdb::Coord(i, j, k)) != (expected != VXS_CELL_FREE);
        });
        CHECK(wrong == 0);
        for (int a = 0; a < 3; ++a) {
            CHECK(state->indexBBox().min()[a] == cells.min[static_cast<std::size_t>(a)]);
            CHECK(state->indexBBox().max()[a] == cells.max[static_cast<std::size_t>(a)]);
        }
        const nanovdb::Vec3d center = state->indexToWorld(nanovdb::Vec3d(-3, 0, 7));
        const float index[3] = {-3, 0, 7};
        float world[3];
        pnanovdb_world(handles[0].data(), index, world);
        const double expected[3] = {-2.5 * part.voxel, 0.5 * part.voxel, 7.5 * part.voxel};
        for (int a = 0; a < 3; ++a) {
            CHECK(std::abs(center[a] - expected[a]) < 1e-12 * part.voxel);
            CHECK(std::abs(static_cast<double>(world[a]) - expected[a]) < 1e-5 * part.voxel);
            CHECK(state->voxelSize()[a] == part.voxel);
        }
        if (!part.request.layers) continue;

        const auto *layer = grid_of<std::int32_t>(handles[1]);
        const auto *distance = grid_of<float>(handles[2]);
        CHECK(std::string(layer->gridName()) == "layer");
        CHECK(std::string(distance->gridName()) == "distance");
        CHECK(distance->isLevelSet());
        const auto layers = layer->getAccessor();
        const auto distances = distance->getAccessor();
        std::uint64_t wrong_layers = 0, wrong_distances = 0;
        const Channels &channels = map.channels;
        each_cell(cells, [&](const Cell &at) {
            const int i = static_cast<int>(at[0]), j = static_cast<int>(at[1]), k = static_cast<int>(at[2]);
            const auto ring =
                static_cast<int>(channel_value(map, channels.layer, at, channels.layer_count + 1));
            wrong_layers += layers.getValue(nanovdb::Coord(i, j, k)) != ring ||
                            pnanovdb_int(handles[1].data(), i, j, k) != ring;
            const double beyond = channels.distance_band / channels.distance_step;
            const double expected_distance =
                channel_value(map, channels.distance, at, beyond) * channels.distance_step;
            const float got = distances.getValue(nanovdb::Coord(i, j, k));
            wrong_distances += got != static_cast<float>(expected_distance) ||
                               pnanovdb_float(handles[2].data(), i, j, k) != got;
        });
        CHECK(wrong_layers == 0);
        CHECK(wrong_distances == 0);
    }
}

TEST_CASE("the same bytes each time, whatever was in memory and however many threads")
{
    const VoxmapFile map = map_of(solids::sphere({0, 0, 0}, 0.05), 0.001, {2, 3});
    const auto bytes = nvdb_bytes(map.cells, map.channels);
    for (const std::size_t threads : {1, 2, 7}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        std::vector<std::vector<std::uint8_t>> dirt; // freed, and then found again by whoever does not clear
        for (int block = 0; block < 64; ++block)
            dirt.emplace_back(bytes.size() / 64, static_cast<std::uint8_t>(0x5a + block));
        std::vector<std::uint8_t> large(2 * bytes.size(), 0xa5);
        CHECK(large.back() == 0xa5);
        dirt.clear();
        large = {};
        CHECK(nvdb_bytes(map.cells, map.channels) == bytes);
    }
}
