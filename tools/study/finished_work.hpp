// SPDX-License-Identifier: GPL-3.0-or-later
// What a long study has done so far, in a file: interrupted, it goes on from there.
#pragma once

#include <cstdio>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

/// Rows of numbers by name. One line a row, appended and flushed as it is done; a line that was cut off
/// counts as not done. A file of other inputs or options is begun anew.
class FinishedWork {
  public:
    /// inputs: says what the rows depend on. Makes the folder. Throws Failure(system).
    FinishedWork(const std::filesystem::path &file, const std::string &inputs);
    ~FinishedWork();
    FinishedWork(const FinishedWork &) = delete;
    FinishedWork &operator=(const FinishedWork &) = delete;

    const std::vector<double> *find(const std::string &name) const; ///< nothing: not done yet
    const std::vector<double> &add(const std::string &name, std::vector<double> numbers);
    std::size_t found() const { return found_; } ///< rows that were there
    std::size_t size() const { return rows_.size(); }
    void
    remove(); ///< nothing is left to be kept: the file goes, and a folder that was made for it and is empty

  private:
    std::filesystem::path file_;
    std::map<std::string, std::vector<double>> rows_;
    std::size_t found_ = 0;
    std::FILE *stream_ = nullptr;
    bool made_folder_ = false;
};

} // namespace voxshell
