// SPDX-License-Identifier: GPL-3.0-or-later
// What the importers share: the file's bytes, the hash of all that was read, one function per format.
#pragma once

#include "container/container.hpp"
#include "import/scene.hpp"

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell {

using Bytes = std::vector<std::uint8_t>;

/// The whole of a regular file. Failure(system) when it cannot be read, Failure(invalid) when a git-lfs
/// pointer lies in its place. `blame` is the file that the message names (a buffer's owner).
Bytes read_whole_file(const std::filesystem::path &path, const std::string &blame);

/// What an importer is given. `hash` has taken in the main file, `files` begins with it; the importer adds
/// each external buffer.
struct Source {
    std::filesystem::path path;
    std::string name;              ///< path as the user gave it: Failure::file
    std::span<std::uint8_t> bytes; ///< the importer's own: a buffer is decoded where its base64 stands
    Sha256Stream &hash;
    std::vector<std::filesystem::path> &files;

    [[noreturn]] void refuse(ExitCode code, const std::string &what) const
    {
        throw Failure(code, name, what);
    }
    [[noreturn]] void invalid(const std::string &what) const { refuse(ExitCode::invalid, what); }
    [[noreturn]] void unsupported(const std::string &what) const { refuse(ExitCode::unsupported, what); }

    std::string_view text() const { return {reinterpret_cast<const char *>(bytes.data()), bytes.size()}; }
};

/// Scene::name and Scene::source_hash are filled in by import_scene(), everything else by these.
Scene import_stl(const Source &source, const ImportOptions &options);
Scene import_gltf(const Source &source, const ImportOptions &options); ///< .gltf: JSON
Scene import_glb(const Source &source, const ImportOptions &options);  ///< .glb: binary container

/// Text from a file made fit for one line of a message or a name: control characters become '_', and what
/// is longer than `limit` bytes is cut.
std::string printable(std::string_view text, std::size_t limit = 80);

} // namespace voxshell
