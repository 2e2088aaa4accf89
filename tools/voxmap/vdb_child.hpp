// SPDX-License-Identifier: GPL-3.0-or-later
// What the parsers in the child process share. Includes OpenVDB: for their sources only.
#pragma once

#include "voxmap/vdb_parse.hpp"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <optional>
#include <string>

namespace voxshell {

/// Lets a grid live until the child's _exit(): its destructor starts TBB tasks, and those may wait for a lock that a
/// thread of the parent held when it forked, for ever.
inline void keep_for_ever(const openvdb::GridBase::Ptr &grid)
{
    new openvdb::GridBase::Ptr(grid);
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
