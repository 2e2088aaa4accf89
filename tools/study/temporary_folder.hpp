// SPDX-License-Identifier: GPL-3.0-or-later
// A folder that is gone with its object.
#pragma once

#include <filesystem>

namespace voxshell {

class TemporaryFolder {
  public:
    TemporaryFolder(); ///< in $TMPDIR or /tmp; throws Failure(system)
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder &) = delete;
    TemporaryFolder &operator=(const TemporaryFolder &) = delete;
    std::filesystem::path path;
};

} // namespace voxshell
