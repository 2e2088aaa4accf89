// SPDX-License-Identifier: GPL-3.0-or-later
// What of an assembly.json (formats/schema/assembly.schema.json) is seen: its parts' files, and where they stand.
#pragma once

#include "scene/scene_file.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

struct AssemblyBodies {
    struct Part {
        std::string name;
        std::vector<std::filesystem::path> assets; ///< .voxmap and .pointshell; none if it failed
        std::vector<Pose> poses;                   ///< of its instances; none if it failed
    };
    std::string name;
    std::vector<Part> parts;
    std::size_t instances = 0, failed = 0;
};

/// Throws Failure: system, invalid (no assembly.json of ours, a file outside its folder).
AssemblyBodies read_assembly(const std::filesystem::path &path);

} // namespace voxshell
