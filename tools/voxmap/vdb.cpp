// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/vdb.hpp"
#include "cli/failure.hpp"
#include "voxmap/vdb_grids.hpp"
#include "voxmap/vdb_parse.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fmt/core.h>
#include <map>
#include <memory>
#include <openvdb/openvdb.h>
#include <ostream>
#include <streambuf>
#include <string_view>

namespace voxshell {
namespace {

using Tree = openvdb::Int32Tree;
using Leaf = Tree::LeafNodeType;
static_assert(Leaf::DIM == VXS_VOXMAP_BRICK_CELLS, "a brick is a leaf");

constexpr std::int64_t block_bricks = 16; // per axis of OpenVDB's lowest internal node
constexpr std::size_t uuid_offset =
    21; // after i64 magic, u32 version, u32 and u32 library version, u8 offsets
constexpr std::string_view nil_uuid = "00000000-0000-0000-0000-000000000000";

/// Into memory, asking whether to stop; in pieces that need not move when there are more.
class MemoryBuffer : public std::streambuf {
  public:
    explicit MemoryBuffer(Progress &progress) : progress_(progress) {}

    /// What was written; leaves nothing.
    std::vector<std::uint8_t> take()
    {
        std::vector<std::uint8_t> bytes;
        bytes.reserve(static_cast<std::size_t>(size_));
        for (std::unique_ptr<char[]> &data : pieces_) {
            progress_.check();
            const auto left = std::min(piece, size_ - static_cast<off_type>(bytes.size()));
            bytes.insert(bytes.end(), data.get(), data.get() + left);
            data.reset();
        }
        return bytes;
    }

  private:
    static constexpr off_type piece = 1 << 26; // so large that the system gets each back at once

    std::streamsize xsputn(const char *data, std::streamsize size) override
    {
        progress_.check();
        for (std::streamsize left = size; left > 0;) {
            if (at_ / piece == static_cast<off_type>(pieces_.size()))
                pieces_.push_back(std::make_unique_for_overwrite<char[]>(piece));
            const auto now = std::min<std::streamsize>(left, piece - at_ % piece);
            std::copy_n(data, now, pieces_[static_cast<std::size_t>(at_ / piece)].get() + at_ % piece);
            data += now, at_ += now, left -= now;
        }
        size_ = std::max(size_, at_);
        return size;
    }
    int_type overflow(int_type c) override
    {
        if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
        const std::array<char, 1> one{traits_type::to_char_type(c)};
        xsputn(one.data(), 1);
        return c;
    }
    pos_type seekoff(off_type off, std::ios_base::seekdir from, std::ios_base::openmode which) override
    {
        return seekpos(off + (from == std::ios_base::beg   ? 0
                              : from == std::ios_base::cur ? at_
                                                           : size_),
                       which);
    }
    pos_type seekpos(pos_type to, std::ios_base::openmode) override
    {
        if (to < 0 || to > size_) return off_type{-1};
        return at_ = to;
    }

    Progress &progress_;
    std::vector<std::unique_ptr<char[]>> pieces_;
    off_type at_ = 0, size_ = 0;
};

/// io::File writes to a path and io::Stream gives up the offsets that let a viewer load one grid.
struct MemoryArchive : openvdb::io::Archive {
    MemoryArchive()
    {
        setCompression(openvdb::io::COMPRESS_ACTIVE_MASK); // a codec's bytes depend on its version
        setGridStatsMetadataEnabled(false);                // they depend on the library's ABI
    }
    /// As Archive::write() with all grids: `each(take)` makes one after another.
    template<typename EachGrid>
    std::vector<std::uint8_t> bytes(std::int32_t grids, const EachGrid &each,
                                    const openvdb::MetaMap &metadata, Progress &progress) const
    {
        MemoryBuffer buffer(progress);
        std::ostream out(&buffer);
        out.exceptions(std::ios_base::badbit); // lets a Failure through
        writeHeader(out, true);
        metadata.writeMeta(out);
        out.write(reinterpret_cast<const char *>(&grids), sizeof grids);
        each([&](const openvdb::GridBase::Ptr &grid) {
            openvdb::io::GridDescriptor descriptor(grid->getName(), grid->type(), grid->saveFloatAsHalf());
            writeGrid(descriptor, grid, out, true);
            openvdb::io::setDataCompression(out, compression()); // a grid may have changed it
        });
        return buffer.take();
    }
};

openvdb::Coord coord(std::int64_t i, std::int64_t j, std::int64_t k)
{
    return {static_cast<openvdb::Int32>(i), static_cast<openvdb::Int32>(j), static_cast<openvdb::Int32>(k)};
}

constexpr std::array<std::uint64_t, 8> none{}, all{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};

openvdb::Coord corner(const Cell &origin, const BrickAt &at)
{
    return coord(8 * (origin[0] + at[0]), 8 * (origin[1] + at[1]), 8 * (origin[2] + at[2]));
}

void add_bricks(const Cells &cells, const Cell &origin, Tree &tree, Progress &progress)
{
    for (const Brick &brick : cells.bricks) {
        progress.check();
        if (brick.interior == all || (brick.surface == none && brick.interior == none))
            continue; // a tile, or nothing
        auto *leaf = new Leaf(corner(origin, brick.at), VXS_CELL_FREE, false);
        Leaf::ValueType *values = leaf->buffer().data();
        Leaf::NodeMaskType active;
        for (std::uint32_t i = 0; i < 8; ++i) {
            active.getWord<std::uint64_t>(i) = brick.surface[i] | brick.interior[i];
            for (std::uint64_t left = brick.surface[i]; left; left &= left - 1)
                values[64 * i + static_cast<std::uint32_t>(std::countr_zero(left))] = VXS_CELL_SURFACE;
            for (std::uint64_t left = brick.interior[i]; left; left &= left - 1)
                values[64 * i + static_cast<std::uint32_t>(std::countr_zero(left))] = VXS_CELL_INTERIOR;
        }
        leaf->setValueMask(active);
        tree.addLeaf(leaf); // takes ownership
    }
}

/// Solid bricks as tiles: a block of 16^3 bricks that is solid throughout as one tile, others brick by brick.
/// What is large and solid costs its surface, not its volume. Solid bricks that Cells holds as such count
/// where `with_bricks` says so.
template<typename AnyTree>
void add_solid(const Cells &cells, const Cell &origin, AnyTree &tree, typename AnyTree::ValueType value,
               bool active, bool with_bricks)
{
    const auto each_block = [&](auto &&visit) {
        for (const Brick &brick : cells.bricks)
            if (with_bricks && brick.interior == all)
                visit(Cell{origin[0] + brick.at[0], origin[1] + brick.at[1], origin[2] + brick.at[2]},
                      origin[2] + brick.at[2]);
        for (const SolidRun &run : cells.solid) {
            const std::int64_t i = origin[0] + run.i, j = origin[1] + run.j, last = origin[2] + run.last;
            for (std::int64_t k = origin[2] + run.first, stop = 0; k <= last; k = stop + 1) {
                stop = std::min(last, k | (block_bricks - 1));
                visit(Cell{i, j, k}, stop);
            }
        }
    };
    std::map<Cell, std::int64_t> solid; // bricks in each block
    const auto block = [](const Cell &brick) { return Cell{brick[0] >> 4, brick[1] >> 4, brick[2] >> 4}; };
    each_block([&](const Cell &first, std::int64_t stop) { solid[block(first)] += stop - first[2] + 1; });
    each_block([&](const Cell &first, std::int64_t stop) {
        if (solid[block(first)] == block_bricks * block_bricks * block_bricks) {
            if (((first[0] | first[1] | first[2]) & (block_bricks - 1)) == 0)
                tree.addTile(2, coord(8 * first[0], 8 * first[1], 8 * first[2]), value, active);
            return;
        }
        for (std::int64_t k = first[2]; k <= stop; ++k)
            tree.addTile(1, coord(8 * first[0], 8 * first[1], 8 * k), value, active);
    });
}

/// A leaf per brick, active throughout, so that the bricks can be told again. Elsewhere what is beyond,
/// inactive.
template<typename Grid, typename Value>
typename Grid::Ptr channel_grid(const char *name, const Cells &cells, const Cell &origin,
                                typename Grid::ValueType outside, typename Grid::ValueType inside,
                                Value value, Progress &progress)
{
    using AnyLeaf = typename Grid::TreeType::LeafNodeType;
    auto grid = Grid::create(outside);
    grid->setName(name);
    add_solid(cells, origin, grid->tree(), inside, false, false);
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        progress.check();
        auto *leaf = new AnyLeaf(corner(origin, cells.bricks[b].at), outside, true);
        for (std::size_t c = 0; c < 512; ++c) leaf->buffer().data()[c] = value(b, c);
        grid->tree().addLeaf(leaf);
    }
    return grid;
}

/// A UUID of version 8 (vendor's own) from the hash of the file with the nil UUID in its place.
std::string content_uuid(std::span<const std::uint8_t> bytes, Progress *progress = nullptr)
{
    Sha256Stream stream(progress);
    stream.update(bytes.first(uuid_offset));
    stream.update({reinterpret_cast<const std::uint8_t *>(nil_uuid.data()), nil_uuid.size()});
    stream.update(bytes.subspan(uuid_offset + nil_uuid.size()));
    Sha256 hash = stream.digest();
    hash[6] = static_cast<std::uint8_t>((hash[6] & 0x0f) | 0x80);
    hash[8] = static_cast<std::uint8_t>((hash[8] & 0x3f) | 0x80);
    std::string text = hex(hash).substr(0, 32);
    for (const std::size_t at : {8, 13, 18, 23}) text.insert(at, 1, '-');
    return text;
}

} // namespace

void each_vdb_grid(const Cells &cells, const Channels &channels, double unit_metres,
                   const std::function<void(openvdb::GridBase::Ptr)> &take, Progress *watched)
{
    Progress silent, &progress = watched ? *watched : silent;
    openvdb::initialize();
    for (int axis = 0; axis < 3; ++axis) {
        if (cells.min[axis] < -vdb_max_index || cells.max[axis] > vdb_max_index)
            throw Failure(
                ExitCode::requirement, "",
                fmt::format(
                    "cells {} to {} along axis {} do not fit the 32-bit indices of OpenVDB (limit {}): "
                    "move the part nearer to the origin or use a larger voxel",
                    cells.min[axis], cells.max[axis], axis, vdb_max_index));
    }
    const Cell origin{cells.origin[0] >> 3, cells.origin[1] >> 3, cells.origin[2] >> 3}; // in bricks
    auto state = openvdb::Int32Grid::create(VXS_CELL_FREE);
    state->setName(vdb_grid_name);
    add_bricks(cells, origin, state->tree(), progress);
    add_solid(cells, origin, state->tree(), VXS_CELL_INTERIOR, true, true);
    take(std::move(state));
    if (!channels.layer.empty()) {
        const int beyond = channels.layer_count + 1;
        take(channel_grid<openvdb::Int32Grid>(
            vdb_layer_grid, cells, origin, beyond, -beyond,
            [&](std::size_t b, std::size_t c) { return int{channels.layer[b][c]}; }, progress));
    }
    if (!channels.distance.empty()) {
        const double step = channels.distance_step / unit_metres;
        const auto beyond = static_cast<float>(channels.distance_band / unit_metres);
        auto grid = channel_grid<openvdb::FloatGrid>(
            vdb_distance_grid, cells, origin, beyond, channels.unsigned_distance ? beyond : -beyond,
            [&](std::size_t b, std::size_t c) { return static_cast<float>(channels.distance[b][c] * step); },
            progress);
        if (!channels.unsigned_distance) grid->setGridClass(openvdb::GRID_LEVEL_SET);
        take(std::move(grid));
    }
}

std::vector<std::uint8_t> vdb_bytes(const Cells &cells, const Sha256 &source_hash, const std::string &meta,
                                    const Channels &channels, Progress *watched)
{
    Progress silent, &progress = watched ? *watched : silent;
    const VdbUnit unit = *std::find_if(vdb_units.begin(), vdb_units.end() - 1, [&](const VdbUnit &each) {
        return cells.voxel >= vdb_min_scale * each.metres;
    });
    const double scale = cells.voxel / unit.metres;
    auto transform = openvdb::math::Transform::createLinearTransform(scale);
    transform->postTranslate(openvdb::Vec3d(scale / 2));

    openvdb::MetaMap metadata;
    metadata.insertMeta(vdb_meta_voxel, openvdb::DoubleMetadata(cells.voxel));
    metadata.insertMeta(vdb_meta_unit, openvdb::StringMetadata(std::string(unit.name)));
    metadata.insertMeta(vdb_meta_source, openvdb::StringMetadata(hex(source_hash)));
    metadata.insertMeta(vdb_meta_options, openvdb::StringMetadata(meta));
    metadata.insertMeta(vdb_meta_closed, openvdb::BoolMetadata(cells.closed));
    if (!channels.layer.empty())
        metadata.insertMeta(vdb_meta_layers, openvdb::Int32Metadata(channels.layer_count));
    if (!channels.distance.empty()) {
        metadata.insertMeta(vdb_meta_step, openvdb::DoubleMetadata(channels.distance_step));
        metadata.insertMeta(vdb_meta_band, openvdb::DoubleMetadata(channels.distance_band));
        metadata.insertMeta(vdb_meta_error, openvdb::DoubleMetadata(channels.distance_error));
        metadata.insertMeta(vdb_meta_unsigned, openvdb::BoolMetadata(channels.unsigned_distance));
    }

    const auto each = [&](const auto &take) {
        each_vdb_grid(
            cells, channels, unit.metres,
            [&](const openvdb::GridBase::Ptr &grid) {
                grid->setTransform(transform);
                take(grid);
            },
            &progress);
    };
    std::vector<std::uint8_t> bytes = MemoryArchive().bytes(
        1 + !channels.layer.empty() + !channels.distance.empty(), each, metadata, progress);
    const std::string uuid = content_uuid(bytes, &progress);
    std::copy(uuid.begin(), uuid.end(), bytes.begin() + uuid_offset);
    return bytes;
}

bool vdb_uuid_matches(std::span<const std::uint8_t> bytes)
{
    if (bytes.size() < uuid_offset + nil_uuid.size()) return false;
    return std::memcmp(bytes.data() + uuid_offset, content_uuid(bytes).data(), nil_uuid.size()) == 0;
}

} // namespace voxshell
