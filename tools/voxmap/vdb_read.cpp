// SPDX-License-Identifier: GPL-3.0-or-later
// Starts the .vdb parser behind a fence, with bounds that follow from the size of the file.
#include "cli/failure.hpp"
#include "container/file_hash.hpp"
#include "fence/fence.hpp"
#include "voxmap/vdb.hpp"
#include "voxmap/vdb_parse.hpp"

#include <cerrno>
#include <cstring>
#include <fmt/core.h>
#include <fstream>
#include <optional>

namespace voxshell {
namespace {

/// What a file of this size may cost. A leaf of 2 KiB takes 128 bytes of a file at the least, an internal
/// node of 260 KiB about 8 KiB; brick lists come on top. What others write is searched for its surface, 0.1
/// ms a leaf.
FenceLimits limits_of(std::uint64_t file_bytes, bool foreign)
{
    FenceLimits limits{(std::uint64_t{1} << 29) + 64 * file_bytes, 5 + file_bytes / 4'000'000};
    if (foreign) {
        limits.memory += std::uint64_t{1} << 29;
        limits.seconds += 5 + file_bytes / 200'000;
    }
    return limits;
}

std::uint64_t readable_size(const std::filesystem::path &path)
{
    std::error_code error;
    if (std::filesystem::is_directory(path, error))
        throw Failure(ExitCode::system, path.string(), "is a folder");
    std::ifstream file(path, std::ios::binary);
    char magic[8] = {};
    if (!file)
        throw Failure(ExitCode::system, path.string(),
                      fmt::format("cannot be read: {}", std::strerror(errno)));
    if (!file.read(magic, sizeof magic) || std::memcmp(magic, " BDV\0\0\0\0", sizeof magic) != 0)
        throw Failure(ExitCode::invalid, path.string(),
                      "is not an OpenVDB file: it does not begin with OpenVDB's magic number");
    const auto size = std::filesystem::file_size(path, error);
    if (error) throw Failure(ExitCode::system, path.string(), error.message());
    return size;
}

} // namespace

VdbFile read_vdb(const std::filesystem::path &path, const ForeignGrid *foreign, Progress *progress)
{
    const FenceLimits limits = limits_of(readable_size(path), foreign != nullptr);
    try {
        Fence reader("OpenVDB's reader", "this file", limits,
                     [&](Fenced &parent) { return answer_vdb(parent, path, foreign, limits.memory); });
        reader.watch(progress);
        VdbFile file = receive_vdb(reader, limits.memory);
        if (file.foreign) {
            const std::optional<Sha256> hash = hash_of_file(path);
            if (!hash) throw Failure(ExitCode::system, "", "cannot be read to its end");
            file.source_hash = *hash;
        }
        return file;
    } catch (const Failure &failure) {
        throw Failure(failure.code, path.string(), failure.what());
    }
}

} // namespace voxshell
