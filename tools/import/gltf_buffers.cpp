// SPDX-License-Identifier: GPL-3.0-or-later
// Buffers (files, data URIs, the BIN chunk), views (meshopt) and accessors (stride, sparse, normalised).
#include "import/gltf.hpp"

#include <fmt/core.h>
#include <meshoptimizer.h>

#include <cmath>
#include <cstring>

namespace voxshell {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view data_scheme = "data:";

int base64_digit(char c)
{
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// Base64 of RFC 4648 with padding, nothing else is let pass, decoded into the place where it stands.
std::optional<std::span<std::uint8_t>> base64(std::span<std::uint8_t> text)
{
    if (text.size() % 4 != 0) return {};
    std::size_t pad = 0;
    while (pad < 2 && pad < text.size() && text[text.size() - 1 - pad] == '=') ++pad;
    std::size_t size = 0;
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const int digit = i + pad < text.size() ? base64_digit(static_cast<char>(text[i])) : 0;
        if (digit < 0) return {};
        bits = bits << 6 | static_cast<std::uint32_t>(digit);
        if (i % 4 == 3)
            for (int shift = 16; shift >= 0; shift -= 8)
                text[size++] = static_cast<std::uint8_t>(bits >> shift);
    }
    return text.first(size - pad);
}

/// data:[type/subtype][;parameter=value]...;base64,DATA, of which DATA is decoded where it stands.
std::optional<std::span<std::uint8_t>> data_uri(std::span<std::uint8_t> bytes)
{
    const std::string_view uri(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    const std::size_t comma = uri.find(',');
    if (comma == uri.npos) return {};
    std::string_view head = uri.substr(data_scheme.size(), comma - data_scheme.size());
    constexpr std::string_view marker = ";base64";
    if (!head.ends_with(marker)) return {};
    head.remove_suffix(marker.size());
    for (bool first = true; !head.empty(); first = false) {
        const std::size_t end = std::min(head.find(';'), head.size());
        const std::string_view part = head.substr(0, end);
        if (!part.empty() && part.find(first ? '/' : '=') == part.npos) return {};
        if (part.empty() && !first) return {};
        if (end + 1 == head.size()) return {};
        head.remove_prefix(std::min(end + 1, head.size()));
    }
    return base64(bytes.subspan(comma + 1));
}

std::optional<std::string> percent_decoded(std::string_view uri)
{
    const auto digit = [](char c) {
        return c >= '0' && c <= '9'   ? c - '0'
               : c >= 'a' && c <= 'f' ? c - 'a' + 10
               : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                      : -1;
    };
    std::string out;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        if (uri[i] != '%') {
            out.push_back(uri[i]);
            continue;
        }
        if (i + 2 >= uri.size() || digit(uri[i + 1]) < 0 || digit(uri[i + 2]) < 0) return {};
        out.push_back(static_cast<char>(digit(uri[i + 1]) << 4 | digit(uri[i + 2])));
        i += 2;
    }
    return out;
}

/// "http:", "file:", "c:": letters, then a colon before the first slash.
bool has_scheme(std::string_view uri)
{
    const std::size_t colon = uri.find(':');
    return colon != uri.npos && colon > 0 && uri.find('/') > colon;
}

template<class T>
T load(const std::uint8_t *at)
{
    T x;
    std::memcpy(&x, at, sizeof x);
    return x;
}

double load_component(const std::uint8_t *at, int type)
{
    switch (type) {
    case 5120:
        return load<std::int8_t>(at);
    case 5121:
        return *at;
    case 5122:
        return load<std::int16_t>(at);
    case 5123:
        return load<std::uint16_t>(at);
    case 5125:
        return load<std::uint32_t>(at);
    default:
        return load<float>(at);
    }
}

std::uint32_t load_index(const std::uint8_t *at, int type)
{
    return type == 5121 ? *at : type == 5123 ? load<std::uint16_t>(at) : load<std::uint32_t>(at);
}

} // namespace

double gltf_normalized(double raw, int component_type)
{
    switch (component_type) {
    case 5120:
        return std::max(raw / 127, -1.0);
    case 5121:
        return raw / 255;
    case 5122:
        return std::max(raw / 32767, -1.0);
    case 5123:
        return raw / 65535;
    default:
        return raw;
    }
}

GltfBuffers::GltfBuffers(const Source &source, const GltfDocument &document, std::vector<Warning> &warnings)
    : source_(source), document_(document), warnings_(warnings), buffers_(document.buffers.size()),
      loaded_(source.bytes.size())
{
}

void GltfBuffers::spend(std::uint64_t elements)
{
    // Room for any real file, shared accessors and good compression included; a bound for made-up counts.
    const std::uint64_t limit = (std::uint64_t{1} << 26) + 16 * loaded_;
    if (elements > limit - spent_) {
        source_.unsupported(
            fmt::format("decodes to more than {} vertices and indices from {} bytes", limit, loaded_));
    }
    spent_ += elements;
}

std::span<const std::uint8_t> GltfBuffers::external(std::size_t index, const std::string &uri)
{
    const auto refuse = [&](const char *why) {
        source_.invalid(fmt::format("buffers[{}].uri '{}': {}", index, printable(uri), why));
    };
    const auto decoded = percent_decoded(uri);
    if (!decoded || decoded->empty()) refuse("not a valid URI");
    if (has_scheme(uri) || has_scheme(*decoded)) refuse("only files beside the document are read");
    if (decoded->find('\0') != decoded->npos || decoded->find('\\') != decoded->npos)
        refuse("not a valid URI");
    const fs::path relative(*decoded);
    if (relative.is_absolute()) refuse("an absolute path; only files beside the document are read");
    for (const fs::path &part : relative)
        if (part == "..") refuse("leaves the folder of the document; only files beside it are read");

    const fs::path folder = source_.path.has_parent_path() ? source_.path.parent_path() : fs::path(".");
    std::error_code error;
    const fs::path home = fs::canonical(folder, error);
    const fs::path file = error ? fs::path() : fs::canonical(folder / relative, error);
    if (error) {
        source_.refuse(ExitCode::system,
                       fmt::format("buffers[{}].uri '{}': {}", index, printable(uri), error.message()));
    }
    const auto [end, unused] = std::mismatch(home.begin(), home.end(), file.begin(), file.end());
    if (end != home.end()) refuse("a link that leads out of the folder of the document");

    const auto [entry, fresh] = files_.try_emplace(file.string());
    if (fresh) {
        entry->second = read_whole_file(folder / relative, source_.name);
        source_.hash.update(entry->second);
        source_.files.push_back((folder / relative).lexically_normal());
        loaded_ += entry->second.size();
    }
    return entry->second;
}

std::span<const std::uint8_t> GltfBuffers::buffer(std::size_t index)
{
    if (buffers_[index]) return *buffers_[index];
    const GltfBuffer &declared = document_.buffers[index];
    std::span<const std::uint8_t> bytes;
    const bool is_escaped = declared.uri && declared.uri->starts_with(data_scheme);
    if (!declared.embedded.empty() || is_escaped) {
        if (is_escaped) owned_[index].assign(declared.uri->begin(), declared.uri->end());
        const auto decoded = data_uri(is_escaped ? std::span(owned_[index]) : declared.embedded);
        if (!decoded) source_.invalid(fmt::format("buffers[{}].uri: not a valid base64 data URI", index));
        bytes = *decoded;
    } else if (!declared.uri) {
        if (index != 0 || document_.bin.empty()) {
            source_.invalid(fmt::format("buffers[{}] has no uri and no BIN chunk stands for it", index));
        }
        bytes = document_.bin;
    } else {
        bytes = external(index, *declared.uri);
    }
    if (bytes.size() < declared.length) {
        source_.invalid(
            fmt::format("buffers[{}] declares {} bytes, there are {}", index, declared.length, bytes.size()));
    }
    buffers_[index] = bytes.first(declared.length);
    return *buffers_[index];
}

Bytes GltfBuffers::decompress(std::size_t view, const GltfMeshopt &link)
{
    const std::string where = fmt::format("bufferViews[{}].extensions.{}", view, link.extension);
    const bool attributes = link.mode == "ATTRIBUTES", triangles = link.mode == "TRIANGLES",
               indices = link.mode == "INDICES";
    const bool octahedral = link.filter == "OCTAHEDRAL", quaternion = link.filter == "QUATERNION",
               exponential = link.filter == "EXPONENTIAL";
    if (!attributes && !triangles && !indices) {
        source_.unsupported(fmt::format("{}: mode '{}' is not read", where, printable(link.mode, 20)));
    }
    if (!octahedral && !quaternion && !exponential && link.filter != "NONE") {
        source_.unsupported(fmt::format("{}: filter '{}' is not read", where, printable(link.filter, 20)));
    }
    const bool fine = attributes
                          ? link.stride % 4 == 0 && (!octahedral || link.stride == 4 || link.stride == 8) &&
                                (!quaternion || link.stride == 8)
                          : (link.stride == 2 || link.stride == 4) && link.filter == "NONE" &&
                                (!triangles || link.count % 3 == 0);
    if (!fine) {
        source_.invalid(fmt::format("{}: {} of {} x {} bytes with filter {} is not allowed", where, link.mode,
                                    link.count, link.stride, link.filter));
    }
    const std::span<const std::uint8_t> packed = buffer(link.buffer).subspan(link.offset, link.length);
    // The codecs need at least 4 bytes for a byte column of 256 vertices, a byte for a triangle or an index:
    // a count beyond that is not allocated.
    const std::uint64_t most = attributes
                                   ? packed.size() * 64 / std::min<std::uint64_t>(link.stride, 64) + 256
                               : triangles ? packed.size() * 3
                                           : packed.size();
    if (link.count > most) {
        source_.invalid(
            fmt::format("{}: {} bytes cannot hold {} elements", where, packed.size(), link.count));
    }
    spend(link.count);
    Bytes out(link.count * link.stride);
    const int status =
        attributes
            ? meshopt_decodeVertexBuffer(out.data(), link.count, link.stride, packed.data(), packed.size())
        : triangles
            ? meshopt_decodeIndexBuffer(out.data(), link.count, link.stride, packed.data(), packed.size())
            : meshopt_decodeIndexSequence(out.data(), link.count, link.stride, packed.data(), packed.size());
    if (status == -1) source_.unsupported(where + ": the payload is of a version that is not read");
    if (status != 0) source_.invalid(where + ": the payload is damaged");
    if (octahedral) meshopt_decodeFilterOct(out.data(), link.count, link.stride);
    if (quaternion) meshopt_decodeFilterQuat(out.data(), link.count, link.stride);
    if (exponential) meshopt_decodeFilterExp(out.data(), link.count, link.stride);
    return out;
}

std::span<const std::uint8_t> GltfBuffers::view(std::size_t index)
{
    const tinygltf::BufferView &view = document_.model.bufferViews[index];
    if (const std::optional<GltfMeshopt> &link = document_.meshopt[index]) {
        if (const auto done = decoded_.find(index); done != decoded_.end()) return done->second;
        const GltfBuffer &fallback = document_.buffers[static_cast<std::size_t>(view.buffer)];
        const bool has_fallback = !fallback.fallback && (fallback.uri || !fallback.embedded.empty() ||
                                                         (view.buffer == 0 && !document_.bin.empty()));
        try {
            return decoded_[index] = decompress(index, *link);
        } catch (const Failure &failure) {
            decoded_.erase(index);
            const bool may_fall_back = failure.code == ExitCode::unsupported && has_fallback;
            if (!may_fall_back || document_.requires_extension(link->extension)) throw;
            warnings_.push_back({"gltf-fallback-buffer",
                                 fmt::format("{}; its uncompressed fallback is used", failure.what())});
        }
    }
    return buffer(static_cast<std::size_t>(view.buffer)).subspan(view.byteOffset, view.byteLength);
}

std::span<const std::uint8_t> GltfBuffers::elements(int index, std::uint64_t offset, std::uint64_t bytes)
{
    return view(static_cast<std::size_t>(index)).subspan(offset, bytes); // bounds: gltf_validate.cpp
}

template<class T, class Read>
std::vector<T> GltfBuffers::read(std::size_t index, Read read_component)
{
    const tinygltf::Accessor &accessor = document_.model.accessors[index];
    const auto components =
        static_cast<std::size_t>(tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type)));
    const std::size_t component = gltf_component_size(accessor.componentType),
                      element = component * components;
    spend(accessor.count);
    if (accessor.bufferView < 0 && accessor.count > (std::size_t{1} << 24)) {
        source_.unsupported(
            fmt::format("accessors[{}]: {} zeros without a bufferView", index, accessor.count));
    }
    std::vector<T> out;
    if (accessor.bufferView >= 0) {
        const std::size_t declared =
            document_.model.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
        const std::size_t stride = declared ? declared : element;
        const auto bytes =
            elements(accessor.bufferView, accessor.byteOffset, stride * (accessor.count - 1) + element);
        out.reserve(accessor.count * components);
        for (std::size_t i = 0; i < accessor.count; ++i)
            for (std::size_t c = 0; c < components; ++c)
                out.push_back(
                    read_component(bytes.data() + i * stride + c * component, accessor.componentType));
    } else {
        out.resize(accessor.count * components);
    }
    if (!accessor.sparse.isSparse) return out;

    const auto &sparse = accessor.sparse;
    const auto count = static_cast<std::size_t>(sparse.count);
    const std::size_t index_size = gltf_component_size(sparse.indices.componentType);
    const auto where = elements(sparse.indices.bufferView,
                                static_cast<std::uint64_t>(sparse.indices.byteOffset), count * index_size);
    const auto what = elements(sparse.values.bufferView, static_cast<std::uint64_t>(sparse.values.byteOffset),
                               count * element);
    std::int64_t last = -1;
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t at = load_index(where.data() + i * index_size, sparse.indices.componentType);
        if (at >= accessor.count || at <= last) {
            source_.invalid(fmt::format("accessors[{}].sparse: index {} is {}", index, at,
                                        at >= accessor.count ? "beyond the accessor"
                                                             : "not greater than the one before"));
        }
        last = at;
        for (std::size_t c = 0; c < components; ++c)
            out[at * components + c] =
                read_component(what.data() + i * element + c * component, accessor.componentType);
    }
    return out;
}

std::vector<double> GltfBuffers::numbers(std::size_t index)
{
    const tinygltf::Accessor &accessor = document_.model.accessors[index];
    std::vector<double> out = read<double>(index, load_component);
    for (std::size_t i = 0; i < out.size(); ++i) {
        if (accessor.normalized) out[i] = gltf_normalized(out[i], accessor.componentType);
        if (!std::isfinite(out[i])) {
            source_.invalid(fmt::format("accessors[{}]: number {} is not finite", index, i));
        }
    }
    return out;
}

std::vector<std::uint32_t> GltfBuffers::indices(std::size_t index)
{
    return read<std::uint32_t>(index, load_index);
}

} // namespace voxshell
