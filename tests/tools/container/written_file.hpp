// SPDX-License-Identifier: GPL-3.0-or-later
// Bytes as a file for the length of a test.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>

namespace voxshell {

class WrittenFile {
  public:
    explicit WrittenFile(std::span<const std::uint8_t> bytes)
    {
        std::string folder = (std::filesystem::temp_directory_path() / "voxshell-XXXXXX").string();
        if (!mkdtemp(folder.data())) throw std::runtime_error("no temporary folder");
        folder_ = folder;
        std::ofstream(path(), std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    }
    ~WrittenFile() { std::filesystem::remove_all(folder_); }
    WrittenFile(const WrittenFile &) = delete;
    WrittenFile &operator=(const WrittenFile &) = delete;
    std::filesystem::path path() const { return folder_ / "asset"; }

  private:
    std::filesystem::path folder_;
};

} // namespace voxshell
