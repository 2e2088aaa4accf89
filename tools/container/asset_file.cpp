// SPDX-License-Identifier: GPL-3.0-or-later
#include "container/asset_file.hpp"

#include "cli/failure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace voxshell {
namespace {

ExitCode exit_code(vxs_result result)
{
    switch (result) {
    case VXS_IO:
        return ExitCode::system;
    case VXS_VERSION:
    case VXS_FEATURE:
        return ExitCode::unsupported;
    case VXS_PARAM:
    case VXS_CONFIG:
        return ExitCode::bug;
    default:
        return ExitCode::invalid;
    }
}

std::string section_name(std::uint32_t id)
{
    std::string name;
    for (int byte = 0; byte < 4; ++byte) {
        const char c = static_cast<char>(id >> 8 * byte & 0xff);
        name += c > ' ' && c <= '~' ? c : '?';
    }
    return name;
}

std::string describe(vxs_result result, const vxs_asset_issue &issue)
{
    if (result == VXS_IO)
        return issue.system_error ? std::strerror(issue.system_error) : vxs_result_text(result);
    if (result == VXS_VERSION)
        return fmt::format(
            "rule C103 section HEAD offset {}: format version {}.{}, this voxshell reads {}.{}: convert "
            "the part again, or use the voxshell that wrote it",
            issue.offset, issue.file_major, issue.file_minor, issue.reader_major, issue.reader_minor);
    if (issue.letter == 0) return issue.text ? issue.text : vxs_result_text(result);
    return fmt::format("rule {}{} section {} offset {}: {}", issue.letter, issue.rule,
                       section_name(issue.section), issue.offset,
                       issue.text ? issue.text : vxs_result_text(result));
}

} // namespace

AssetFile::AssetFile(const std::filesystem::path &path, std::uint32_t kind)
{
    vxs_asset_config config;
    vxs_asset_config_default(&config);
    config.kind = kind;
    config.mode = VXS_ASSET_COPY; // somebody may cut the file meanwhile, which would be SIGBUS in a mapping
    vxs_asset_issue issue{};
    const vxs_result result = vxs_asset_open(path.c_str(), &config, &asset_, &issue);
    if (result != VXS_OK) throw Failure(exit_code(result), path.string(), describe(result, issue));

    Sha256Stream hash;
    for (const vxs_container_section &section : sections()) {
        if (section.id != VXS_SECTION_META) hash_section(hash, section.id, section.stride, bytes_of(section));
    }
    if (hash.digest() == content_hash()) return;
    vxs_asset_close(&asset_); // no destructor runs for an object whose constructor throws
    throw Failure(
        ExitCode::invalid, path.string(),
        fmt::format("rule C303 section HEAD offset {}: the content hash is not that of the sections",
                    offsetof(vxs_container_header, content_hash)));
}

Sha256 AssetFile::source_hash() const
{
    Sha256 hash;
    std::ranges::copy(header().source_hash, hash.begin());
    return hash;
}

Sha256 AssetFile::content_hash() const
{
    Sha256 hash;
    std::ranges::copy(header().content_hash, hash.begin());
    return hash;
}

std::string AssetFile::meta() const
{
    const auto bytes = bytes_of(sections().back());
    return {bytes.begin(), bytes.end()};
}

std::span<const vxs_container_section> AssetFile::sections() const
{
    return {reinterpret_cast<const vxs_container_section *>(asset_.data + sizeof(vxs_container_header)),
            header().section_count};
}

} // namespace voxshell
