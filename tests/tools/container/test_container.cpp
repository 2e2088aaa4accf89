// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "cli/failure.hpp"
#include "container/asset_file.hpp"
#include "container/container.hpp"
#include "voxshell/format/voxmap.h"
#include "written_file.hpp"

#include <algorithm>
#include <cstring>

using namespace voxshell;

namespace {

std::span<const std::uint8_t> bytes_of(std::string_view text)
{
    return {reinterpret_cast<const std::uint8_t *>(text.data()), text.size()};
}

std::vector<std::uint8_t> golden(const char *name)
{
    std::ifstream in(std::string(VXS_TEST_SOURCE_DIR "/tests/golden/valid/") + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// What opening these bytes ends with.
Failure failure_of(std::span<const std::uint8_t> bytes, std::uint32_t kind = VXS_ASSET_ANY)
{
    const WrittenFile file(bytes);
    try {
        const AssetFile asset(file.path(), kind);
    } catch (const Failure &failure) {
        return failure;
    }
    return {ExitCode::ok, "", ""};
}

template<typename T>
void put(std::vector<std::uint8_t> &file, std::size_t offset, T value)
{
    std::memcpy(&file[offset], &value, sizeof value);
    const std::uint32_t crc = crc32(std::span(file).first(offsetof(vxs_container_header, header_crc)));
    std::memcpy(&file[offsetof(vxs_container_header, header_crc)], &crc, sizeof crc);
}

} // namespace

TEST_CASE("hashes of published vectors")
{
    CHECK(hex(sha256({})) == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
    CHECK(hex(sha256(bytes_of("abc"))) == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    CHECK(crc32(bytes_of("123456789")) == 0xCBF43926);
    CHECK(crc32({}) == 0);
    Sha256Stream stream;
    stream.update(bytes_of("a"));
    stream.update(bytes_of("bc"));
    CHECK(stream.digest() == sha256(bytes_of("abc")));
}

TEST_CASE("a container lays sections out as specified")
{
    const std::uint32_t a = VXS_SECTION_ID('A', 'A', 'A', 'A');
    const std::vector<Section> sections{{a, 4, std::vector<std::uint8_t>(68, 7)},
                                        {VXS_SECTION_META, 1, {'{', '}'}}};
    const Sha256 source = sha256(bytes_of("source"));
    const auto file = container_bytes(VXS_VOXMAP_MAGIC, 1, 0, source, sections);
    REQUIRE(file.size() == 448);
    const auto *header = reinterpret_cast<const vxs_container_header *>(file.data());
    const auto *table = reinterpret_cast<const vxs_container_section *>(file.data() + 128);
    CHECK(header->file_size == 448);
    CHECK(header->section_count == 2);
    CHECK(std::ranges::equal(header->source_hash, source));
    CHECK(table[0].offset == 256); // 128 + 2 * 40 = 208
    CHECK(table[0].count == 17);
    CHECK(table[1].offset == 384); // 256 + 68 = 324
    CHECK(file[323] == 7);
    CHECK(std::all_of(&file[324], &file[384], [](std::uint8_t byte) { return byte == 0; }));

    SUBCASE("META is outside the content hash")
    {
        auto renamed = sections;
        renamed[1].bytes = {'{', ' ', '}'};
        const auto other = container_bytes(VXS_VOXMAP_MAGIC, 1, 0, {}, renamed);
        CHECK(std::equal(&file[48], &file[80], &other[48]));
        renamed[0].bytes[0] = 8;
        const auto changed = container_bytes(VXS_VOXMAP_MAGIC, 1, 0, {}, renamed);
        CHECK_FALSE(std::equal(&file[48], &file[80], &changed[48]));
    }
    SUBCASE("the content hash is that of ids, strides, counts and bytes")
    {
        std::string text("AAAA\4\0\0\0\x11\0\0\0\0\0\0\0", 16);
        text.append(68, '\7');
        CHECK(std::ranges::equal(header->content_hash, sha256(bytes_of(text))));
    }
}

TEST_CASE("sections that are no sections are a bug")
{
    CHECK_THROWS_AS(container_bytes(VXS_VOXMAP_MAGIC, 1, 0, {}, {}), Failure);
    CHECK_THROWS_AS(container_bytes(VXS_VOXMAP_MAGIC, 1, 0, {}, {{VXS_SECTION_META, 4, {1, 2, 3}}}), Failure);
    CHECK_THROWS_AS(container_bytes(VXS_VOXMAP_MAGIC, 1, 0, {}, {{VXS_SECTION_META, 1, {}}}), Failure);
}

TEST_CASE("an asset file tells its sections, hashes and META")
{
    const WrittenFile file(golden("uniform.voxmap"));
    const AssetFile asset(file.path());
    CHECK(asset.asset().kind == VXS_ASSET_VOXMAP);
    CHECK(asset.sections().size() == 5);
    CHECK(asset.sections()[3].id == VXS_VOXMAP_SECTION_BRIK);
    CHECK(asset.bytes_of(asset.sections()[3]).size() == 128);
    CHECK(asset.source_hash() == sha256({}));
    CHECK(asset.meta() == R"({"golden":true})");
    Sha256Stream hash;
    for (const auto &section : asset.sections().first(4))
        hash_section(hash, section.id, section.stride, asset.bytes_of(section));
    CHECK(asset.content_hash() == hash.digest());
}

TEST_CASE("a refused file ends with the exit code and the rule")
{
    const auto valid = golden("one_point.pointshell");
    CHECK(failure_of(valid).code == ExitCode::ok);

    auto file = valid;
    put<std::uint16_t>(file, offsetof(vxs_container_header, version_major), 2);
    Failure failure = failure_of(file);
    CHECK(failure.code == ExitCode::unsupported);
    CHECK(std::string(failure.what()) ==
          "rule C103 section HEAD offset 8: format version 2.0, this voxshell reads 1.0: "
          "convert the part again, or use the voxshell that wrote it");
    CHECK(std::filesystem::path(failure.file).filename() == "asset");

    file = valid;
    put<std::uint32_t>(file, offsetof(vxs_container_header, required_features), 2);
    CHECK(failure_of(file).code == ExitCode::unsupported);
    CHECK(std::string(failure_of(file).what()).starts_with("rule C105 section HEAD offset 24: "));

    file = valid;
    file.resize(file.size() - 64);
    CHECK(failure_of(file).code == ExitCode::invalid);
    CHECK(std::string(failure_of(file).what()).starts_with("rule C106 "));

    file = valid;
    put<std::uint8_t>(file, offsetof(vxs_container_header, content_hash), file[48] ^ 1);
    CHECK(failure_of(file).code == ExitCode::invalid);
    CHECK(std::string(failure_of(file).what()).starts_with("rule C303 section HEAD offset 48: "));

    file = valid;
    file[576] ^= 1; // in SHEL, whatever rule of it comes first: the checksum comes before
    CHECK(std::string(failure_of(file).what()).starts_with("rule C302 section SHEL offset 576: "));

    CHECK(failure_of(valid, VXS_ASSET_POINTSHELL).code == ExitCode::ok);
    failure = failure_of(valid, VXS_ASSET_VOXMAP);
    CHECK(failure.code == ExitCode::invalid);
    CHECK(std::string(failure.what()).find("kind") != std::string::npos);

    try {
        const AssetFile asset("/nonexistent/file.voxmap");
        FAIL("opened a file that is not there");
    } catch (const Failure &missing) {
        CHECK(missing.code == ExitCode::system);
        CHECK(std::string(missing.what()) == "No such file or directory");
    }
}
