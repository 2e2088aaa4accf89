// SPDX-License-Identifier: GPL-3.0-or-later
#include "container/container.hpp"

#include "cli/failure.hpp"

#include <openssl/evp.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>

namespace voxshell {
namespace {

constexpr std::uint64_t round64(std::uint64_t size)
{
    return (size + VXS_CONTAINER_ALIGNMENT - 1) / VXS_CONTAINER_ALIGNMENT * VXS_CONTAINER_ALIGNMENT;
}

template<typename T>
std::span<const std::uint8_t> bytes_of(const T &value)
{
    return {reinterpret_cast<const std::uint8_t *>(&value), sizeof value};
}

/// f(piece) for each megabyte, asking whether to stop.
template<typename F>
void each_piece(std::span<const std::uint8_t> bytes, Progress *progress, F f)
{
    do {
        if (progress) progress->check();
        const std::span<const std::uint8_t> piece = bytes.first(std::min<std::size_t>(bytes.size(), 1 << 20));
        f(piece);
        bytes = bytes.subspan(piece.size());
    } while (!bytes.empty());
}

std::uint32_t crc32_of(std::span<const std::uint8_t> bytes, Progress *progress)
{
    unsigned long crc = 0;
    each_piece(bytes, progress, [&](std::span<const std::uint8_t> piece) {
        crc = ::crc32_z(crc, piece.data(), piece.size());
    });
    return static_cast<std::uint32_t>(crc);
}

void hash_ok(int status)
{
    if (status != 1) throw Failure(ExitCode::system, "", "SHA-256 is not available from libcrypto");
}

} // namespace

Sha256Stream::Sha256Stream(Progress *progress) : context_(EVP_MD_CTX_new()), progress_(progress)
{
    hash_ok(context_ && EVP_DigestInit_ex(static_cast<EVP_MD_CTX *>(context_), EVP_sha256(), nullptr));
}

Sha256Stream::~Sha256Stream()
{
    EVP_MD_CTX_free(static_cast<EVP_MD_CTX *>(context_));
}

void Sha256Stream::update(std::span<const std::uint8_t> bytes)
{
    each_piece(bytes, progress_, [this](std::span<const std::uint8_t> piece) {
        hash_ok(EVP_DigestUpdate(static_cast<EVP_MD_CTX *>(context_), piece.data(), piece.size()));
    });
}

Sha256 Sha256Stream::digest()
{
    Sha256 hash;
    hash_ok(EVP_DigestFinal_ex(static_cast<EVP_MD_CTX *>(context_), hash.data(), nullptr));
    return hash;
}

Sha256 sha256(std::span<const std::uint8_t> bytes)
{
    Sha256Stream stream;
    stream.update(bytes);
    return stream.digest();
}

std::string hex(const Sha256 &hash)
{
    constexpr std::string_view digits = "0123456789abcdef";
    std::string text;
    for (const std::uint8_t byte : hash) {
        text += digits[byte >> 4];
        text += digits[byte & 15];
    }
    return text;
}

std::uint32_t crc32(std::span<const std::uint8_t> bytes)
{
    return crc32_of(bytes, nullptr);
}

void hash_section(Sha256Stream &hash, std::uint32_t id, std::uint32_t stride,
                  std::span<const std::uint8_t> bytes)
{
    const std::uint64_t count = bytes.size() / stride;
    hash.update(bytes_of(id));
    hash.update(bytes_of(stride));
    hash.update(bytes_of(count));
    hash.update(bytes);
}

std::vector<std::uint8_t> container_bytes(std::string_view magic, std::uint16_t major, std::uint16_t minor,
                                          const Sha256 &source_hash, std::vector<Section> sections,
                                          Progress *progress, std::uint32_t required)
{
    if (magic.size() != VXS_CONTAINER_MAGIC_SIZE || sections.empty() ||
        sections.size() > VXS_CONTAINER_MAX_SECTIONS)
        throw Failure(ExitCode::bug, "", "a container needs a magic of 8 bytes and 1 to 64 sections");

    vxs_container_header header{};
    std::vector<vxs_container_section> table(sections.size());
    const std::uint64_t table_size = sizeof(vxs_container_section) * table.size();
    std::uint64_t end = sizeof header + table_size;
    Sha256Stream content(progress);
    for (std::size_t i = 0; i < sections.size(); ++i) {
        const Section &section = sections[i];
        if (section.stride == 0 || section.bytes.empty() || section.bytes.size() % section.stride != 0)
            throw Failure(ExitCode::bug, "", "a section's size is not a positive multiple of its stride");
        table[i] = {.id = section.id,
                    .stride = section.stride,
                    .count = section.bytes.size() / section.stride,
                    .offset = round64(end),
                    .size = section.bytes.size(),
                    .crc = crc32_of(section.bytes, progress),
                    .reserved = 0};
        end = table[i].offset + table[i].size;
        if (section.id != VXS_SECTION_META) hash_section(content, section.id, section.stride, section.bytes);
    }

    std::memcpy(header.magic, magic.data(), magic.size());
    header.version_major = major;
    header.required_features = required;
    header.version_minor = minor;
    header.header_size = sizeof header;
    header.file_size = round64(end);
    header.section_count = static_cast<std::uint32_t>(table.size());
    header.section_entry_size = sizeof(vxs_container_section);
    header.section_table_offset = sizeof header;
    std::ranges::copy(content.digest(), header.content_hash);
    std::ranges::copy(source_hash, header.source_hash);
    header.table_crc = crc32({reinterpret_cast<const std::uint8_t *>(table.data()), table_size});
    header.header_crc = crc32(bytes_of(header).first(offsetof(vxs_container_header, header_crc)));

    std::vector<std::uint8_t> file(header.file_size);
    std::memcpy(file.data(), &header, sizeof header);
    std::memcpy(file.data() + sizeof header, table.data(), table_size);
    for (std::size_t i = 0; i < sections.size(); ++i) {
        if (progress) progress->check();
        std::ranges::copy(sections[i].bytes, file.begin() + static_cast<std::ptrdiff_t>(table[i].offset));
        sections[i].bytes = {};
    }
    return file;
}

} // namespace voxshell
