// SPDX-License-Identifier: GPL-3.0-or-later
// Primitives -> triangles (glTF 2.0, 3.7.2).
#include "import/gltf.hpp"

#include <fmt/core.h>

#include <cmath>

namespace voxshell {
namespace {

enum Mode { mode_triangles = 4, mode_strip = 5, mode_fan = 6 };

Point point_at(const std::vector<double> &numbers, std::size_t i)
{
    return {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
}

} // namespace

/// A decoded POSITION accessor. Vertices enter a mesh when a triangle first needs them: an accessor is often
/// shared by many primitives and meshes, each of which uses a part of it.
struct GltfMeshes::Positions {
    std::vector<double> numbers;
    std::vector<std::uint32_t> stamp; ///< the mesh that `slot` belongs to
    std::vector<std::uint32_t> slot;

    std::uint32_t vertex(std::size_t i, std::uint32_t mesh, Mesh &out)
    {
        if (stamp[i] != mesh) {
            stamp[i] = mesh;
            slot[i] = static_cast<std::uint32_t>(out.vertices.size());
            out.vertices.push_back(point_at(numbers, i));
        }
        return slot[i];
    }
};

GltfMeshes::GltfMeshes(const Source &source, const GltfDocument &document, GltfBuffers &buffers)
    : source_(source), document_(document), buffers_(buffers), draco_(source),
      users_(document.model.accessors.size())
{
    for (const tinygltf::Mesh &mesh : document.model.meshes)
        for (const tinygltf::Primitive &primitive : mesh.primitives)
            if (const auto p = primitive.attributes.find("POSITION"); p != primitive.attributes.end())
                ++users_[static_cast<std::size_t>(p->second)];
}

GltfMeshes::~GltfMeshes() = default;

GltfMeshes::Positions &GltfMeshes::positions(int accessor)
{
    std::unique_ptr<Positions> &entry = positions_[accessor];
    if (!entry) {
        entry = std::make_unique<Positions>();
        entry->numbers = buffers_.numbers(static_cast<std::size_t>(accessor));
        entry->stamp.resize(entry->numbers.size() / 3);
        entry->slot.resize(entry->numbers.size() / 3);
    }
    return *entry;
}

void GltfMeshes::add_primitive(int mesh, int index, Mesh &out)
{
    const tinygltf::Primitive &primitive =
        document_.model.meshes[static_cast<std::size_t>(mesh)].primitives[static_cast<std::size_t>(index)];
    const std::string where = fmt::format("meshes[{}].primitives[{}]", mesh, index);
    morphs_ |= !primitive.targets.empty();
    if (primitive.mode < mode_triangles) {
        ++skipped_;
        return;
    }
    if (const auto draco = document_.draco.find({mesh, index}); draco != document_.draco.end()) {
        add_draco(mesh, index, draco->second, out);
        return;
    }
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) source_.invalid(where + ": no POSITION attribute");
    const std::size_t vertices = document_.model.accessors[static_cast<std::size_t>(position->second)].count;

    std::vector<std::uint32_t> indices;
    if (primitive.indices >= 0) {
        const tinygltf::Accessor &accessor =
            document_.model.accessors[static_cast<std::size_t>(primitive.indices)];
        if (accessor.bufferView >= 0) {
            const std::size_t stride =
                document_.model.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
            if (stride != 0 && stride != gltf_component_size(accessor.componentType)) {
                source_.invalid(fmt::format("{}: indices in a bufferView with a byteStride", where));
            }
        }
        indices = buffers_.indices(static_cast<std::size_t>(primitive.indices));
        const std::uint32_t restart = accessor.componentType == 5121   ? 0xffu
                                      : accessor.componentType == 5123 ? 0xffffu
                                                                       : 0xffffffffu;
        for (std::size_t i = 0; i < indices.size(); ++i) {
            if (indices[i] == restart)
                source_.invalid(fmt::format("{}: index {} is the restart value {}", where, i, restart));
            if (indices[i] >= vertices) {
                source_.invalid(
                    fmt::format("{}: index {} is {}, there are {} vertices", where, i, indices[i], vertices));
            }
        }
    }
    const std::size_t corners = primitive.indices >= 0 ? indices.size() : vertices;
    if (corners < 3 || (primitive.mode == mode_triangles && corners % 3 != 0)) {
        source_.invalid(fmt::format("{}: {} corners do not make {}", where, corners,
                                    primitive.mode == mode_triangles ? "triangles" : "a strip or fan"));
    }

    buffers_.spend(corners);
    Positions &shared = positions(position->second);
    const auto corner = [&](std::size_t i) {
        return shared.vertex(primitive.indices >= 0 ? indices[i] : i, stamp_, out);
    };
    const std::size_t count = primitive.mode == mode_triangles ? corners / 3 : corners - 2;
    out.triangles.reserve(out.triangles.size() + count);
    for (std::size_t i = 0; i < count; ++i) {
        std::array<std::size_t, 3> c{};
        if (primitive.mode == mode_triangles)
            c = {3 * i, 3 * i + 1, 3 * i + 2};
        else if (primitive.mode == mode_strip)
            c = {i, i + 1 + i % 2, i + 2 - i % 2};
        else
            c = {i + 1, i + 2, 0};
        // One after the other: vertices are numbered in the order of their first use.
        Triangle triangle;
        for (std::size_t k = 0; k < 3; ++k) triangle[k] = corner(c[k]);
        out.triangles.push_back(triangle);
    }
    if (users_[static_cast<std::size_t>(position->second)] == 1) positions_.erase(position->second);
}

void GltfMeshes::add_draco(int mesh, int index, const GltfDraco &link, Mesh &out)
{
    const tinygltf::Primitive &primitive =
        document_.model.meshes[static_cast<std::size_t>(mesh)].primitives[static_cast<std::size_t>(index)];
    const std::string where =
        fmt::format("meshes[{}].primitives[{}].extensions.KHR_draco_mesh_compression", mesh, index);
    if (primitive.mode == mode_fan) source_.invalid(where + ": not allowed with a triangle fan");
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) source_.invalid(where + ": no POSITION attribute");
    const tinygltf::Accessor &accessor =
        document_.model.accessors[static_cast<std::size_t>(position->second)];
    if (primitive.indices < 0) source_.invalid(where + ": the primitive has no indices");
    const std::size_t declared = document_.model.accessors[static_cast<std::size_t>(primitive.indices)].count;
    // A strip of n corners holds n - 2 triangles, of which the encoder may have dropped some.
    const std::uint64_t max_faces = primitive.mode == mode_triangles ? declared / 3 : declared;
    buffers_.spend(declared);
    buffers_.spend(accessor.count);

    const std::span<const std::uint8_t> payload = buffers_.view(link.view);
    const DracoMesh decoded = draco_.decode(payload, link.position, max_faces, accessor.count, where);
    if (primitive.mode == mode_triangles && decoded.faces.size() * 3 != declared) {
        source_.invalid(fmt::format("{}: {} triangles, the indices accessor declares {} corners", where,
                                    decoded.faces.size(), declared));
    }
    if (decoded.point_count != accessor.count) {
        source_.invalid(fmt::format("{}: {} vertices, the POSITION accessor declares {}", where,
                                    decoded.point_count, accessor.count));
    }

    Positions local;
    local.stamp.resize(accessor.count);
    local.slot.resize(accessor.count);
    if (link.position) {
        local.numbers.reserve(3 * accessor.count);
        for (const auto &p : decoded.points)
            for (const double x : p) {
                const double value = accessor.normalized ? gltf_normalized(x, accessor.componentType) : x;
                if (!std::isfinite(value)) source_.invalid(where + ": a coordinate is not finite");
                local.numbers.push_back(value);
            }
    } else {
        local.numbers = buffers_.numbers(static_cast<std::size_t>(position->second));
    }
    for (const Triangle &face : decoded.faces) {
        Triangle triangle;
        for (std::size_t k = 0; k < 3; ++k) triangle[k] = local.vertex(face[k], stamp_, out);
        out.triangles.push_back(triangle);
    }
}

Mesh GltfMeshes::mesh(int index)
{
    const tinygltf::Mesh &in = document_.model.meshes[static_cast<std::size_t>(index)];
    Mesh out;
    out.name = in.name.empty() ? fmt::format("mesh{}", index) : printable(in.name);
    ++stamp_;
    for (std::size_t i = 0; i < in.primitives.size(); ++i) {
        const std::size_t before = out.triangles.size();
        add_primitive(index, static_cast<int>(i), out);
        if (out.triangles.size() == before || in.primitives[i].material < 0) continue;
        const auto material = static_cast<std::uint32_t>(in.primitives[i].material);
        if (std::find(out.materials.begin(), out.materials.end(), material) == out.materials.end())
            out.materials.push_back(material);
    }
    return out;
}

} // namespace voxshell
