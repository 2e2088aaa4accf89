// SPDX-License-Identifier: GPL-3.0-or-later
// The .vdb: without loss, reproducible, readable by OpenVDB's own tools, and never the death of its reader.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "cli/failure.hpp"
#include "voxmap/channels.hpp"
#include "voxmap/classify.hpp"
#include "voxmap/vdb.hpp"
#include "voxmap/voxelize.hpp"
#include "voxmap/voxmap_file.hpp"

#include "solids.hpp"

#include <algorithm>
#include <chrono>
#include <doctest/doctest.h>
#include <filesystem>
#include <fstream>
#include <random>
#include <unistd.h>

using namespace voxshell;

namespace {

struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("voxshell_test_vdb." + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
    std::filesystem::path write(const char *name, const std::vector<std::uint8_t> &bytes) const
    {
        std::ofstream(path / name, std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        return path / name;
    }
};

Cells cells_of(const Mesh &mesh, double voxel)
{
    Progress silent;
    const LatticeMesh lattice = snap(mesh, voxel);
    Cells cells = voxelize(lattice, bin_triangles(lattice, silent), silent);
    classify(cells, WindingNumber(mesh), silent);
    cells.closed = true;
    return cells;
}

/// A box of whole cells from `low` to `high`, exclusive: surface on its six sides, interior within. Built
/// without the voxeliser, so that it can be as large as memory forbids to fill.
Cells box_of_cells(const Cell &low, const Cell &high, double voxel)
{
    Cells cells;
    cells.voxel = voxel;
    for (int a = 0; a < 3; ++a) cells.origin[a] = (low[a] >> 6) * 64;
    const auto depth = [&](int axis, std::int64_t at) {
        return at < low[axis] || at >= high[axis] ? 0 : at == low[axis] || at == high[axis] - 1 ? 1 : 2;
    };
    BrickAt last{};
    for (int a = 0; a < 3; ++a) last[a] = static_cast<std::int32_t>((high[a] - 1 - cells.origin[a]) >> 3);
    for (std::int32_t i = 0; i <= last[0]; ++i)
        for (std::int32_t j = 0; j <= last[1]; ++j) {
            std::int32_t first = -1;
            for (std::int32_t k = 0; k <= last[2]; ++k) {
                Brick brick{{i, j, k}, {}, {}};
                const Cell corner{cells.origin[0] + 8 * i, cells.origin[1] + 8 * j, cells.origin[2] + 8 * k};
                bool solid = true;
                for (int a = 0; a < 3; ++a) solid = solid && corner[a] > low[a] && corner[a] + 8 < high[a];
                if (solid) {
                    if (first < 0) first = k;
                    continue;
                }
                if (first >= 0) cells.solid.push_back({i, j, first, k - 1});
                first = -1;
                bool any = false;
                for (int c = 0; c < 512; ++c) {
                    const int d =
                        std::min({depth(0, corner[0] + (c >> 6)), depth(1, corner[1] + (c >> 3 & 7)),
                                  depth(2, corner[2] + (c & 7))});
                    if (d == 0) continue;
                    any = true;
                    (d == 1 ? brick.surface : brick.interior)[static_cast<std::size_t>(c >> 6)] |=
                        std::uint64_t{1} << (c & 63);
                }
                if (any) cells.bricks.push_back(brick);
            }
        }
    recount(cells);
    return cells;
}

void check_equal(const Cells &a, const Cells &b)
{
    CHECK(a.voxel == b.voxel);
    CHECK(a.origin == b.origin);
    CHECK(a.closed == b.closed);
    CHECK(a.surface_cells == b.surface_cells);
    CHECK(a.interior_cells == b.interior_cells);
    CHECK(a.min == b.min);
    CHECK(a.max == b.max);
    CHECK(a.solid == b.solid);
    REQUIRE(a.bricks.size() == b.bricks.size());
    CHECK(std::equal(
        a.bricks.begin(), a.bricks.end(), b.bricks.begin(), [](const Brick &one, const Brick &other) {
            return one.at == other.at && one.surface == other.surface && one.interior == other.interior;
        }));
}

ExitCode code_of(const std::filesystem::path &path)
{
    try {
        read_vdb(path);
    } catch (const Failure &failure) {
        CHECK(failure.file == path.string());
        CHECK(std::string(failure.what()).find('\n') == std::string::npos);
        return failure.code;
    }
    return ExitCode::ok;
}

Sha256 some_hash()
{
    Sha256 hash;
    for (std::size_t b = 0; b < hash.size(); ++b) hash[b] = static_cast<std::uint8_t>(17 * b + 3);
    return hash;
}

const Folder folder;

} // namespace

TEST_CASE("cells survive the way through a .vdb, and the bytes are the same each time")
{
    const struct {
        const char *what;
        Mesh mesh;
        double voxel;
    } parts[] = {
        {"a ball", solids::sphere({0, 0, 0}, 0.02), 0.0005},
        {"off the origin, odd voxel", solids::sphere({-1.7, 2.3, 0.4}, 0.02), 0.000377},
        {"a hollow ball",
         solids::join(solids::sphere({0, 0, 0}, 0.03),
                      solids::turned_inside_out(solids::sphere({0, 0, 0}, 0.02))),
         0.001},
        {"a plate on grid planes", solids::box({0, 0, 0}, {0.1, 0.001, 0.1}), 0.001},
        {"one cell", solids::box({0.1, 0.1, 0.1}, {0.2, 0.2, 0.2}), 1},
        {"small", solids::sphere({0, 0, 0}, 1e-6), 1e-7},
        {"smallest voxel", solids::sphere({0, 0, 0}, 2e-11), 1e-12},
        {"large", solids::sphere({1e4, 0, 0}, 500), 20},
    };
    for (const auto &part : parts) {
        CAPTURE(part.what);
        const Cells cells = cells_of(part.mesh, part.voxel);
        const auto bytes = vdb_bytes(cells, some_hash(), R"({"tool":"test"})");
        CHECK(bytes == vdb_bytes(cells, some_hash(), R"({"tool":"test"})"));
        CHECK(vdb_uuid_matches(bytes));
        const VdbFile back = read_vdb(folder.write("part.vdb", bytes));
        check_equal(cells, back.cells);
        CHECK(back.source_hash == some_hash());
        CHECK(back.meta == R"({"tool":"test"})");
        CHECK(vdb_bytes(back.cells, back.source_hash, back.meta) == bytes);
    }
}

TEST_CASE("how the cells are held does not show in the bytes")
{
    const Cells cells = box_of_cells({0, 0, 0}, {400, 300, 200}, 0.001);
    Cells loose = cells;
    REQUIRE(loose.solid.size() > 2);
    std::array<std::uint64_t, 8> all;
    all.fill(~0ull);
    for (const SolidRun run :
         {loose.solid.back(), loose.solid.front()}) // bricks that are solid, bricks that are empty
        for (std::int32_t k = run.first; k <= run.last; ++k)
            loose.bricks.push_back({{run.i, run.j, k}, {}, all});
    loose.solid.pop_back();
    loose.solid.erase(loose.solid.begin());
    loose.bricks.push_back({{0, 0, 60}, {}, {}});
    std::sort(loose.bricks.begin(), loose.bricks.end(),
              [](const Brick &a, const Brick &b) { return a.at < b.at; });
    CHECK(vdb_bytes(loose, some_hash(), "{}") == vdb_bytes(cells, some_hash(), "{}"));
}

TEST_CASE("interior cells may end in a brick without surface: a gap that was closed")
{
    Cells cells = box_of_cells({0, 0, 0}, {64, 64, 64}, 0.001);
    Brick half{{7, 7, 8}, {}, {}};
    half.interior[3] = 0xff;
    cells.bricks.push_back(half);
    recount(cells);
    check_equal(cells, read_vdb(folder.write("gap.vdb", vdb_bytes(cells, some_hash(), "{}"))).cells);
}

TEST_CASE("channels survive as grids of their own")
{
    const struct {
        const char *what;
        Mesh mesh;
        double voxel;
        ChannelRequest request;
    } parts[] = {
        {"both", solids::sphere({0.3, -0.2, 0.1}, 0.05), 0.001, {4, 3}},
        {"layers", solids::box({0, 0, 0}, {0.1, 0.02, 0.05}), 0.001, {8, 0}},
        {"distance",
         solids::join(solids::sphere({0, 0, 0}, 0.03),
                      solids::turned_inside_out(solids::sphere({0, 0, 0}, 0.02))),
         0.001,
         {0, 7}},
        {"tiny voxel", solids::sphere({0, 0, 0}, 1e-6), 5e-8, {2, 2}},
    };
    for (const auto &part : parts) {
        CAPTURE(part.what);
        Progress silent;
        const LatticeMesh lattice = snap(part.mesh, part.voxel);
        const BrickTriangles binned = bin_triangles(lattice, silent);
        Cells cells = cells_of(part.mesh, part.voxel);
        VoxmapFile map;
        map.channels =
            make_channels(cells, lattice, binned, WindingNumber(part.mesh), true, part.request, silent);
        map.cells = cells;
        map.source_hash = some_hash();
        const auto packed = voxmap_bytes(map);
        const VoxmapFile back = read_voxmap(folder.write("channels.voxmap", packed));
        const auto bytes = vdb_bytes(back.cells, back.source_hash, back.meta, back.channels);
        const VdbFile vdb = read_vdb(folder.write("channels.vdb", bytes));
        check_equal(back.cells, vdb.cells);
        CHECK(vdb.channels.layer == back.channels.layer);
        CHECK(vdb.channels.distance == back.channels.distance);
        CHECK(voxmap_bytes({vdb.cells, vdb.channels, vdb.source_hash, vdb.meta}) == packed);
        CHECK(vdb_bytes(vdb.cells, vdb.source_hash, vdb.meta, vdb.channels) == bytes);
    }
}

TEST_CASE("other content, other UUID")
{
    Cells cells = box_of_cells({0, 0, 0}, {20, 20, 20}, 0.001);
    const auto bytes = vdb_bytes(cells, some_hash(), "{}");
    const auto uuid = [](const std::vector<std::uint8_t> &b) {
        return std::string(b.begin() + 21, b.begin() + 57);
    };
    CHECK(uuid(bytes)[14] == '8');
    cells.closed = true;
    CHECK(uuid(vdb_bytes(cells, some_hash(), "{}")) != uuid(bytes));
    auto changed = bytes;
    changed.back() ^= 1;
    CHECK_FALSE(vdb_uuid_matches(changed));
    CHECK_FALSE(vdb_uuid_matches(std::vector<std::uint8_t>(40)));
}

TEST_CASE("solid cells cost their surface, not their volume")
{
    const Cells cells = box_of_cells({-700, -3, 5}, {-100, 597, 605}, 0.0001); // 2e8 interior cells
    REQUIRE(cells.interior_cells == 598ull * 598 * 598);
    const auto start = std::chrono::steady_clock::now();
    const auto bytes = vdb_bytes(cells, some_hash(), "{}");
    CHECK(bytes.size() < 24 * cells.surface_cells);
    const VdbFile back = read_vdb(folder.write("solid.vdb", bytes));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    MESSAGE(cells.surface_cells, " surface cells, ", bytes.size(), " bytes, ", took.count(),
            " s there and back");
    check_equal(cells, back.cells);
}

TEST_CASE("an index that does not fit 32 bits is refused before anything is written")
{
    const std::int64_t far = std::int64_t{1} << 31;
    CHECK_THROWS_AS(vdb_bytes(box_of_cells({far, 0, 0}, {far + 8, 8, 8}, 0.001), some_hash(), "{}"), Failure);
    const Cells edge = box_of_cells({-(1ll << 30), 0, 0}, {-(1ll << 30) + 9, 8, 8}, 0.001);
    check_equal(edge, read_vdb(folder.write("edge.vdb", vdb_bytes(edge, some_hash(), "{}"))).cells);
}

TEST_CASE("what is not a .vdb is refused in one line")
{
    CHECK(code_of(folder.path / "missing.vdb") == ExitCode::system);
    CHECK(code_of(folder.path) == ExitCode::system);
    CHECK(code_of(folder.write("empty.vdb", {})) == ExitCode::invalid);
    CHECK(code_of(folder.write("text.vdb", std::vector<std::uint8_t>(500, 'a'))) == ExitCode::invalid);
}

TEST_CASE("a truncated file is refused, wherever it ends")
{
    const auto bytes = vdb_bytes(box_of_cells({0, 0, 0}, {40, 40, 40}, 0.001), some_hash(), "{}");
    for (std::size_t size = 0; size < bytes.size(); size += size < 1500 ? 37 : bytes.size() / 23) {
        CAPTURE(size);
        CHECK(code_of(folder.write("cut.vdb",
                                   {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)})) ==
              ExitCode::invalid);
    }
}

TEST_CASE("flipped bits never end in a crash or a hang of the caller")
{
    const auto bytes = vdb_bytes(box_of_cells({0, 0, 0}, {140, 20, 20}, 0.001), some_hash(), "{}");
    std::mt19937 random(7);
    const auto start = std::chrono::steady_clock::now();
    int refused = 0, read = 0;
    for (int trial = 0; trial < 100; ++trial) {
        auto damaged = bytes;
        const int flips = 1 + trial % 4;
        // Headers, metadata and topology are in the first bytes: hit those most of the time.
        const std::size_t reach = trial % 3 ? std::min<std::size_t>(1400, bytes.size()) : bytes.size();
        for (int f = 0; f < flips; ++f)
            damaged[8 + random() % (reach - 8)] ^= static_cast<std::uint8_t>(1u << random() % 8);
        CAPTURE(trial);
        const ExitCode code = code_of(folder.write("flipped.vdb", damaged));
        CHECK((code == ExitCode::ok || code == ExitCode::invalid));
        ++(code == ExitCode::ok ? read : refused);
        if (damaged != bytes) CHECK_FALSE(vdb_uuid_matches(damaged));
    }
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
    MESSAGE(refused, " refused, ", read, " read, ", took.count(), " s");
    CHECK(refused > 0);
}
