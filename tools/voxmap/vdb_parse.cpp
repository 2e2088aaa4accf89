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

/// Min corners of the leaves of the channels, which have the same ones.
using Leaves = std::vector<openvdb::Coord>;

/// Refuses what the format cannot hold, before a hostile tile of 4096^3 cells is spread out.
Box box_of(const Tree &tree, const Leaves &spoken)
{
    Box box;
    for (const openvdb::Coord &leaf : spoken) box.grow(leaf, leaf.offsetBy(Leaf::DIM - 1));
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

constexpr std::array<std::uint64_t, 8> none{}, all{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};

BrickAt relative(const Cells &cells, const openvdb::Coord &at)
{
    BrickAt brick;
    for (int a = 0; a < 3; ++a) brick[a] = static_cast<std::int32_t>((at[a] - cells.origin[a]) >> 3);
    return brick;
}

bool before(const Brick &a, const Brick &b)
{
    return a.at < b.at;
}

/// Makes bricks of what the channels speak in and the state holds as tiles or not at all.
void add_spoken(const Leaves &spoken, Cells &cells)
{
    std::vector<BrickAt> extra;
    for (const openvdb::Coord &leaf : spoken) {
        const BrickAt at = relative(cells, leaf);
        if (!std::binary_search(cells.bricks.begin(), cells.bricks.end(), Brick{at, {}, {}}, before)) extra.push_back(at);
    }
    std::sort(extra.begin(), extra.end());
    std::vector<SolidRun> solid;
    std::vector<Brick> bricks;
    auto next = extra.begin();
    for (SolidRun run : cells.solid) {
        for (; next != extra.end() && *next < BrickAt{run.i, run.j, run.first}; ++next) bricks.push_back({*next, none, none});
        for (; next != extra.end() && *next <= BrickAt{run.i, run.j, run.last}; ++next) {
            bricks.push_back({*next, none, all});
            if (run.first < (*next)[2]) solid.push_back({run.i, run.j, run.first, (*next)[2] - 1});
            run.first = (*next)[2] + 1;
        }
        if (run.first <= run.last) solid.push_back(run);
    }
    for (; next != extra.end(); ++next) bricks.push_back({*next, none, none});
    cells.solid = std::move(solid);
    cells.bricks.insert(cells.bricks.end(), bricks.begin(), bricks.end());
    std::sort(cells.bricks.begin(), cells.bricks.end(), before);
}

void fill(const Tree &tree, const Leaves &spoken, Cells &cells)
{
    const Box box = box_of(tree, spoken);
    for (int a = 0; a < 3; ++a) cells.origin[a] = (box.min[a] >> 3) * VXS_VOXMAP_CHUNK_CELLS;
    for (TileIterator tile = tiles_of(tree); tile; ++tile) {
        if (tile.getValue() == VXS_CELL_FREE) continue;
        const openvdb::CoordBBox span = tile.getBoundingBox();
        const BrickAt low = relative(cells, span.min()), high = relative(cells, span.max());
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
        brick.at = relative(cells, leaf->origin());
        if (brick.interior == all)
            cells.solid.push_back({brick.at[0], brick.at[1], brick.at[2], brick.at[2]});
        else if (brick.surface != none || brick.interior != none)
            cells.bricks.push_back(brick);
    }
    std::sort(cells.bricks.begin(), cells.bricks.end(), before);
    join(cells.solid);
    add_spoken(spoken, cells);
}

template <typename Grid> typename Grid::Ptr read_grid(openvdb::io::File &file, const char *name)
{
    const openvdb::GridBase::Ptr base = file.readGrid(name);
    const auto grid = openvdb::gridPtrCast<Grid>(base);
    if (!grid) refuse(fmt::format("grid `{}` is of type {}, not {}", name, base ? base->valueType() : "none", openvdb::typeNameAsString<typename Grid::ValueType>()));
    return grid;
}

template <typename Grid> Leaves leaves_of(const Grid &grid)
{
    Leaves leaves;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) leaves.push_back(leaf->origin());
    std::sort(leaves.begin(), leaves.end());
    return leaves;
}

int state_of(const Brick &brick, std::size_t c)
{
    return brick.surface[c >> 6] >> (c & 63) & 1    ? VXS_CELL_SURFACE
           : brick.interior[c >> 6] >> (c & 63) & 1 ? VXS_CELL_INTERIOR
                                                    : VXS_CELL_FREE;
}

/// The channel's values in brick order. `stored(value, state, cell)` turns one into what a voxmap stores, or refuses.
template <typename T, typename Grid, typename Stored>
std::vector<std::array<T, 512>> channel_of(const Grid &grid, const Cells &cells, Stored stored)
{
    std::vector<std::array<T, 512>> channel(cells.bricks.size());
    std::size_t seen = 0;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf, ++seen) {
        const auto *values = leaf->buffer().data();
        const auto brick = std::lower_bound(cells.bricks.begin(), cells.bricks.end(), Brick{relative(cells, leaf->origin()), {}, {}}, before);
        if (!values || brick == cells.bricks.end()) refuse(fmt::format("the leaf of grid `{}` at {} is damaged", grid.getName(), name(leaf->origin())));
        for (openvdb::Index c = 0; c < 512; ++c)
            channel[static_cast<std::size_t>(brick - cells.bricks.begin())][c] =
                stored(values[c], state_of(*brick, c), leaf->offsetToGlobalCoord(c));
    }
    if (seen != cells.bricks.size())
        refuse(fmt::format("grid `{}` has {} leaves for {} bricks that hold surface or are spoken of", grid.getName(), seen, cells.bricks.size()));
    return channel;
}

[[noreturn]] void refuse_value(const char *grid, double value, int state, const openvdb::Coord &at)
{
    refuse(fmt::format("grid `{}` says {} of cell {}, whose state is {}", grid, value, name(at), state));
}

void read_layers(const openvdb::Int32Grid &grid, const openvdb::MetaMap &metadata, VdbFile &file)
{
    const int count = value_of<openvdb::Int32>(metadata, vdb_meta_layers).value_or(0);
    if (count < 1 || count > VXS_VOXMAP_MAX_LAYERS) refuse(fmt::format("file metadata `layer_count` is {}", count));
    file.channels.layer_count = count;
    file.channels.layer = channel_of<std::int8_t>(grid, file.cells, [&](openvdb::Int32 value, int state, const openvdb::Coord &at) {
        const int sign = state == VXS_CELL_SURFACE ? 0 : state == VXS_CELL_FREE ? 1 : -1;
        if ((value > 0) - (value < 0) != sign || std::abs(std::int64_t{value}) > count + 1) refuse_value(vdb_layer_grid, value, state, at);
        return static_cast<std::int8_t>(value);
    });
}

void read_distances(const openvdb::FloatGrid &grid, const openvdb::MetaMap &metadata, double unit, VdbFile &file)
{
    Channels &channels = file.channels;
    channels.distance_step = value_of<double>(metadata, vdb_meta_step).value_or(0);
    channels.distance_band = value_of<double>(metadata, vdb_meta_band).value_or(0);
    channels.distance_error = value_of<double>(metadata, vdb_meta_error).value_or(-1);
    channels.unsigned_distance = value_of<bool>(metadata, vdb_meta_unsigned).value_or(false);
    const double step = channels.distance_step, most = std::round(channels.distance_band / step);
    if (!(step >= 1e-30 && most >= 1 && most <= 32767 && channels.distance_error >= 0 && channels.distance_error < 1e30))
        refuse("file metadata `distance_step`, `distance_band`, `distance_error` are missing or make no sense");
    channels.distance = channel_of<std::int16_t>(grid, file.cells, [&](float value, int state, const openvdb::Coord &at) {
        const double steps = std::round(double{value} * unit / step);
        const bool sign = channels.unsigned_distance ? steps >= 0 : state == VXS_CELL_FREE ? steps >= 0 : state == VXS_CELL_SURFACE || steps <= 0;
        if (!(std::abs(steps) <= most) || !sign) refuse_value(vdb_distance_grid, double{value}, state, at);
        return static_cast<std::int16_t>(steps);
    });
}

/// Reads the optional grids, then the cells, which are told by both.
void read_grids(openvdb::io::File &file, const openvdb::Int32Grid &state, const openvdb::MetaMap &metadata, double unit, VdbFile &result)
{
    const auto layer = file.hasGrid(vdb_layer_grid) ? read_grid<openvdb::Int32Grid>(file, vdb_layer_grid) : nullptr;
    const auto distance = file.hasGrid(vdb_distance_grid) ? read_grid<openvdb::FloatGrid>(file, vdb_distance_grid) : nullptr;
    const Leaves spoken = layer ? leaves_of(*layer) : distance ? leaves_of(*distance) : Leaves{};
    fill(state.tree(), spoken, result.cells);
    if (layer) read_layers(*layer, metadata, result);
    if (distance) read_distances(*distance, metadata, unit, result);
}

} // namespace

VdbFile parse_vdb(const std::filesystem::path &path)
{
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(false); // delayed loading would copy the file and fail later
    if (!file.hasGrid(vdb_grid_name)) refuse("has no grid `state`: not a voxmap");
    const auto grid = read_grid<openvdb::Int32Grid>(file, vdb_grid_name);
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
    read_grids(file, *grid, metadata, known->metres, result);
    return result;
}

} // namespace voxshell
