// SPDX-License-Identifier: GPL-3.0-or-later
// manifest.json: what a batch has made in its output folder, for the machine that the folder goes to.
#pragma once

#include "container/container.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell {

/// Files by their path below the manifest's folder, with '/'. Some 60 bytes a file beside its path, and never
/// as JSON in memory: there are three files for each of a million parts.
class Manifest {
  public:
    struct File {
        std::string_view path;
        std::uint64_t bytes;
        Sha256 sha256;
    };

    void add(std::string_view path, std::uint64_t bytes, const Sha256 &sha256); ///< in any order
    /// By path; of two of the same path the one that was added last. To be called before each of those below.
    void sort();
    std::optional<File> find(std::string_view path) const;
    std::size_t size() const { return entries_.size(); }
    File operator[](std::size_t n) const;

    /// Empty where there is none yet; sorted. Throws Failure: invalid (another file of that name), system.
    static Manifest read(const std::filesystem::path &path);
    void write(const std::function<void(std::string_view)> &sink) const;

  private:
    struct Entry {
        std::uint64_t at, bytes; ///< where its path begins in paths_, and what the file has
        std::uint32_t length;    ///< of the path
        Sha256 sha256;
    };
    std::string_view path_of(const Entry &entry) const { return {paths_.data() + entry.at, entry.length}; }
    std::string paths_;
    std::vector<Entry> entries_;
};

} // namespace voxshell
