// SPDX-License-Identifier: GPL-3.0-or-later
// The two containers of glTF: a JSON file, and GLB (glTF 2.0, chapter 4).
#include "import/gltf.hpp"
#include "import/gltf_json.hpp"

#include <fmt/core.h>

#include <cstring>

namespace voxshell {
namespace {

constexpr std::uint32_t chunk_json = 0x4e4f534a, chunk_bin = 0x004e4942;
constexpr std::string_view glb_magic = "glTF";

std::uint32_t u32(std::span<const std::uint8_t> bytes, std::size_t offset)
{
    std::uint32_t x;
    std::memcpy(&x, bytes.data() + offset, sizeof x);
    return x;
}

GltfParts glb_chunks(const Source &source)
{
    const std::span<const std::uint8_t> bytes = source.bytes;
    if (bytes.size() < 12) {
        source.invalid(fmt::format("a GLB header has 12 bytes, the file has {}", bytes.size()));
    }
    if (!source.text().starts_with(glb_magic)) source.invalid("not a GLB: it does not begin with 'glTF'");
    if (u32(bytes, 4) != 2) {
        source.unsupported(fmt::format("GLB container version {}: only version 2 is read", u32(bytes, 4)));
    }
    const std::uint32_t length = u32(bytes, 8);
    if (length != bytes.size()) {
        source.invalid(fmt::format("the GLB header says {} bytes, the file has {}", length, bytes.size()));
    }

    std::string_view json;
    std::optional<std::span<const std::uint8_t>> bin;
    std::size_t chunk = 0;
    for (std::size_t at = 12; at < bytes.size(); ++chunk) {
        if (bytes.size() - at < 8) {
            source.invalid(
                fmt::format("GLB chunk {} has {} bytes of an 8 byte header", chunk, bytes.size() - at));
        }
        const std::uint32_t size = u32(bytes, at), type = u32(bytes, at + 4);
        at += 8;
        if (size > bytes.size() - at) {
            source.invalid(
                fmt::format("GLB chunk {} needs {} bytes, {} are left", chunk, size, bytes.size() - at));
        }
        if (size % 4 != 0) {
            source.invalid(fmt::format("GLB chunk {} has {} bytes, not a multiple of 4", chunk, size));
        }
        if ((chunk == 0) != (type == chunk_json)) {
            source.invalid(chunk == 0 ? "the first GLB chunk is not JSON" : "a second JSON chunk in the GLB");
        }
        const std::span<const std::uint8_t> payload = bytes.subspan(at, size);
        if (type == chunk_json) json = source.text().substr(at, size);
        if (type == chunk_bin) {
            if (chunk != 1) {
                source.invalid(bin ? "a second BIN chunk in the GLB"
                                   : "the BIN chunk is not the second one of the GLB");
            }
            bin = payload;
        }
        at += size;
    }
    if (chunk == 0) source.invalid("a GLB without chunks");
    return {json, bin.value_or(std::span<const std::uint8_t>{})};
}

} // namespace

GltfParts gltf_parts(const Source &source, bool is_glb)
{
    if (is_glb) return glb_chunks(source);
    if (source.text().starts_with(glb_magic)) {
        source.invalid("a binary glTF (GLB) named .gltf: give it the ending .glb");
    }
    return {source.text(), {}};
}

namespace {

Scene import_parts(const Source &source, const ImportOptions &options, bool is_glb)
{
    const GltfParts parts = gltf_parts(source, is_glb);
    if (options.unit) source.refuse(ExitCode::usage, "glTF is in metres: leave --unit out");
    const GltfDocument document = read_gltf_document(source, parse_json(source, parts.json), parts.bin);
    return import_gltf_document(source, document, options.node);
}

} // namespace

Scene import_gltf(const Source &source, const ImportOptions &options)
{
    return import_parts(source, options, false);
}

Scene import_glb(const Source &source, const ImportOptions &options)
{
    return import_parts(source, options, true);
}

} // namespace voxshell
