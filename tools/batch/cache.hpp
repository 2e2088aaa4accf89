// SPDX-License-Identifier: GPL-3.0-or-later
// Results of conversions under what they were made of: shared by runs, programs and machines.
#pragma once

#include "container/file_hash.hpp"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace voxshell {

/// A folder of entries `ab/cdef...` (64 digits of the key), each a folder with the files of one result and
/// `entry.json` {"entry": {"key", "about", "files": [{"name", "bytes", "sha256"}]}, "sha256": of that}. An
/// entry comes into being by one rename, so that any number of programs on any number of machines may write:
/// who comes second finds it there. Nothing of an entry is ever changed. A folder that may only be read gives
/// what it has, and takes nothing.
class Cache {
  public:
    struct File {
        std::string name; ///< "voxmap"
        std::uint64_t bytes = 0;
        Sha256 sha256{};
        std::filesystem::path path;
    };
    struct Entry {
        nlohmann::ordered_json about; ///< what put() was told
        std::vector<File> files;
    };

    /// Makes the folder, and takes away what dead writers of this machine left; with `only_read` neither, and
    /// it need not be there. Throws Failure(system).
    explicit Cache(std::filesystem::path folder, bool only_read = false);

    /// The entry, all of its files read and hashed: one that is damaged or incomplete is taken away.
    std::optional<Entry> find(const Sha256 &key);
    void forget(const Sha256 &key);

    struct Content {
        std::string name;
        std::span<const std::uint8_t> bytes;
    };
    /// Throws Failure(system), leaving nothing: no room, no permission.
    Entry put(const Sha256 &key, const nlohmann::ordered_json &about, const std::vector<Content> &files);

    /// Takes away the entries that were not used for longest until at most `limit` bytes are left; what it
    /// took away [bytes]. Files that were linked into a results' folder stay there.
    std::uint64_t shrink(std::uint64_t limit);

  private:
    std::filesystem::path folder_of(const Sha256 &key) const;
    std::optional<Entry> read(const Sha256 &key, const std::filesystem::path &folder) const;
    void drop(const std::filesystem::path &folder);
    std::filesystem::path unused() const; ///< a name that a later run takes for left over
    std::filesystem::path temporary();
    std::filesystem::path folder_;
    bool only_read_;
};

} // namespace voxshell
