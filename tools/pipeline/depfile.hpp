// SPDX-License-Identifier: GPL-3.0-or-later
// What was made of what, in the words of make: the "depfile" that make includes, and ninja and CMake read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace voxshell {

/// Rules "TARGET...: SOURCE...", paths as the command line had them. Each source is also a target of nothing,
/// so that one which is gone is no error of make's but a reason to run again.
class Depfile {
  public:
    /// Throws Failure(unsupported) for a path with a line break, which make cannot name.
    void add(const std::vector<std::filesystem::path> &targets,
             const std::vector<std::filesystem::path> &sources);

    /// Writes the rules to `path`, and gives each target the time of now, as it may have stayed as it was:
    /// for make it is made. If it is not, since not all of it `is_made`, its time is 1970: make tries again.
    /// Throws Failure(system).
    void write(const std::filesystem::path &path, bool is_made = true) const;

  private:
    std::string rules_, sources_;
    std::vector<std::filesystem::path> targets_;
};

} // namespace voxshell
