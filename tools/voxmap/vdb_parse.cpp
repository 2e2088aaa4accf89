// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/vdb_parse.hpp"
#include "cli/failure.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <optional>

namespace voxshell {
namespace {

using Tree = openvdb::Int32Tree;
using Leaf = Tree::LeafNodeType;

[[noreturn]] void refuse(const std::string &what)
{
    throw Failure(ExitCode::invalid, "", what);
}

std::string name(const openvdb::Coord &at)
{
    return fmt::format("({}, {}, {})", at[0], at[1], at[2]);
}

/// The voxel of a transform that is a uniform scale and puts index (0,0,0) at (h/2, h/2, h/2).
double voxel_of(const openvdb::math::Transform &transform)
{
    if (!transform.isLinear()) refuse("the transform of grid `state` is not linear");
    const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
    const double h = transform.indexToWorld(openvdb::Vec3d(1, 0, 0))[0] - origin[0];
    if (!std::isfinite(h) || h <= 0) refuse(fmt::format("the transform of grid `state` has a voxel of {}", h));
    for (int axis = -1; axis < 3; ++axis) {
        openvdb::Vec3d at(0, 0, 0), expected(h / 2);
        if (axis >= 0) {
            at[axis] = 1;
            expected[axis] += h;
        }
        const openvdb::Vec3d world = transform.indexToWorld(at);
        for (int a = 0; a < 3; ++a)
            if (!(std::abs(world[a] - expected[a]) <= 1e-9 * h))
                refuse(fmt::format("the transform of grid `state` is not a uniform scale with index (0, 0, 0) at half a voxel: "
                                   "index ({}, {}, {}) is at ({}, {}, {})",
                                   at[0], at[1], at[2], world[0], world[1], world[2]));
    }
    return h;
}

template <typename T> std::optional<T> value_of(const openvdb::MetaMap &map, const char *key)
{
    const auto found = map.getMetadata<openvdb::TypedMetadata<T>>(key);
    if (!found) return std::nullopt;
    return found->value();
}

Sha256 source_of(const openvdb::MetaMap &map)
{
    Sha256 hash{};
    const auto text = value_of<std::string>(map, vdb_meta_source);
    if (!text) return hash;
    const auto digit = [&](char c) -> unsigned {
        if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
        if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a' + 10);
        refuse("file metadata `source_sha256` is not 64 lower-case hexadecimal digits");
    };
    if (text->size() != 64) digit('?');
    for (std::size_t b = 0; b < hash.size(); ++b)
        hash[b] = static_cast<std::uint8_t>(digit((*text)[2 * b]) << 4 | digit((*text)[2 * b + 1]));
    return hash;
}

int state_of(openvdb::Int32 value, bool active, const openvdb::Coord &at)
{
    if (!active && value != VXS_CELL_FREE) refuse(fmt::format("cell {} is {} but not active", name(at), value));
    if (value < VXS_CELL_FREE || value > VXS_CELL_INTERIOR)
        refuse(fmt::format("cell {} holds {}: not 0 (free), 1 (surface) or 2 (interior)", name(at), value));
    return value;
}

/// A leaf's states. Both masks empty: nothing but free cells.
Brick brick_of(const Leaf &leaf)
{
    Brick brick;
    const Leaf::ValueType *values = leaf.buffer().data();
    if (!values) refuse(fmt::format("the values of the leaf at {} are missing", name(leaf.origin())));
    for (openvdb::Index c = 0; c < Leaf::SIZE; ++c) {
        if (values[c] == VXS_CELL_FREE) continue;
        const int state = state_of(values[c], leaf.isValueOn(c), leaf.offsetToGlobalCoord(c));
        (state == VXS_CELL_SURFACE ? brick.surface : brick.interior)[c >> 6] |= std::uint64_t{1} << (c & 63);
    }
    return brick;
}

/// A box of bricks, absolute, max inclusive.
struct Box {
    Cell min{INT64_MAX, INT64_MAX, INT64_MAX}, max{INT64_MIN, INT64_MIN, INT64_MIN};
    void grow(const openvdb::Coord &low, const openvdb::Coord &high)
    {
        for (int a = 0; a < 3; ++a) {
            if (low[a] < -vdb_max_index || high[a] > vdb_max_index || low[a] > high[a])
                refuse(fmt::format("cell {} to {} is beyond the limit of {} per axis", name(low), name(high), vdb_max_index));
            min[a] = std::min(min[a], std::int64_t{low[a]} >> 3);
            max[a] = std::max(max[a], std::int64_t{high[a]} >> 3);
        }
    }
};

using TileIterator = Tree::ValueAllCIter;

TileIterator tiles_of(const Tree &tree)
{
    TileIterator tile = tree.cbeginValueAll();
    tile.setMaxDepth(TileIterator::LEAF_DEPTH - 1);
    return tile;
}

/// Sets the box's origin; refuses what the format cannot hold, before a hostile tile of 4096^3 cells is spread out.
Box box_of(const Tree &tree)
{
    Box box;
    for (TileIterator tile = tiles_of(tree); tile; ++tile) {
        const openvdb::CoordBBox cells = tile.getBoundingBox();
        if (state_of(tile.getValue(), tile.isValueOn(), cells.min()) != VXS_CELL_FREE) box.grow(cells.min(), cells.max());
    }
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
        const Brick brick = brick_of(*leaf);
        if (brick.surface != std::array<std::uint64_t, 8>{} || brick.interior != std::array<std::uint64_t, 8>{})
            box.grow(leaf->origin(), leaf->origin().offsetBy(Leaf::DIM - 1));
    }
    if (box.min[0] > box.max[0]) refuse("grid `state` holds no surface cell");
    std::uint64_t root = 1;
    for (int a = 0; a < 3; ++a) {
        const std::int64_t chunks = (box.max[a] >> 3) - (box.min[a] >> 3) + 1;
        if (chunks > VXS_VOXMAP_MAX_CELLS / VXS_VOXMAP_CHUNK_CELLS)
            refuse(fmt::format("the box of grid `state` is {} cells long on axis {}: limit {}",
                               chunks * VXS_VOXMAP_CHUNK_CELLS, a, int{VXS_VOXMAP_MAX_CELLS}));
        root *= static_cast<std::uint64_t>(chunks);
    }
    if (root > VXS_VOXMAP_MAX_ROOT)
        refuse(fmt::format("the box of grid `state` has {} chunks of 64^3 cells: limit {}", root, int{VXS_VOXMAP_MAX_ROOT}));
    return box;
}

/// Sorts runs and joins those that touch.
void join(std::vector<SolidRun> &runs)
{
    std::sort(runs.begin(), runs.end(), [](const SolidRun &a, const SolidRun &b) {
        return BrickAt{a.i, a.j, a.first} < BrickAt{b.i, b.j, b.first};
    });
    std::size_t kept = 0;
    for (const SolidRun &run : runs) {
        if (kept && runs[kept - 1].i == run.i && runs[kept - 1].j == run.j && runs[kept - 1].last + 1 == run.first)
            runs[kept - 1].last = run.last;
        else
            runs[kept++] = run;
    }
    runs.resize(kept);
}

void fill(const Tree &tree, Cells &cells)
{
    const Box box = box_of(tree);
    for (int a = 0; a < 3; ++a) cells.origin[a] = (box.min[a] >> 3) * VXS_VOXMAP_CHUNK_CELLS;
    const auto relative = [&](const openvdb::Coord &at) {
        BrickAt brick;
        for (int a = 0; a < 3; ++a) brick[a] = static_cast<std::int32_t>((at[a] - cells.origin[a]) >> 3);
        return brick;
    };
    constexpr std::array<std::uint64_t, 8> none{}, all{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};
    for (TileIterator tile = tiles_of(tree); tile; ++tile) {
        if (tile.getValue() == VXS_CELL_FREE) continue;
        const openvdb::CoordBBox span = tile.getBoundingBox();
        const BrickAt low = relative(span.min()), high = relative(span.max());
        for (std::int32_t i = low[0]; i <= high[0]; ++i)
            for (std::int32_t j = low[1]; j <= high[1]; ++j) {
                if (tile.getValue() == VXS_CELL_INTERIOR) {
                    cells.solid.push_back({i, j, low[2], high[2]});
                    continue;
                }
                for (std::int32_t k = low[2]; k <= high[2]; ++k) cells.bricks.push_back({{i, j, k}, all, none});
            }
    }
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
        Brick brick = brick_of(*leaf);
        brick.at = relative(leaf->origin());
        if (brick.interior == all)
            cells.solid.push_back({brick.at[0], brick.at[1], brick.at[2], brick.at[2]});
        else if (brick.surface != none || brick.interior != none)
            cells.bricks.push_back(brick);
    }
    std::sort(cells.bricks.begin(), cells.bricks.end(), [](const Brick &a, const Brick &b) { return a.at < b.at; });
    join(cells.solid);
}

} // namespace

VdbFile parse_vdb(const std::filesystem::path &path)
{
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(false); // delayed loading would copy the file and fail later
    if (!file.hasGrid(vdb_grid_name)) refuse("has no grid `state`: not a voxmap");
    const openvdb::GridBase::Ptr base = file.readGrid(vdb_grid_name);
    const auto grid = openvdb::gridPtrCast<openvdb::Int32Grid>(base);
    if (!grid) refuse(fmt::format("grid `state` is of type {}, not Int32", base ? base->valueType() : "none"));
    if (grid->background() != VXS_CELL_FREE) refuse(fmt::format("grid `state` has background {}, not 0", grid->background()));

    VdbFile result;
    const openvdb::MetaMap::Ptr owner = file.getMetadata();
    const openvdb::MetaMap &metadata = *owner;
    const std::string unit = value_of<std::string>(metadata, vdb_meta_unit).value_or("m");
    const auto known = std::find_if(vdb_units.begin(), vdb_units.end(), [&](const VdbUnit &u) { return u.name == unit; });
    if (known == vdb_units.end()) refuse("file metadata `unit` is none of m, mm, um, nm");
    const double scale = voxel_of(grid->transform()) * known->metres;
    result.cells.voxel = value_of<double>(metadata, vdb_meta_voxel).value_or(scale);
    if (!(std::abs(result.cells.voxel - scale) <= 1e-9 * scale))
        refuse(fmt::format("file metadata `voxel` is {} m, the transform of grid `state` says {} m", result.cells.voxel, scale));
    result.cells.closed = value_of<bool>(metadata, vdb_meta_closed).value_or(false);
    result.source_hash = source_of(metadata);
    result.meta = value_of<std::string>(metadata, vdb_meta_options).value_or("{}");
    if (result.meta.size() > vdb_max_meta) refuse(fmt::format("file metadata `options` has {} bytes", result.meta.size()));
    fill(grid->tree(), result.cells);
    return result;
}

} // namespace voxshell
