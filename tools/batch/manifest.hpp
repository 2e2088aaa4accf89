// SPDX-License-Identifier: GPL-3.0-or-later
// manifest.json: what a batch has made in its output folder, for the machine that the folder goes to.
#pragma once

#include "container/container.hpp"

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace voxshell {

class Manifest {
  public:
    struct File {
        std::uint64_t bytes;
        std::string sha256;
    };
    /// By path below the manifest's folder, with '/'.
    std::map<std::string, File> files;

    /// Empty where there is none yet. Throws Failure(invalid) for another file of that name.
    static Manifest read(const std::filesystem::path &path);
    std::string text() const;
};

} // namespace voxshell
