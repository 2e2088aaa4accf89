// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/export_glb.hpp"
#include "cli/failure.hpp"

namespace voxshell {

void check_glb_size(std::size_t bytes)
{
    if (bytes > UINT32_MAX)
        throw Failure(ExitCode::requirement, "",
                      "a .glb holds at most 4 GiB: export as .ply or .csv, or convert with a larger --voxel");
}

std::vector<std::uint8_t> glb_bytes(std::string json, std::span<const std::uint8_t> binary)
{
    json.resize((json.size() + 3) / 4 * 4, ' ');
    const std::size_t padded = (binary.size() + 3) / 4 * 4, total = 12 + 8 + json.size() + 8 + padded;
    check_glb_size(total);
    std::vector<std::uint8_t> out;
    out.reserve(total);
    const auto word = [&](std::size_t value) {
        for (int byte = 0; byte < 4; ++byte) out.push_back(static_cast<std::uint8_t>(value >> (8 * byte)));
    };
    for (const std::size_t value :
         {std::size_t{0x46546c67}, std::size_t{2}, total, json.size(), std::size_t{0x4e4f534a}})
        word(value);
    out.insert(out.end(), json.begin(), json.end());
    word(padded);
    word(0x004e4942);
    out.insert(out.end(), binary.begin(), binary.end());
    out.resize(total);
    return out;
}

} // namespace voxshell
