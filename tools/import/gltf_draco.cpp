// SPDX-License-Identifier: GPL-3.0-or-later
// Draco payloads. The library bounds what it reads but allocates what the payload claims, so the claims
// (Draco bitstream specification, "Header", "Metadata", "Connectivity") are read first.
#include "import/gltf.hpp"

#include <draco/compression/decode.h>
#include <fmt/core.h>

namespace voxshell {
namespace {

struct Claims {
    std::uint64_t faces = 0, points = 0;
};

/// Little-endian reader that turns false once and for all when the bytes end.
class Cursor {
  public:
    explicit Cursor(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

    bool ok() const { return ok_; }
    void skip(std::uint64_t n)
    {
        ok_ = ok_ && n <= bytes_.size();
        if (ok_) bytes_ = bytes_.subspan(n);
    }
    std::uint64_t fixed(std::size_t n)
    {
        ok_ = ok_ && n <= bytes_.size();
        std::uint64_t x = 0;
        for (std::size_t i = 0; ok_ && i < n; ++i) x |= std::uint64_t{bytes_[i]} << 8 * i;
        skip(n);
        return x;
    }
    std::uint64_t varint()
    {
        std::uint64_t x = 0;
        for (int shift = 0; shift < 63; shift += 7) {
            const std::uint64_t byte = fixed(1);
            x |= (byte & 0x7f) << shift;
            if (!(byte & 0x80)) return x;
        }
        ok_ = false;
        return 0;
    }

  private:
    std::span<const std::uint8_t> bytes_;
    bool ok_ = true;
};

/// Metadata: entries, then the number of named children, which follow one after the other in the same form.
void skip_metadata(Cursor &in)
{
    bool named = false;
    for (std::uint64_t pending = 1; pending > 0 && in.ok(); --pending) {
        if (named) in.skip(in.fixed(1));
        named = true;
        for (std::uint64_t entries = in.varint(); entries > 0 && in.ok(); --entries) {
            in.skip(in.fixed(1)); // name
            in.skip(in.varint()); // value
        }
        pending += in.varint();
    }
}

std::optional<Claims> read_claims(std::span<const std::uint8_t> payload)
{
    Cursor in(payload);
    in.skip(5); // "DRACO"
    const std::uint64_t major = in.fixed(1), minor = in.fixed(1), type = in.fixed(1), method = in.fixed(1),
                        flags = in.fixed(2);
    const std::uint64_t version = major << 8 | minor;
    if (!in.ok() || type != 1 || method > 1) return {};
    if (flags & 0x8000) {
        for (std::uint64_t n = in.varint(); n > 0 && in.ok(); --n) {
            in.varint(); // attribute id
            skip_metadata(in);
        }
        skip_metadata(in);
    }
    Claims claims;
    if (method == 1) {                                                    // edgebreaker
        in.skip(1);                                                       // traversal
        if (version < 0x202) version < 0x200 ? in.fixed(4) : in.varint(); // new vertices
        version < 0x200 ? in.fixed(4) : in.varint(); // corner table's vertices, at most 3 a face
        claims.faces = version < 0x200 ? in.fixed(4) : in.varint();
    } else { // sequential
        claims.faces = version < 0x202 ? in.fixed(4) : in.varint();
        claims.points = version < 0x202 ? in.fixed(4) : in.varint();
    }
    if (!in.ok()) return {};
    return claims;
}

} // namespace

DracoMesh decode_draco(const Source &source, std::span<const std::uint8_t> payload,
                       std::optional<std::uint32_t> position, std::uint64_t max_faces,
                       std::uint64_t max_points, const std::string &where)
{
    const std::string_view text(reinterpret_cast<const char *>(payload.data()), payload.size());
    if (!text.starts_with("DRACO")) source.invalid(where + ": not a Draco payload");
    const std::optional<Claims> claims = read_claims(payload);
    if (!claims) source.invalid(where + ": not a Draco mesh, or cut");
    // A good encoder reaches about 1/2 byte a triangle; flat regular grids much less.
    const std::uint64_t plausible = (std::uint64_t{1} << 16) + 1024 * std::uint64_t{payload.size()};
    if (claims->faces > max_faces || claims->points > max_points || claims->faces > plausible ||
        claims->points > plausible) {
        source.invalid(
            fmt::format("{}: claims {} triangles and {} vertices, the accessors {} and {}, in {} bytes",
                        where, claims->faces, claims->points, max_faces, max_points, payload.size()));
    }

    draco::DecoderBuffer buffer;
    buffer.Init(text.data(), text.size());
    draco::Decoder decoder;
    std::unique_ptr<draco::Mesh> mesh;
    try {
        auto result = decoder.DecodeMeshFromBuffer(&buffer);
        if (!result.ok()) {
            source.invalid(
                fmt::format("{}: damaged payload: {}", where, printable(result.status().error_msg_string())));
        }
        mesh = std::move(result).value();
    } catch (const std::bad_alloc &) {
        source.invalid(where + ": damaged payload: asks for more memory than there is");
    } catch (const std::length_error &) {
        source.invalid(where + ": damaged payload: asks for more memory than there is");
    }
    if (!mesh) source.invalid(where + ": damaged payload");

    DracoMesh out;
    out.point_count = mesh->num_points();
    if (out.point_count > max_points) source.invalid(where + ": more vertices than the accessor declares");
    out.faces.reserve(mesh->num_faces());
    for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
        const draco::Mesh::Face &face = mesh->face(f);
        out.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
        for (const std::uint32_t v : out.faces.back())
            if (v >= out.point_count)
                source.invalid(where + ": damaged payload: an index beyond the vertices");
    }
    if (!position) return out;

    const draco::PointAttribute *attribute = mesh->GetAttributeByUniqueId(*position);
    if (!attribute) source.invalid(fmt::format("{}: no attribute has the id {}", where, *position));
    if (attribute->num_components() != 3) {
        source.invalid(fmt::format("{}: POSITION has {} components", where,
                                   static_cast<int>(attribute->num_components())));
    }
    out.points.reserve(out.point_count);
    for (draco::PointIndex p(0); p < mesh->num_points(); ++p) {
        const draco::AttributeValueIndex value = attribute->mapped_index(p);
        if (value.value() >= attribute->size())
            source.invalid(where + ": damaged payload: a vertex without a position");
        // Integers as they are stored: whether they are normalised, the accessor says.
        std::array<double, 3> point{};
        if (attribute->data_type() == draco::DT_FLOAT32 || attribute->data_type() == draco::DT_FLOAT64) {
            if (!attribute->ConvertValue<double, 3>(value, point.data())) {
                source.invalid(where + ": POSITION cannot be read");
            }
        } else {
            std::array<std::int32_t, 3> x{};
            if (!attribute->ConvertValue<std::int32_t, 3>(value, x.data()))
                source.invalid(where + ": POSITION cannot be read");
            point = {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
        }
        out.points.push_back(point);
    }
    return out;
}

} // namespace voxshell
