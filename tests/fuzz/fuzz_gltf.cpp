// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a .glb or .gltf, with what is in it: JSON, buffers, meshopt. Nothing beside it can be read. What
// a Draco payload says behind its header is taken for the answer of Draco's process (fuzz_draco has the process).
#include "fuzz_import.hpp"
#include "import/gltf_draco.hpp"

#include <meshoptimizer.h>

using namespace voxshell;

namespace voxshell {

// In place of gltf_draco_fence.cpp's.
DracoReader::DracoReader(const Source &source) : source_(source) {}
DracoReader::~DracoReader() = default;
DracoMesh DracoReader::ask(std::span<const std::uint8_t> payload, std::optional<std::uint32_t> position,
                           std::uint64_t max_faces, std::uint64_t max_points)
{
    fuzz::Said said(payload.subspan(std::min<std::size_t>(payload.size(), 16)));
    return receive_draco(said, position.has_value(), max_faces, max_points);
}

} // namespace voxshell

namespace {

constexpr std::size_t header = 12, chunk = 8;
constexpr char document[] =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"a","mesh":0,"translation":[1,2,3],"children":[1]},)"
    R"({"mesh":0,"scale":[-1,1,2],"rotation":[0,0,0,1]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"mode":4}]}],)"
    R"("accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,1]},)"
    R"({"bufferView":1,"componentType":5123,"count":6,"type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":48},)"
    R"({"buffer":0,"byteOffset":48,"byteLength":12}],"buffers":[{"byteLength":60}]})";

void put(std::uint8_t *to, std::size_t number)
{
    const auto value = static_cast<std::uint32_t>(number);
    std::memcpy(to, &value, sizeof value);
}

std::uint32_t get(const std::uint8_t *from)
{
    std::uint32_t value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t size)
{
    Sha256Stream hash;
    const bool is_binary = size >= 4 && std::memcmp(bytes, "glTF", 4) == 0;
    std::vector<std::filesystem::path> files;
    Bytes own(bytes, bytes + size);
    const Source source{"/nowhere/fuzz.glb", "fuzz.glb", own, hash, files};
    try {
        const Scene scene = is_binary ? import_glb(source, {}) : import_gltf(source, {});
        fuzz::check(scene);
        std::size_t triangles = 0;
        for (const Instance &instance : scene.instances)
            triangles += scene.meshes[instance.mesh].triangles.size();
        if (triangles < 100000) (void)flatten(scene);
    } catch (const Failure &failure) {
        fuzz::check(failure);
    }
    return 0;
}

/// The text or the bytes of a GLB changed, and its lengths made right again.
std::size_t LLVMFuzzerCustomMutator(std::uint8_t *bytes, std::size_t size, std::size_t most, unsigned seed)
{
    fuzz::Dice dice(seed);
    if (size < header + chunk || std::memcmp(bytes, "glTF", 4) != 0 ||
        get(bytes + header) > size - header - chunk || dice.below(32) == 0) {
        if (size > 0 && bytes[0] == '{')
            return fuzz::change_json(reinterpret_cast<char *>(bytes), size, most, dice);
        return LLVMFuzzerMutate(bytes, size, most);
    }
    const std::size_t json_size = get(bytes + header), rest_at = header + chunk + json_size;
    std::string json(reinterpret_cast<const char *>(bytes) + header + chunk, json_size);
    std::string binary(reinterpret_cast<const char *>(bytes) + rest_at, size - rest_at);
    const bool has_binary = binary.size() >= chunk;
    if (has_binary) binary.erase(0, chunk);
    if (has_binary && dice.below(3) == 0) {
        const std::size_t before = binary.size();
        binary.resize(before + 64);
        binary.resize(LLVMFuzzerMutate(reinterpret_cast<std::uint8_t *>(binary.data()), before, before + 64));
    } else {
        const std::size_t before = json.size();
        json.resize(before + 256);
        json.resize(fuzz::change_json(json.data(), before, before + 256, dice));
    }
    while (json.size() % 4) json.push_back(' ');
    while (binary.size() % 4) binary.push_back('\0');
    const std::size_t total = header + chunk + json.size() + (has_binary ? chunk + binary.size() : 0);
    if (total > most) return size;
    put(bytes + 8, total);
    put(bytes + header, json.size());
    std::memcpy(bytes + header + chunk, json.data(), json.size());
    if (has_binary) {
        std::uint8_t *at = bytes + header + chunk + json.size();
        put(at, binary.size());
        std::memcpy(at + 4, "BIN", 4);
        std::memcpy(at + chunk, binary.data(), binary.size());
    }
    return total;
}

namespace {

template<class T, std::size_t n>
std::string bytes_of(const T (&values)[n])
{
    return {reinterpret_cast<const char *>(values), sizeof values};
}

/// A header of Draco's, sequential with 2 faces and 4 points, filled up to 16; then an answer.
std::string draco_answer()
{
    std::string payload("DRACO\2\2\1\0\0\0\2\4\0\0\0", 16);
    const std::uint64_t head[4] = {0, 4, 4, 2};
    const double points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::uint32_t faces[6] = {0, 1, 2, 0, 2, 3};
    return payload + bytes_of(head) + bytes_of(points) + bytes_of(faces);
}

std::string replaced(std::string text, const std::string &what, const std::string &by)
{
    return text.replace(text.find(what), what.size(), by);
}

} // namespace

/// Plain; with the points and the triangles under meshopt; with an answer of Draco's process.
std::size_t fuzz_seed(std::uint32_t number, std::uint8_t *bytes, std::size_t most)
{
    static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const std::uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    static const unsigned wide[6] = {0, 1, 2, 0, 2, 3};
    std::string json(document), binary = bytes_of(corners) + bytes_of(indices);
    if (number % 4 == 1 || number % 4 == 2) {
        std::uint8_t packed[2][512];
        const std::size_t size[2] = {meshopt_encodeVertexBuffer(packed[0], sizeof packed[0], corners, 4, 12),
                                     number % 4 == 1
                                         ? meshopt_encodeIndexBuffer(packed[1], sizeof packed[1], wide, 6)
                                         : meshopt_encodeIndexSequence(packed[1], sizeof packed[1], wide, 6)};
        binary.assign(reinterpret_cast<const char *>(packed[0]), size[0]);
        binary.append(reinterpret_cast<const char *>(packed[1]), size[1]);
        const std::string link = R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)";
        json = replaced(json, R"({"buffer":0,"byteLength":48})",
                        R"({"buffer":1,"byteLength":48)" + link + R"(0,"byteLength":)" +
                            std::to_string(size[0]) + R"(,"byteStride":12,"count":4,"mode":"ATTRIBUTES"}}})");
        json = replaced(json, R"({"buffer":0,"byteOffset":48,"byteLength":12})",
                        R"({"buffer":1,"byteOffset":48,"byteLength":12)" + link + std::to_string(size[0]) +
                            R"(,"byteLength":)" + std::to_string(size[1]) +
                            R"(,"byteStride":2,"count":6,"mode":")" +
                            (number % 4 == 1 ? "TRIANGLES" : "INDICES") + R"("}}})");
        json = replaced(
            json, R"("buffers":[{"byteLength":60}])",
            R"("buffers":[{"byteLength":)" + std::to_string(binary.size()) +
                R"(},{"byteLength":60,"extensions":{"EXT_meshopt_compression":{"fallback":true}}}],)"
                R"("extensionsUsed":["EXT_meshopt_compression"],"extensionsRequired":["EXT_meshopt_compression"])");
    }
    if (number % 4 == 3) {
        binary = draco_answer();
        json = replaced(
            json, R"("mode":4)",
            R"("mode":4,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0}}})");
        json = replaced(json, R"({"bufferView":0,"componentType":5126)", R"({"componentType":5126)");
        json = replaced(json, R"({"bufferView":1,"componentType":5123)", R"({"componentType":5123)");
        json = replaced(json, R"({"buffer":0,"byteLength":48})",
                        R"({"buffer":0,"byteLength":)" + std::to_string(binary.size()) + "}");
        json = replaced(
            json, R"("buffers":[{"byteLength":60}])",
            R"("buffers":[{"byteLength":)" + std::to_string(binary.size()) +
                R"(}],"extensionsUsed":["KHR_draco_mesh_compression"],"extensionsRequired":["KHR_draco_mesh_compression"])");
    }
    while (json.size() % 4) json.push_back(' ');
    while (binary.size() % 4) binary.push_back('\0');
    const std::size_t total = header + chunk + json.size() + chunk + binary.size();
    if (total > most) return 0;
    std::memcpy(bytes, "glTF\2\0\0\0", 8);
    put(bytes + 8, total);
    put(bytes + header, json.size());
    std::memcpy(bytes + header + 4, "JSON", 4);
    std::memcpy(bytes + header + chunk, json.data(), json.size());
    std::uint8_t *at = bytes + header + chunk + json.size();
    put(at, binary.size());
    std::memcpy(at + 4, "BIN", 4);
    std::memcpy(at + chunk, binary.data(), binary.size());
    return total;
}
