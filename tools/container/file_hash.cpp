// SPDX-License-Identifier: GPL-3.0-or-later
#include "container/file_hash.hpp"

#include <fstream>

namespace voxshell {

std::optional<Sha256> hash_of_file(const std::filesystem::path &path)
{
    std::ifstream file(path, std::ios::binary);
    std::vector<char> block(1 << 20);
    Sha256Stream hash;
    while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
        hash.update(
            {reinterpret_cast<const std::uint8_t *>(block.data()), static_cast<std::size_t>(file.gcount())});
    if (!file.eof()) return {}; // not opened, or ended by an error
    return hash.digest();
}

} // namespace voxshell
