// SPDX-License-Identifier: GPL-3.0-or-later
// Writes the container frame of formats/container.md around sections; hashes.
#pragma once

#include "cli/progress.hpp"
#include "voxshell/format/container.h"

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace voxshell {

using Sha256 = std::array<std::uint8_t, 32>;

/// Incremental SHA-256 (OpenSSL behind it). `progress`, if given, is asked after each megabyte whether to go
/// on.
class Sha256Stream {
  public:
    explicit Sha256Stream(Progress *progress = nullptr);
    ~Sha256Stream();
    Sha256Stream(const Sha256Stream &) = delete;
    Sha256Stream &operator=(const Sha256Stream &) = delete;
    void update(std::span<const std::uint8_t> bytes);
    Sha256 digest();

  private:
    void *context_;
    Progress *progress_;
};

Sha256 sha256(std::span<const std::uint8_t> bytes);
std::string hex(const Sha256 &hash);                      ///< 64 lower-case digits
std::uint32_t crc32(std::span<const std::uint8_t> bytes); ///< IEEE 802.3, as zlib's

/// Adds one section to a content hash (container.md "content_hash"): every section but META, in file order.
void hash_section(Sha256Stream &hash, std::uint32_t id, std::uint32_t stride,
                  std::span<const std::uint8_t> bytes);

struct Section {
    std::uint32_t id;
    std::uint32_t stride;            ///< bytes per element
    std::vector<std::uint8_t> bytes; ///< at least one element
};

/// The bytes of a section that holds `elements`.
template<typename T>
Section make_section(std::uint32_t id, std::uint32_t stride, std::span<const T> elements)
{
    const auto *first = reinterpret_cast<const std::uint8_t *>(elements.data());
    return {id, stride, {first, first + elements.size_bytes()}};
}

/// The whole file: header, table, sections in the given order at 64-byte alignment, zero padding, checksums,
/// content hash. `magic` is the 8 bytes of the kind; META is the last section. Deterministic. Lets go of each
/// section once it is in the file. `progress`, if given, is asked whether to go on. `required`: bits of
/// required_features.
std::vector<std::uint8_t> container_bytes(std::string_view magic, std::uint16_t major, std::uint16_t minor,
                                          const Sha256 &source_hash, std::vector<Section> sections,
                                          Progress *progress = nullptr, std::uint32_t required = 0);

} // namespace voxshell
