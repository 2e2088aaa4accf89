// SPDX-License-Identifier: GPL-3.0-or-later
#include "container/file_hash.hpp"

#include <charconv>
#include <fstream>

namespace voxshell {

std::optional<Sha256> hash_of_file(const std::filesystem::path &path)
{
    std::ifstream file(path, std::ios::binary);
    std::vector<char> block(1 << 17);
    Sha256Stream hash;
    while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
        hash.update(
            {reinterpret_cast<const std::uint8_t *>(block.data()), static_cast<std::size_t>(file.gcount())});
    if (!file.eof()) return {}; // not opened, or ended by an error
    return hash.digest();
}

std::optional<Sha256> sha256_of_hex(std::string_view digits)
{
    Sha256 hash{};
    if (digits.size() != 2 * hash.size()) return {};
    for (std::size_t n = 0; n < hash.size(); ++n) {
        const char *at = digits.data() + 2 * n;
        for (const char c : digits.substr(2 * n, 2))
            if (!((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'))) return {};
        std::from_chars(at, at + 2, hash[n], 16);
    }
    return hash;
}

} // namespace voxshell
