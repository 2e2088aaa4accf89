// SPDX-License-Identifier: GPL-3.0-or-later
// What the parsers in the child process share. Includes OpenVDB: for their sources only.
#pragma once

#include "voxmap/vdb_parse.hpp"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <optional>
#include <string>

namespace voxshell {

/// From now on no grid of this type that OpenVDB creates to read it from a file is ever destroyed: the
/// destructor of a tree, half read or whole, starts TBB tasks, and in a fork they may wait for ever for a
/// lock that a thread of the parent held at the time. For the child, which ends by _exit().
template<typename Grid>
void keep_what_is_read()
{
    struct Registry : openvdb::GridBase {
        using openvdb::GridBase::registerGrid, openvdb::GridBase::unregisterGrid;
    };
    Registry::unregisterGrid(Grid::gridType());
    Registry::registerGrid(Grid::gridType(), [] {
        const openvdb::GridBase::Ptr grid = Grid::create();
        new openvdb::GridBase::Ptr(grid);
        return grid;
    });
}

[[noreturn]] void refuse_vdb(const std::string &what); ///< throws Failure(invalid)

std::string text_of(const openvdb::Coord &at); ///< "(1, 2, 3)"

template<typename T>
std::optional<T> value_of(const openvdb::MetaMap &map, const char *key)
{
    const auto found = map.getMetadata<openvdb::TypedMetadata<T>>(key);
    if (!found) return std::nullopt;
    return found->value();
}

/// Metres of the world unit that the file's metadata name, if they do.
std::optional<double> unit_of(const openvdb::MetaMap &metadata);

/// A grid of another program as cells. `file` is open.
VdbFile parse_foreign(openvdb::io::File &file, const ForeignGrid &wanted);

} // namespace voxshell
