// SPDX-License-Identifier: GPL-3.0-or-later
#define NANOVDB_USE_TBB // else it starts a thread a core, whatever -j says
#include "voxmap/nvdb.hpp"
#include "voxmap/vdb_grids.hpp"

#include <cstring>
#include <memory>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <new>
#include <sstream>

namespace voxshell {
namespace {

/// The library leaves some padding unwritten: its own buffer would make a file of whatever was in memory.
class ZeroedBuffer {
  public:
    static ZeroedBuffer create(std::uint64_t size, const ZeroedBuffer * = nullptr)
    {
        ZeroedBuffer buffer;
        buffer.bytes_.reset(static_cast<std::uint8_t *>(::operator new(size, alignment)));
        buffer.size_ = size;
        std::memset(buffer.bytes_.get(), 0, size);
        return buffer;
    }
    std::uint8_t *data() { return bytes_.get(); }
    const std::uint8_t *data() const { return bytes_.get(); }
    std::uint64_t size() const { return size_; }
    void clear()
    {
        bytes_.reset();
        size_ = 0;
    }

  private:
    static constexpr std::align_val_t alignment{NANOVDB_DATA_ALIGNMENT};
    struct Free {
        void operator()(std::uint8_t *bytes) const { ::operator delete(bytes, alignment); }
    };
    std::unique_ptr<std::uint8_t, Free> bytes_;
    std::uint64_t size_ = 0;
};

using Handle = nanovdb::GridHandle<ZeroedBuffer>;

/// OpenVDB refuses a transform as fine as our smallest voxels, so the grid comes without and gets its map
/// here.
template<typename Grid>
Handle nano(const Grid &grid, double voxel)
{
    using Value = typename Grid::ValueType;
    nanovdb::OpenToNanoVDB<Value, Value, nanovdb::AbsDiff, ZeroedBuffer> convert;
    Handle handle = convert(grid, nanovdb::StatsMode::Disable, nanovdb::ChecksumMode::Disable, 0);
    nanovdb::NanoGrid<Value> &made = *handle.template grid<Value>();
    nanovdb::GridData &data = *reinterpret_cast<nanovdb::GridData *>(handle.data());
    data.mMap.set(voxel, nanovdb::Vec3d(voxel / 2), 1.0);
    data.mVoxelSize = nanovdb::Vec3R(voxel);
    // No averages: their last bits depend on how many threads added them up.
    nanovdb::gridStats(made, nanovdb::StatsMode::MinMax);
    nanovdb::updateChecksum(made, nanovdb::ChecksumMode::Full);
    return handle;
}

} // namespace

std::vector<std::uint8_t> nvdb_bytes(const Cells &cells, const Channels &channels)
{
    std::vector<Handle> handles;
    each_vdb_grid(cells, channels, 1, [&](const openvdb::GridBase::Ptr &grid) {
        if (const auto ints = openvdb::gridPtrCast<openvdb::Int32Grid>(grid))
            handles.push_back(nano(*ints, cells.voxel));
        else
            handles.push_back(nano(*openvdb::gridPtrCast<openvdb::FloatGrid>(grid), cells.voxel));
    });
    nanovdb::io::Segment segment(nanovdb::io::Codec::NONE);
    std::uint64_t size = 0;
    for (std::size_t g = 0; g < handles.size(); ++g) {
        segment.add(handles[g]);
        segment.meta[g].fileSize = handles[g].size();
        size += handles[g].size();
    }
    std::ostringstream head;
    segment.write(head);
    const std::string text = std::move(head).str();
    std::vector<std::uint8_t> bytes(text.begin(), text.end());
    bytes.reserve(text.size() + size);
    for (const Handle &handle : handles)
        bytes.insert(bytes.end(), handle.data(), handle.data() + handle.size());
    return bytes;
}

} // namespace voxshell
