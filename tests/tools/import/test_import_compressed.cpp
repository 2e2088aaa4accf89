// SPDX-License-Identifier: GPL-3.0-or-later
// Draco and meshopt payloads, made with the libraries' own encoders, whole and damaged.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "fence/fence.hpp"
#include "import/gltf_draco.hpp"
#include "import_test.hpp"

#include <doctest/doctest.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <cstring>
#include <memory>
#include <sys/resource.h>

using namespace import_test;
using voxshell::flatten;

namespace {

struct DracoOptions {
    int quantization = 0;    ///< bits, 0: none
    bool edgebreaker = true; ///< else sequential
    bool integers = false;   ///< positions as int16
    bool metadata = false;
    std::uint32_t id = 5;
};

/// A cube whose POSITION comes second, after an attribute of another meaning.
Bytes draco_cube(const DracoOptions &options)
{
    draco::Mesh mesh;
    mesh.set_num_points(8);
    draco::GeometryAttribute other, position;
    other.Init(draco::GeometryAttribute::GENERIC, nullptr, 1, draco::DT_FLOAT32, false, 4, 0);
    const int other_index = mesh.AddAttribute(other, true, 8);
    mesh.attribute(other_index)->set_unique_id(0);
    if (options.integers)
        position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_INT16, false, 6, 0);
    else
        position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    const int index = mesh.AddAttribute(position, true, 8);
    mesh.attribute(index)->set_unique_id(options.id);
    for (std::uint32_t v = 0; v < 8; ++v) {
        const float x = static_cast<float>(v) + 100;
        mesh.attribute(other_index)->SetAttributeValue(draco::AttributeValueIndex(v), &x);
        const Float3 &p = cube_points[v];
        const std::array<std::int16_t, 3> q = {static_cast<std::int16_t>(32767 * p[0]),
                                               static_cast<std::int16_t>(32767 * p[1]),
                                               static_cast<std::int16_t>(32767 * p[2])};
        mesh.attribute(index)->SetAttributeValue(
            draco::AttributeValueIndex(v), options.integers ? static_cast<const void *>(q.data()) : p.data());
    }
    for (std::size_t i = 0; i < cube_indices.size(); i += 3)
        mesh.AddFace({draco::PointIndex(cube_indices[i]), draco::PointIndex(cube_indices[i + 1]),
                      draco::PointIndex(cube_indices[i + 2])});
    if (options.metadata) {
        auto metadata = std::make_unique<draco::GeometryMetadata>();
        metadata->AddEntryString("name", "a cube");
        for (const char *name : {"one", "two"}) {
            auto child = std::make_unique<draco::Metadata>();
            child->AddEntryInt("x", 300);
            metadata->AddSubMetadata(name, std::move(child));
        }
        auto of_attribute = std::make_unique<draco::AttributeMetadata>();
        of_attribute->AddEntryString("meaning", "where");
        mesh.AddMetadata(std::move(metadata));
        mesh.AddAttributeMetadata(index, std::move(of_attribute));
    }
    draco::ExpertEncoder encoder(mesh);
    if (options.quantization) encoder.SetAttributeQuantization(index, options.quantization);
    encoder.SetEncodingMethod(options.edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING
                                                  : draco::MESH_SEQUENTIAL_ENCODING);
    draco::EncoderBuffer buffer;
    REQUIRE(encoder.EncodeToBuffer(&buffer).ok());
    return Bytes(buffer.data(), buffer.data() + buffer.size());
}

Gltf with_draco(const Bytes &payload, std::uint32_t id = 5, bool required = true)
{
    Gltf gltf;
    gltf.use("KHR_draco_mesh_compression", required);
    const std::size_t view = gltf.view(payload);
    gltf.add("accessors", {{"componentType", 5126}, {"type", "VEC3"}, {"count", 8}});
    gltf.add("accessors", {{"componentType", 5123}, {"type", "SCALAR"}, {"count", 36}});
    gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", 0}}},
                                   {"indices", 1},
                                   {"extensions",
                                    {{"KHR_draco_mesh_compression",
                                      {{"bufferView", view}, {"attributes", {{"POSITION", id}}}}}}}})}});
    return gltf;
}

std::string told(const Gltf &gltf)
{
    const Folder folder;
    return refusal(folder.write("a.glb", gltf.glb()));
}

double volume_of(const Gltf &gltf)
{
    const Folder folder;
    return volume(flatten(voxshell::import_scene(folder.write("a.glb", gltf.glb()), {})));
}

enum class Packed { attributes, triangles, indices };

Bytes packed(Packed mode, const void *data, std::size_t count, std::size_t stride)
{
    Bytes out(100000);
    std::vector<unsigned> indices(count);
    if (mode != Packed::attributes)
        for (std::size_t i = 0; i < count; ++i) {
            const auto *p = static_cast<const std::uint8_t *>(data) + i * stride;
            indices[i] = p[0] | unsigned{p[1]} << 8;
        }
    const std::size_t size = mode == Packed::attributes
                                 ? meshopt_encodeVertexBuffer(out.data(), out.size(), data, count, stride)
                             : mode == Packed::triangles
                                 ? meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), count)
                                 : meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), count);
    REQUIRE(size > 0);
    out.resize(size);
    return out;
}

/// A cube in meshopt views over a fallback buffer without data.
Gltf with_meshopt(const char *extension, Packed index_mode, bool required = true)
{
    Gltf gltf;
    gltf.use(extension, required);
    const Bytes points = bytes_of(cube_points);
    const auto add = [&](const Bytes &payload, const char *mode, std::size_t count, std::size_t stride,
                         std::size_t offset) {
        while (gltf.bin.size() % 4) gltf.bin.push_back(0);
        const Json link = {{"buffer", 0},
                           {"byteOffset", gltf.bin.size()},
                           {"byteLength", payload.size()},
                           {"byteStride", stride},
                           {"count", count},
                           {"mode", mode}};
        gltf.bin.insert(gltf.bin.end(), payload.begin(), payload.end());
        return gltf.add("bufferViews", {{"buffer", 1},
                                        {"byteOffset", offset},
                                        {"byteLength", count * stride},
                                        {"extensions", {{extension, link}}}});
    };
    const std::size_t v = add(packed(Packed::attributes, points.data(), 8, 12), "ATTRIBUTES", 8, 12, 0);
    const std::size_t i = add(packed(index_mode, cube_indices.data(), 36, 2),
                              index_mode == Packed::triangles ? "TRIANGLES" : "INDICES", 36, 2, 96);
    gltf.accessor(v, 5126, "VEC3", 8);
    gltf.accessor(i, 5123, "SCALAR", 36);
    gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", 0}}}, {"indices", 1}})}});
    gltf.json["buffers"] = {{{"byteLength", gltf.bin.size()}},
                            {{"byteLength", 168}, {"extensions", {{extension, {{"fallback", true}}}}}}};
    return gltf;
}

} // namespace

TEST_CASE("Draco: quantised or not, either method, by unique id, with metadata")
{
    for (const bool edgebreaker : {true, false})
        for (const int bits : {0, 14})
            for (const bool metadata : {false, true}) {
                CAPTURE(edgebreaker);
                CAPTURE(bits);
                CAPTURE(metadata);
                CHECK(volume_of(with_draco(draco_cube({bits, edgebreaker, false, metadata, 5}))) ==
                      doctest::Approx(1).epsilon(1e-3));
            }
}

TEST_CASE("Draco: normalised integers as the accessor says")
{
    Gltf gltf = with_draco(draco_cube({0, true, true, false, 5}));
    gltf.use("KHR_mesh_quantization", true);
    gltf.json["accessors"][0]["componentType"] = 5122;
    gltf.json["accessors"][0]["normalized"] = true;
    CHECK(volume_of(gltf) == doctest::Approx(1));
    gltf.json["accessors"][0]["normalized"] = false;
    CHECK(volume_of(gltf) == doctest::Approx(32767.0 * 32767 * 32767));
}

TEST_CASE("Draco: optional, beside plain data; and two primitives on one payload")
{
    Gltf gltf = with_draco(draco_cube({}), 5, false);
    const std::size_t p = gltf.view(bytes_of(std::vector<Float3>(8))), i = gltf.view(bytes_of(cube_indices));
    gltf.json["accessors"][0]["bufferView"] = p; // the plain twin is flat: the payload is what counts
    gltf.json["accessors"][1]["bufferView"] = i;
    CHECK(volume_of(gltf) == doctest::Approx(1));
    gltf.json["meshes"][0]["primitives"].push_back(gltf.json["meshes"][0]["primitives"][0]);
    CHECK(volume_of(gltf) == doctest::Approx(2));
}

TEST_CASE("Draco: positions that are not in the payload come from their accessor")
{
    Gltf gltf = with_draco(draco_cube({0, false, false, false, 5}));
    gltf.json["accessors"][0]["bufferView"] = gltf.view(bytes_of(cube_points));
    Json &extension = gltf.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"];
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["_A"] = 0;
    extension["attributes"] = {{"_A", 0}};
    CHECK(volume_of(gltf) == doctest::Approx(1));
}

TEST_CASE("Draco: what does not agree is refused")
{
    const Bytes payload = draco_cube({});
    CHECK(contains(told(with_draco(payload, 4)), "no attribute has the id 4"));
    CHECK(contains(told(with_draco(payload, 0)), "POSITION has 1 components"));
    Gltf gltf = with_draco(payload);
    gltf.json["accessors"][0]["count"] = 9;
    CHECK(contains(told(gltf), "8 vertices, the POSITION accessor declares 9"));
    gltf = with_draco(payload);
    gltf.json["accessors"][1]["count"] = 39;
    CHECK(contains(told(gltf), "12 triangles, the indices accessor declares 39"));
    gltf = with_draco(payload);
    gltf.json["accessors"][1]["count"] = 33;
    CHECK(contains(told(gltf), "claims 12 triangles"));
    gltf = with_draco(payload);
    gltf.json["meshes"][0]["primitives"][0]["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 1;
    CHECK(contains(told(gltf), "bufferView: 1 does not exist"));
    gltf = with_draco(payload);
    gltf.json["meshes"][0]["primitives"][0]["mode"] = 6;
    CHECK(contains(told(gltf), "not allowed with a triangle fan"));
    gltf = with_draco(payload);
    gltf.json["meshes"][0]["primitives"][0].erase("indices");
    CHECK(contains(told(gltf), "no indices"));
    gltf = with_draco(payload);
    gltf.json["accessors"][0]["count"] = gltf.json["accessors"][1]["count"] = 900000000;
    CHECK(told(gltf).starts_with("5: "));
}

TEST_CASE("Draco: a payload that claims a billion triangles is refused before memory is asked for")
{
    // Header, edgebreaker, 2^30 vertices and faces as varints.
    Bytes payload = {'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0};
    for (int i = 0; i < 2; ++i) payload.insert(payload.end(), {0x80, 0x80, 0x80, 0x80, 0x04});
    payload.resize(200);
    CHECK(contains(told(with_draco(payload)), "claims 1073741824 triangles"));
}

TEST_CASE("Draco: every prefix and every changed byte ends well")
{
    for (const bool edgebreaker : {true, false}) {
        const Bytes payload = draco_cube({11, edgebreaker, false, true, 5});
        for (std::size_t n = 1; n < payload.size(); ++n)
            CHECK(told(with_draco(Bytes(payload.begin(),
                                        payload.begin() + static_cast<std::ptrdiff_t>(n)))) != "converted");
        for (std::size_t i = 0; i < payload.size(); ++i)
            for (const int value : {0, 1, 0x7f, 0x80, 0xff}) {
                Bytes changed = payload;
                changed[i] = static_cast<std::uint8_t>(value);
                const std::string message = told(with_draco(changed));
                CHECK((message == "converted" || message.starts_with("3: ")));
            }
    }
}

/// A bumpy sheet with texture coordinates, which a payload predicts from as many turns as it likes to say.
Bytes draco_sheet()
{
    constexpr unsigned side = 12;
    draco::Mesh mesh;
    mesh.set_num_points(side * side);
    draco::GeometryAttribute position, texture;
    position.Init(draco::GeometryAttribute::POSITION, nullptr, 3, draco::DT_FLOAT32, false, 12, 0);
    texture.Init(draco::GeometryAttribute::TEX_COORD, nullptr, 2, draco::DT_FLOAT32, false, 8, 0);
    const int p = mesh.AddAttribute(position, true, side * side);
    const int t = mesh.AddAttribute(texture, true, side * side);
    mesh.attribute(p)->set_unique_id(5);
    for (unsigned v = 0; v < side * side; ++v) {
        const float x = static_cast<float>(v % side), y = static_cast<float>(v / side);
        const Float3 at = {x, y, 0.3f * static_cast<float>(v * 7 % 5)};
        const std::array<float, 2> uv = {x / side + 0.01f * static_cast<float>(v % 3), y / side};
        mesh.attribute(p)->SetAttributeValue(draco::AttributeValueIndex(v), at.data());
        mesh.attribute(t)->SetAttributeValue(draco::AttributeValueIndex(v), uv.data());
        if (x + 1 == side || y + 1 == side) continue;
        const draco::PointIndex a(v), b(v + 1), c(v + side), d(v + side + 1);
        mesh.AddFace({a, b, c});
        mesh.AddFace({b, d, c});
    }
    draco::ExpertEncoder encoder(mesh);
    encoder.SetAttributeQuantization(p, 11);
    encoder.SetAttributeQuantization(t, 10);
    encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
    encoder.SetSpeedOptions(0, 0);
    REQUIRE(encoder.SetAttributePredictionScheme(t, draco::MESH_PREDICTION_TEX_COORDS_PORTABLE).ok());
    draco::EncoderBuffer buffer;
    REQUIRE(encoder.EncodeToBuffer(&buffer).ok());
    return Bytes(buffer.data(), buffer.data() + buffer.size());
}

TEST_CASE("Draco: a payload of 600 bytes that keeps the library busy is left alone")
{
    const auto spent = [] {
        rusage used{};
        ::getrusage(RUSAGE_CHILDREN, &used);
        return static_cast<double>(used.ru_utime.tv_sec) + 1e-6 * static_cast<double>(used.ru_utime.tv_usec);
    };
    const Bytes payload = draco_sheet();
    const auto sheet = [](const Bytes &bytes) {
        Gltf gltf = with_draco(bytes);
        gltf.json["accessors"][0]["count"] = 144;
        gltf.json["accessors"][1]["count"] = 11 * 11 * 6;
        return gltf;
    };
    CHECK(told(sheet(payload)) == "converted");
    std::size_t late = 0;
    for (std::size_t i = payload.size() - 48; i + 4 <= payload.size(); ++i) {
        Bytes changed = payload;
        std::memset(changed.data() + i, 0xff, 3);
        changed[i + 3] = 0x7f; // two thousand million turns
        const double before = spent();
        const std::string message = told(sheet(changed));
        CHECK((message == "converted" || message.starts_with("3: ")));
        CHECK(spent() - before < 3.5);
        late += contains(message, "Draco did not finish with this payload in time: damaged or hostile");
    }
    CHECK(late >= 1);
}

TEST_CASE("Draco: nothing that its process answers is believed")
{
    struct Said : voxshell::Answers {
        Bytes bytes;
        std::size_t at = 0;
        bool read(void *data, std::size_t size) override
        {
            const bool is_there = size <= bytes.size() - at;
            if (is_there) std::memcpy(data, bytes.data() + at, size);
            at = is_there ? at + size : bytes.size();
            return is_there;
        }
        std::string obituary() override { return "it is gone"; }
    };
    const auto refusal = [](const std::vector<std::uint64_t> &head, const std::vector<std::uint32_t> &face) {
        Said said;
        said.bytes = bytes_of(head);
        const Bytes points(24 * 3), corners = bytes_of(face);
        said.bytes.insert(said.bytes.end(), points.begin(), points.end());
        said.bytes.insert(said.bytes.end(), corners.begin(), corners.end());
        try {
            return std::to_string(voxshell::receive_draco(said, true, 1, 3).faces.size());
        } catch (const voxshell::Failure &failure) {
            return std::string(failure.what());
        }
    };
    CHECK(refusal({0, 3, 3, 1}, {0, 1, 2}) == "1");
    CHECK(refusal({0, 3, 3, 1}, {0, 1, 3}) == "damaged payload: an index beyond the vertices");
    CHECK(refusal({0, 4, 4, 1}, {0, 1, 2}) == "more vertices than the accessor declares");
    CHECK(refusal({0, 3, 3, 2}, {0, 1, 2}) == "more triangles than the accessor declares");
    CHECK(refusal({0, 3, 2, 1}, {0, 1, 2}) == "Draco's reader sent nonsense");
    CHECK(refusal({std::uint64_t{1} << 40, 3, 3, 1}, {0, 1, 2}) == "Draco's reader sent nonsense");
    CHECK(refusal({900, 3, 3, 1}, {0, 1, 2}) == "it is gone");
}

TEST_CASE("meshopt: attributes, triangles, index sequences, under both names")
{
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
        for (const Packed mode : {Packed::triangles, Packed::indices})
            CHECK(volume_of(with_meshopt(name, mode)) == doctest::Approx(1));
}

TEST_CASE("meshopt: exponential filter")
{
    Gltf gltf = with_meshopt("EXT_meshopt_compression", Packed::indices);
    std::vector<std::uint32_t> filtered; // mantissa 1 or 0, exponent 1: coordinates 0 and 2
    for (const Float3 &p : cube_points)
        for (const float x : p) filtered.push_back(1u << 24 | (x == 0 ? 0u : 1u));
    const Bytes payload = packed(Packed::attributes, filtered.data(), 8, 12);
    Json &link = gltf.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"];
    while (gltf.bin.size() % 4) gltf.bin.push_back(0);
    link["byteOffset"] = gltf.bin.size();
    link["byteLength"] = payload.size();
    link["filter"] = "EXPONENTIAL";
    gltf.bin.insert(gltf.bin.end(), payload.begin(), payload.end());
    gltf.json["buffers"][0]["byteLength"] = gltf.bin.size();
    CHECK(volume_of(gltf) == doctest::Approx(8));
}

TEST_CASE("meshopt: quaternion filter in GPU instancing")
{
    Gltf gltf;
    const std::size_t cube = gltf.cube();
    // 90 degrees about z: the dropped component is w (index 3), the largest; z of w = z is 1/sqrt(2) of the
    // range.
    const float turn[4] = {0, 0, 0.70710678f, 0.70710678f};
    std::array<std::int16_t, 4> encoded{};
    meshopt_encodeFilterQuat(encoded.data(), 1, 8, 16, turn);
    const Bytes payload = packed(Packed::attributes, encoded.data(), 1, 8);
    while (gltf.bin.size() % 4) gltf.bin.push_back(0);
    const Json link = {
        {"buffer", 0}, {"byteOffset", gltf.bin.size()}, {"byteLength", payload.size()}, {"byteStride", 8},
        {"count", 1},  {"mode", "ATTRIBUTES"},          {"filter", "QUATERNION"}};
    gltf.bin.insert(gltf.bin.end(), payload.begin(), payload.end());
    const std::size_t view =
        gltf.add("bufferViews",
                 {{"buffer", 1}, {"byteLength", 8}, {"extensions", {{"EXT_meshopt_compression", link}}}});
    const std::size_t rotation = gltf.accessor(view, 5122, "VEC4", 1);
    gltf.json["accessors"][rotation]["normalized"] = true;
    gltf.use("EXT_meshopt_compression", true);
    gltf.root({{"mesh", cube},
               {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"ROTATION", rotation}}}}}}}});
    gltf.json["buffers"] = {{{"byteLength", gltf.bin.size()}}, {{"byteLength", 8}}};
    const Folder folder;
    const Box b = box(flatten(voxshell::import_scene(folder.write("a.glb", gltf.glb()), {})));
    CHECK(b.low[0] == doctest::Approx(-1).epsilon(1e-3));
    CHECK(b.high[0] == doctest::Approx(0).epsilon(1e-3));
    CHECK(b.high[1] == doctest::Approx(1).epsilon(1e-3));
}

TEST_CASE("meshopt: unknown modes and versions fall back where there is something to fall back to")
{
    Gltf gltf = with_meshopt("EXT_meshopt_compression", Packed::triangles, false);
    gltf.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["mode"] = "FUTURE";
    CHECK(contains(told(gltf), "5: bufferViews[0].extensions.EXT_meshopt_compression: mode 'FUTURE'"));
    gltf.json["buffers"][1].erase("extensions");
    Gltf plain;
    plain.bin = bytes_of(cube_points);
    plain.bin.resize(168);
    gltf.json["buffers"][1]["uri"] = plain.data_uri();
    const Folder folder;
    const auto scene = voxshell::import_scene(folder.write("a.glb", gltf.glb()), {});
    CHECK(warns(scene, "gltf-fallback-buffer"));
    CHECK(volume(flatten(scene)) == doctest::Approx(1));
    gltf.json["extensionsRequired"] = {"EXT_meshopt_compression"};
    CHECK(told(gltf).starts_with("5: "));
}

TEST_CASE("meshopt: what does not agree is refused")
{
    const auto broken = [](const char *key, const Json &value) {
        Gltf gltf = with_meshopt("EXT_meshopt_compression", Packed::triangles);
        gltf.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][key] = value;
        return told(gltf);
    };
    CHECK(contains(broken("count", 7), "7 x 12 bytes decode to 84, the bufferView has 96"));
    CHECK(contains(broken("byteStride", 300), "byteStride: 300 is out of range"));
    CHECK(contains(broken("byteLength", 100000), "do not fit buffer 0"));
    CHECK(contains(broken("buffer", 2), "buffer: 2 does not exist"));
    CHECK(contains(broken("mode", 3), "mode: not a string"));
    CHECK(contains(broken("mode", "TRIANGLES"), "is not allowed"));
    CHECK(contains(broken("filter", "OCTAHEDRAL"), "is not allowed"));
    CHECK(contains(broken("filter", "COLOR"), "5: "));
    Gltf gltf = with_meshopt("EXT_meshopt_compression", Packed::triangles);
    gltf.json["buffers"][1]["byteLength"] = std::uint64_t{1} << 40;
    gltf.json["bufferViews"][0]["byteLength"] = std::uint64_t{12} << 32;
    gltf.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]["count"] = std::uint64_t{1} << 32;
    CHECK(contains(told(gltf), "cannot hold 4294967296 elements"));
}

TEST_CASE("meshopt: every changed byte ends well")
{
    const Gltf whole = with_meshopt("EXT_meshopt_compression", Packed::triangles);
    for (std::size_t i = 0; i < whole.bin.size(); ++i)
        for (const int value : {0, 1, 0x7f, 0xff}) {
            Gltf gltf = whole;
            gltf.bin[i] = static_cast<std::uint8_t>(value);
            const std::string message = told(gltf);
            CHECK((message == "converted" || message.starts_with("3: ") || message.starts_with("5: ")));
        }
}
