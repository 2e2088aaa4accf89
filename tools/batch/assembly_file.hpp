// SPDX-License-Identifier: GPL-3.0-or-later
// assembly.json (formats/schema/assembly.schema.json): the tree of an assembly, its parts and where they
// stand.
#pragma once

#include "batch/assembly.hpp"
#include "batch/batch.hpp"

#include <functional>
#include <span>
#include <string_view>

namespace voxshell {

struct AssemblyFile {
    std::string name, source; ///< of the assembly; file name of its input
    Sha256 source_hash{};
    Assembly assembly;

    /// `made`: what became of each of its parts. An item a line.
    void write(std::span<const BatchPart> made, const std::function<void(std::string_view)> &sink) const;
};

} // namespace voxshell
