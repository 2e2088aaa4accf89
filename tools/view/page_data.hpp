// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays on their way into a page: small, since a page is sent about, and quick to read for a browser.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace voxshell {

/// Each array becomes a blob, deflated (zlib) and in base64, and an object of the page's JSON that says where
/// it is: {"blob": number, "n": elements, "kind": ...}. Deterministic.
class PageData {
  public:
    using json = nlohmann::ordered_json;
    /// "ints": each element as its difference from the one `stride` before it, zigzag, seven bits a byte.
    json ints(std::span<const std::int32_t> values, std::size_t stride);
    /// "floats": little-endian.
    json floats(std::span<const float> values);
    /// "bytes"
    json bytes(std::span<const std::uint8_t> values);
    const std::vector<std::string> &blobs() const { return blobs_; }

  private:
    json keep(const char *kind, std::size_t elements, std::span<const std::uint8_t> bytes);
    std::vector<std::string> blobs_;
};

/// Bytes as a browser's DecompressionStream("deflate") takes them, in base64.
std::string deflated(std::span<const std::uint8_t> bytes);

} // namespace voxshell
