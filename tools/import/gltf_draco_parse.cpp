// SPDX-License-Identifier: GPL-3.0-or-later
#include "import/gltf_draco.hpp"

#include <draco/compression/decode.h>
#include <fmt/core.h>

namespace voxshell {
namespace {

[[noreturn]] void invalid(const std::string &what)
{
    throw Failure(ExitCode::invalid, "", what);
}

} // namespace

DracoMesh parse_draco(std::span<const std::uint8_t> payload, std::optional<std::uint32_t> position,
                      std::uint64_t max_points)
{
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char *>(payload.data()), payload.size());
    draco::Decoder decoder;
    auto result = decoder.DecodeMeshFromBuffer(&buffer);
    if (!result.ok())
        invalid(fmt::format("damaged payload: {}", printable(result.status().error_msg_string())));
    const std::unique_ptr<draco::Mesh> mesh = std::move(result).value();
    if (!mesh) invalid("damaged payload");

    DracoMesh out;
    out.point_count = mesh->num_points();
    if (out.point_count > max_points) invalid("more vertices than the accessor declares");
    out.faces.reserve(mesh->num_faces());
    for (draco::FaceIndex f(0); f < mesh->num_faces(); ++f) {
        const draco::Mesh::Face &face = mesh->face(f);
        out.faces.push_back({face[0].value(), face[1].value(), face[2].value()});
        for (const std::uint32_t v : out.faces.back())
            if (v >= out.point_count) invalid("damaged payload: an index beyond the vertices");
    }
    if (!position) return out;

    const draco::PointAttribute *attribute = mesh->GetAttributeByUniqueId(*position);
    if (!attribute) invalid(fmt::format("no attribute has the id {}", *position));
    if (attribute->num_components() != 3) {
        invalid(fmt::format("POSITION has {} components", static_cast<int>(attribute->num_components())));
    }
    out.points.reserve(out.point_count);
    for (draco::PointIndex p(0); p < mesh->num_points(); ++p) {
        const draco::AttributeValueIndex value = attribute->mapped_index(p);
        if (value.value() >= attribute->size()) invalid("damaged payload: a vertex without a position");
        // Integers as they are stored: whether they are normalised, the accessor says.
        std::array<double, 3> point{};
        if (attribute->data_type() == draco::DT_FLOAT32 || attribute->data_type() == draco::DT_FLOAT64) {
            if (!attribute->ConvertValue<double, 3>(value, point.data())) {
                invalid("POSITION cannot be read");
            }
        } else {
            std::array<std::int32_t, 3> x{};
            if (!attribute->ConvertValue<std::int32_t, 3>(value, x.data()))
                invalid("POSITION cannot be read");
            point = {static_cast<double>(x[0]), static_cast<double>(x[1]), static_cast<double>(x[2])};
        }
        out.points.push_back(point);
    }
    return out;
}

} // namespace voxshell
