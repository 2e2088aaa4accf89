// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/temporary_folder.hpp"

#include "cli/failure.hpp"

#include <cerrno>
#include <cstring>
#include <string>

#include <stdlib.h>

namespace voxshell {

TemporaryFolder::TemporaryFolder()
{
    std::error_code error;
    const std::filesystem::path parent = std::filesystem::temp_directory_path(error);
    std::string name = (parent / "voxshell-XXXXXX").string();
    if (error || !mkdtemp(name.data())) {
        throw Failure(ExitCode::system, name,
                      "cannot make a temporary folder: " + (error ? error.message() : std::strerror(errno)));
    }
    path = name;
}

TemporaryFolder::~TemporaryFolder()
{
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
}

} // namespace voxshell
