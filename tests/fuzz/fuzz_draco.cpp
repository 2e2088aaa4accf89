// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a Draco payload, decoded in its process as an import does: refused in one line within bounds, or a mesh that
// holds together. The process goes on from one payload to the next and is started again where the library ends it.
#include "fuzz_import.hpp"
#include "import/gltf.hpp"

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

using namespace voxshell;

namespace {

constexpr std::uint64_t most_faces = 1 << 14, most_points = 1 << 13;

std::unique_ptr<DracoReader> reader;

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t size)
{
    static Sha256Stream hash;
    static std::vector<std::filesystem::path> files;
    static const Source source{"/nowhere/fuzz.glb", "fuzz.glb", {}, hash, files};
    if (!reader) reader = std::make_unique<DracoReader>(source);
    try {
        const bool has_position = size % 8 != 0;
        const DracoMesh mesh = reader->decode({bytes, size}, has_position ? std::optional(5u) : std::nullopt,
                                              most_faces, most_points, "here");
        FUZZ_CHECK(mesh.point_count <= most_points && mesh.faces.size() <= most_faces);
        FUZZ_CHECK(mesh.points.size() == (has_position ? mesh.point_count : 0));
        for (const Triangle &face : mesh.faces)
            for (const std::uint32_t corner : face) FUZZ_CHECK(corner < mesh.point_count);
    } catch (const Failure &failure) {
        fuzz::check(failure);
        const std::string_view what = failure.what();
        if (what.find("this payload") != what.npos) reader.reset(); // it is gone
    }
    return 0;
}

/// What stands behind the magic word.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t *bytes, std::size_t size, std::size_t most, unsigned seed)
{
    fuzz::Dice dice(seed);
    constexpr std::size_t word = 5;
    if (size <= word || most <= word || dice.below(64) == 0) return LLVMFuzzerMutate(bytes, size, most);
    return word + LLVMFuzzerMutate(bytes + word, size - word, most - word);
}

/// A small sheet, by either method, quantised or not, with what else a payload may hold.
std::size_t fuzz_seed(std::uint32_t number, std::uint8_t *bytes, std::size_t most)
{
    constexpr unsigned side = 4;
    draco::Mesh mesh;
    mesh.set_num_points(side * side);
    draco::GeometryAttribute position, other;
    position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    const bool is_texture = number & 4;
    other.Init(is_texture ? draco::GeometryAttribute::TEX_COORD : draco::GeometryAttribute::NORMAL, nullptr,
               is_texture ? 2 : 3, draco::DT_FLOAT32, false, is_texture ? 8 : 12, 0);
    const int p = mesh.AddAttribute(position, true, side * side);
    const int o = number & 8 ? mesh.AddAttribute(other, true, side * side) : -1;
    mesh.attribute(p)->set_unique_id(5);
    for (unsigned v = 0; v < side * side; ++v) {
        const float x = static_cast<float>(v % side), y = static_cast<float>(v / side);
        const std::array<float, 3> at = {x, y, 0.3f * static_cast<float>(v * 7 % 5)}, up = {0, 0.6f, 0.8f};
        mesh.attribute(p)->SetAttributeValue(draco::AttributeValueIndex(v), at.data());
        if (o >= 0) mesh.attribute(o)->SetAttributeValue(draco::AttributeValueIndex(v), up.data());
        if (x + 1 == side || y + 1 == side) continue;
        const draco::PointIndex a(v), b(v + 1), c(v + side), d(v + side + 1);
        mesh.AddFace({a, b, c});
        mesh.AddFace({b, d, c});
    }
    draco::ExpertEncoder encoder(mesh);
    if (number & 1) encoder.SetAttributeQuantization(p, 11);
    if (o >= 0) encoder.SetAttributeQuantization(o, 8);
    encoder.SetEncodingMethod(number & 2 ? draco::MESH_SEQUENTIAL_ENCODING
                                         : draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(static_cast<int>(number >> 4 & 3) * 3, 0);
    draco::EncoderBuffer buffer;
    FUZZ_CHECK(encoder.EncodeToBuffer(&buffer).ok());
    if (buffer.size() > most) return 0;
    std::memcpy(bytes, buffer.data(), buffer.size());
    return buffer.size();
}
