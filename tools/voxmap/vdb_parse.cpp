// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/vdb_parse.hpp"
#include "cli/failure.hpp"
#include "voxmap/vdb_cells.hpp"
#include "voxmap/vdb_child.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/core.h>
#include <string_view>

namespace voxshell {

void refuse_vdb(const std::string &what)
{
    throw Failure(ExitCode::invalid, "", what);
}

std::string text_of(const openvdb::Coord &at)
{
    return fmt::format("({}, {}, {})", at[0], at[1], at[2]);
}

std::optional<double> unit_of(const openvdb::MetaMap &metadata)
{
    const auto unit = value_of<std::string>(metadata, vdb_meta_unit);
    const auto known = std::find_if(vdb_units.begin(), vdb_units.end(),
                                    [&](const VdbUnit &u) { return unit && u.name == *unit; });
    if (known == vdb_units.end()) return std::nullopt;
    return known->metres;
}

namespace {

using Tree = openvdb::Int32Tree;
using Leaf = Tree::LeafNodeType;

/// The voxel of a transform that is a uniform scale and puts index (0,0,0) at (h/2, h/2, h/2).
double voxel_of(const openvdb::math::Transform &transform)
{
    if (!transform.isLinear()) refuse_vdb("the transform of grid `state` is not linear");
    const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
    const double h = transform.indexToWorld(openvdb::Vec3d(1, 0, 0))[0] - origin[0];
    if (!std::isfinite(h) || h <= 0)
        refuse_vdb(fmt::format("the transform of grid `state` has a voxel of {}", h));
    for (int axis = -1; axis < 3; ++axis) {
        openvdb::Vec3d at(0, 0, 0), expected(h / 2);
        if (axis >= 0) {
            at[axis] = 1;
            expected[axis] += h;
        }
        const openvdb::Vec3d world = transform.indexToWorld(at);
        for (int a = 0; a < 3; ++a)
            if (!(std::abs(world[a] - expected[a]) <= 1e-9 * h))
                refuse_vdb(fmt::format("the transform of grid `state` is not a uniform scale with index (0, "
                                       "0, 0) at half a voxel: "
                                       "index ({}, {}, {}) is at ({}, {}, {})",
                                       at[0], at[1], at[2], world[0], world[1], world[2]));
    }
    return h;
}

Sha256 source_of(const openvdb::MetaMap &map)
{
    Sha256 hash{};
    const auto text = value_of<std::string>(map, vdb_meta_source);
    if (!text) return hash;
    const auto digit = [&](char c) -> unsigned {
        if (c >= '0' && c <= '9') return static_cast<unsigned>(c - '0');
        if (c >= 'a' && c <= 'f') return static_cast<unsigned>(c - 'a' + 10);
        refuse_vdb("file metadata `source_sha256` is not 64 lower-case hexadecimal digits");
    };
    if (text->size() != 64) digit('?');
    for (std::size_t b = 0; b < hash.size(); ++b)
        hash[b] = static_cast<std::uint8_t>(digit((*text)[2 * b]) << 4 | digit((*text)[2 * b + 1]));
    return hash;
}

int state_of(openvdb::Int32 value, bool active, const openvdb::Coord &at)
{
    if (!active && value != VXS_CELL_FREE)
        refuse_vdb(fmt::format("cell {} is {} but not active", text_of(at), value));
    if (value < VXS_CELL_FREE || value > VXS_CELL_INTERIOR)
        refuse_vdb(
            fmt::format("cell {} holds {}: not 0 (free), 1 (surface) or 2 (interior)", text_of(at), value));
    return value;
}

/// A leaf's states. Both masks empty: nothing but free cells.
Brick brick_of(const Leaf &leaf)
{
    Brick brick;
    const Leaf::ValueType *values = leaf.buffer().data();
    if (!values) refuse_vdb(fmt::format("the values of the leaf at {} are missing", text_of(leaf.origin())));
    for (openvdb::Index c = 0; c < Leaf::SIZE; ++c) {
        if (values[c] == VXS_CELL_FREE) continue;
        const int state = state_of(values[c], leaf.isValueOn(c), leaf.offsetToGlobalCoord(c));
        (state == VXS_CELL_SURFACE ? brick.surface : brick.interior)[c >> 6] |= std::uint64_t{1} << (c & 63);
    }
    return brick;
}

/// The bricks of a box of cells, max inclusive.
void grow(BrickBox &box, const openvdb::Coord &low, const openvdb::Coord &high)
{
    Cell from, to;
    for (int a = 0; a < 3; ++a) {
        if (low[a] < -vdb_max_index || high[a] > vdb_max_index || low[a] > high[a])
            refuse_vdb(fmt::format("cell {} to {} is beyond the limit of {} per axis", text_of(low),
                                   text_of(high), vdb_max_index));
        from[a] = std::int64_t{low[a]} >> 3;
        to[a] = std::int64_t{high[a]} >> 3;
    }
    box.grow(from, to);
}

using TileIterator = Tree::ValueAllCIter;

TileIterator tiles_of(const Tree &tree)
{
    TileIterator tile = tree.cbeginValueAll();
    tile.setMaxDepth(TileIterator::LEAF_DEPTH - 1);
    return tile;
}

/// Min corners of the leaves of the channels, which have the same ones.
using Leaves = std::vector<openvdb::Coord>;

BrickBox box_of(const Tree &tree, const Leaves &spoken)
{
    BrickBox box;
    for (const openvdb::Coord &leaf : spoken) grow(box, leaf, leaf.offsetBy(Leaf::DIM - 1));
    for (TileIterator tile = tiles_of(tree); tile; ++tile) {
        const openvdb::CoordBBox cells = tile.getBoundingBox();
        if (state_of(tile.getValue(), tile.isValueOn(), cells.min()) != VXS_CELL_FREE)
            grow(box, cells.min(), cells.max());
    }
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
        const Brick brick = brick_of(*leaf);
        if (brick.surface != no_cells || brick.interior != no_cells)
            grow(box, leaf->origin(), leaf->origin().offsetBy(Leaf::DIM - 1));
    }
    if (box.empty()) refuse_vdb("grid `state` holds no surface cell");
    check_box(box, vdb_grid_name, ExitCode::invalid);
    return box;
}

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

void fill(const Tree &tree, const Leaves &spoken, Cells &cells)
{
    cells.origin = box_of(tree, spoken).origin();
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
                for (std::int32_t k = low[2]; k <= high[2]; ++k)
                    cells.bricks.push_back({{i, j, k}, all_cells, no_cells});
            }
    }
    for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
        Brick brick = brick_of(*leaf);
        brick.at = relative(cells, leaf->origin());
        if (brick.interior == all_cells)
            cells.solid.push_back({brick.at[0], brick.at[1], brick.at[2], brick.at[2]});
        else if (brick.surface != no_cells || brick.interior != no_cells)
            cells.bricks.push_back(brick);
    }
    std::sort(cells.bricks.begin(), cells.bricks.end(), before);
    join(cells.solid);
    std::vector<BrickAt> bricks;
    for (const openvdb::Coord &leaf : spoken) bricks.push_back(relative(cells, leaf));
    make_unique(bricks);
    add_spoken(bricks, cells);
}

template<typename Grid>
typename Grid::Ptr read_grid(openvdb::io::File &file, const char *name)
{
    const openvdb::GridBase::Ptr base = file.readGrid(name);
    const auto grid = openvdb::gridPtrCast<Grid>(base);
    if (!grid)
        refuse_vdb(fmt::format("grid `{}` is of type {}, not {}", name, base ? base->valueType() : "none",
                               openvdb::typeNameAsString<typename Grid::ValueType>()));
    return grid;
}

template<typename Grid>
Leaves leaves_of(const Grid &grid)
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

/// The channel's values in brick order. `stored(value, state, cell)` turns one into what a voxmap stores, or
/// refuses.
template<typename T, typename Grid, typename Stored>
std::vector<std::array<T, 512>> channel_of(const Grid &grid, const Cells &cells, Stored stored)
{
    std::vector<std::array<T, 512>> channel(cells.bricks.size());
    std::size_t seen = 0;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf, ++seen) {
        const auto *values = leaf->buffer().data();
        const auto brick = std::lower_bound(cells.bricks.begin(), cells.bricks.end(),
                                            Brick{relative(cells, leaf->origin()), {}, {}}, before);
        if (!values || brick == cells.bricks.end())
            refuse_vdb(fmt::format("the leaf of grid `{}` at {} is damaged", grid.getName(),
                                   text_of(leaf->origin())));
        for (openvdb::Index c = 0; c < 512; ++c)
            channel[static_cast<std::size_t>(brick - cells.bricks.begin())][c] =
                stored(values[c], state_of(*brick, c), leaf->offsetToGlobalCoord(c));
    }
    if (seen != cells.bricks.size())
        refuse_vdb(fmt::format("grid `{}` has {} leaves for {} bricks that hold surface or are spoken of",
                               grid.getName(), seen, cells.bricks.size()));
    return channel;
}

[[noreturn]] void refuse_value(const char *grid, double value, int state, const openvdb::Coord &at)
{
    refuse_vdb(
        fmt::format("grid `{}` says {} of cell {}, whose state is {}", grid, value, text_of(at), state));
}

void read_layers(const openvdb::Int32Grid &grid, const openvdb::MetaMap &metadata, VdbFile &file)
{
    const int count = value_of<openvdb::Int32>(metadata, vdb_meta_layers).value_or(0);
    if (count < 1 || count > VXS_VOXMAP_MAX_LAYERS)
        refuse_vdb(fmt::format("file metadata `layer_count` is {}", count));
    file.channels.layer_count = count;
    file.channels.layer = channel_of<std::int8_t>(
        grid, file.cells, [&](openvdb::Int32 value, int state, const openvdb::Coord &at) {
            const int sign = state == VXS_CELL_SURFACE ? 0 : state == VXS_CELL_FREE ? 1 : -1;
            if ((value > 0) - (value < 0) != sign || std::abs(std::int64_t{value}) > count + 1)
                refuse_value(vdb_layer_grid, value, state, at);
            return static_cast<std::int8_t>(value);
        });
}

void read_distances(const openvdb::FloatGrid &grid, const openvdb::MetaMap &metadata, double unit,
                    VdbFile &file)
{
    Channels &channels = file.channels;
    channels.distance_step = value_of<double>(metadata, vdb_meta_step).value_or(0);
    channels.distance_band = value_of<double>(metadata, vdb_meta_band).value_or(0);
    channels.distance_error = value_of<double>(metadata, vdb_meta_error).value_or(-1);
    channels.unsigned_distance = value_of<bool>(metadata, vdb_meta_unsigned).value_or(false);
    const double step = channels.distance_step, most = std::round(channels.distance_band / step);
    if (!(step >= 1e-30 && most >= 1 && most <= 32767 && channels.distance_error >= 0 &&
          channels.distance_error < 1e30))
        refuse_vdb(
            "file metadata `distance_step`, `distance_band`, `distance_error` are missing or make no sense");
    channels.distance =
        channel_of<std::int16_t>(grid, file.cells, [&](float value, int state, const openvdb::Coord &at) {
            const double steps = std::round(double{value} * unit / step);
            const bool sign = channels.unsigned_distance ? steps >= 0
                              : state == VXS_CELL_FREE   ? steps >= 0
                                                         : state == VXS_CELL_SURFACE || steps <= 0;
            if (!(std::abs(steps) <= most) || !sign)
                refuse_value(vdb_distance_grid, double{value}, state, at);
            return static_cast<std::int16_t>(steps);
        });
}

/// Reads the optional grids, then the cells, which are told by both.
void read_grids(openvdb::io::File &file, const openvdb::Int32Grid &state, const openvdb::MetaMap &metadata,
                double unit, VdbFile &result)
{
    const auto layer =
        file.hasGrid(vdb_layer_grid) ? read_grid<openvdb::Int32Grid>(file, vdb_layer_grid) : nullptr;
    const auto distance =
        file.hasGrid(vdb_distance_grid) ? read_grid<openvdb::FloatGrid>(file, vdb_distance_grid) : nullptr;
    const Leaves spoken = layer ? leaves_of(*layer) : distance ? leaves_of(*distance) : Leaves{};
    fill(state.tree(), spoken, result.cells);
    if (layer) read_layers(*layer, metadata, result);
    if (distance) read_distances(*distance, metadata, unit, result);
}

/// Grid `state` and what goes with it.
VdbFile parse_own(openvdb::io::File &file)
{
    const auto grid = read_grid<openvdb::Int32Grid>(file, vdb_grid_name);
    if (grid->background() != VXS_CELL_FREE)
        refuse_vdb(fmt::format("grid `state` has background {}, not 0", grid->background()));

    VdbFile result;
    const openvdb::MetaMap::Ptr owner = file.getMetadata();
    const openvdb::MetaMap &metadata = *owner;
    const std::optional<double> unit = metadata[vdb_meta_unit] ? unit_of(metadata) : std::optional(1.0);
    if (!unit) refuse_vdb("file metadata `unit` is none of m, mm, um, nm");
    const double scale = voxel_of(grid->transform()) * *unit;
    result.cells.voxel = value_of<double>(metadata, vdb_meta_voxel).value_or(scale);
    if (!(std::abs(result.cells.voxel - scale) <= 1e-9 * scale))
        refuse_vdb(fmt::format("file metadata `voxel` is {} m, the transform of grid `state` says {} m",
                               result.cells.voxel, scale));
    result.cells.closed = value_of<bool>(metadata, vdb_meta_closed).value_or(false);
    result.source_hash = source_of(metadata);
    result.meta = value_of<std::string>(metadata, vdb_meta_options).value_or("{}");
    if (result.meta.size() > vdb_max_meta)
        refuse_vdb(fmt::format("file metadata `options` has {} bytes", result.meta.size()));
    read_grids(file, *grid, metadata, *unit, result);
    return result;
}

} // namespace

VdbFile parse_vdb(const std::filesystem::path &path, const ForeignGrid *foreign)
{
    openvdb::initialize();
    keep_what_is_read<openvdb::Int32Grid>();
    keep_what_is_read<openvdb::FloatGrid>();
    keep_what_is_read<openvdb::MaskGrid>();
    keep_what_is_read<openvdb::BoolGrid>();
    openvdb::io::File file(path.string());
    try {
        file.open(false); // delayed loading would copy the file and fail later
    } catch (const openvdb::LookupError &error) {
        // A file that is cut off names none.
        if (!foreign || std::string_view(error.what()).find("Tree_") == std::string_view::npos) throw;
        throw Failure(ExitCode::unsupported, "",
                      fmt::format("holds a grid that OpenVDB has no type for ({})", error.what()));
    }
    const bool own = file.hasGrid(vdb_grid_name) &&
                     (!foreign || !foreign->name || *foreign->name == vdb_grid_name) &&
                     file.readGridMetadata(vdb_grid_name)->isType<openvdb::Int32Grid>();
    if (!own && foreign) return parse_foreign(file, *foreign);
    if (!own)
        refuse_vdb(
            "has no grid `state` of cells: not a voxmap; voxshell pack makes one of a level set or mask");
    if (foreign && (foreign->unit || foreign->as || foreign->snap))
        throw Failure(ExitCode::usage, "",
                      "grid `state` is voxshell's own and says all: --unit, --as and --snap are for others");
    return parse_own(file);
}

} // namespace voxshell
