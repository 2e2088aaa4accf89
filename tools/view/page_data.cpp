// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/page_data.hpp"

#include "cli/failure.hpp"
#include "study/study_page.hpp"

#include <zlib.h>

#include <bit>
#include <cstring>

namespace voxshell {

static_assert(std::endian::native == std::endian::little);

std::string deflated(std::span<const std::uint8_t> bytes)
{
    std::string out(compressBound(bytes.size()), '\0');
    uLongf size = out.size();
    if (compress2(reinterpret_cast<Bytef *>(out.data()), &size, bytes.data(), bytes.size(), 9) != Z_OK)
        throw Failure(ExitCode::system, "", "no memory to compress the page's data");
    out.resize(size);
    return page_base64(out);
}

PageData::json PageData::keep(const char *kind, std::size_t elements, std::span<const std::uint8_t> bytes)
{
    blobs_.push_back(deflated(bytes));
    return {{"blob", blobs_.size() - 1}, {"n", elements}, {"kind", kind}};
}

PageData::json PageData::ints(std::span<const std::int32_t> values, std::size_t stride)
{
    std::vector<std::uint8_t> out;
    out.reserve(2 * values.size());
    for (std::size_t n = 0; n < values.size(); ++n) {
        // Modulo 2^32, as the browser adds it up again.
        const std::uint32_t before = n < stride ? 0 : static_cast<std::uint32_t>(values[n - stride]);
        const std::uint32_t change = static_cast<std::uint32_t>(values[n]) - before;
        std::uint32_t zigzag = change << 1 ^ (change >> 31 ? ~0u : 0u);
        for (; zigzag >= 0x80; zigzag >>= 7) out.push_back(static_cast<std::uint8_t>(zigzag | 0x80));
        out.push_back(static_cast<std::uint8_t>(zigzag));
    }
    json kept = keep("ints", values.size(), out);
    kept["stride"] = stride;
    return kept;
}

PageData::json PageData::floats(std::span<const float> values)
{
    return keep("floats", values.size(),
                {reinterpret_cast<const std::uint8_t *>(values.data()), values.size_bytes()});
}

PageData::json PageData::bytes(std::span<const std::uint8_t> values)
{
    return keep("bytes", values.size(), values);
}

} // namespace voxshell
