// SPDX-License-Identifier: GPL-3.0-or-later
// Files that appear whole or not at all.
#pragma once

#include "cli/progress.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell {

/// A set of output files that come into being together: each is written under a temporary name in its target
/// folder, synced, and renamed by commit(). Destroyed without commit (a Failure, ^C), it leaves nothing
/// behind, neither files nor the folders that it made. Throws Failure(system) on any error, with the path.
/// Each is used by one thread; abandon_all() may come from any.
class Outputs {
  public:
    explicit Outputs(bool force);
    ~Outputs();
    /// Takes away what is not committed, of all that there are, and lets nobody add or commit again: for a
    /// process that is about to end without unwinding. Waits for a commit() that has begun.
    static void abandon_all();
    Outputs(const Outputs &) = delete;
    Outputs &operator=(const Outputs &) = delete;
    /// Writes the bytes under a temporary name. An existing file with other content is refused
    /// (Failure(system), "exists with other content; --force overwrites") unless `force` or `may_replace()`
    /// say otherwise. `progress`, if given, is asked whether to go on.
    void add(const std::filesystem::path &path, std::span<const std::uint8_t> bytes,
             Progress *progress = nullptr, const std::function<bool()> &may_replace = {});
    void add(const std::filesystem::path &path, const std::string &text);
    /// The same for a file too large to hold: `write` hands its bytes to the sink piece by piece.
    using Sink = std::function<void(std::string_view)>;
    void add_stream(const std::filesystem::path &path, const std::function<void(const Sink &)> &write);
    /// The file `from`, hard-linked where the file systems permit it, else copied. What is there already is
    /// left if it has the same content, and replaced if `force` or `may_replace()` say so. False: it was
    /// there.
    bool link(const std::filesystem::path &from, const std::filesystem::path &path,
              const std::function<bool()> &may_replace);
    void commit();

  private:
    struct Pending {
        std::filesystem::path temporary, target; ///< no temporary: the same bytes are there already
    };
    bool make_way(const std::filesystem::path &path);
    int create(const std::filesystem::path &path);
    void abandon();
    std::vector<Pending> pending_;
    std::vector<std::filesystem::path> made_folders_;
    bool force_;
};

} // namespace voxshell
