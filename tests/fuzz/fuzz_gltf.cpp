// SPDX-License-Identifier: GPL-3.0-or-later
// Any bytes as a .glb or .gltf, with what is in it: JSON, buffers, Draco, meshopt. Nothing beside it can be
// read.
#include "fuzz_import.hpp"

using namespace voxshell;

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

std::size_t fuzz_seed(std::uint32_t, std::uint8_t *bytes, std::size_t most)
{
    static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const std::uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    std::string json(document);
    while (json.size() % 4) json.push_back(' ');
    const std::size_t total = header + chunk + json.size() + chunk + 60;
    if (total > most) return 0;
    std::memcpy(bytes, "glTF\2\0\0\0", 8);
    put(bytes + 8, total);
    put(bytes + header, json.size());
    std::memcpy(bytes + header + 4, "JSON", 4);
    std::memcpy(bytes + header + chunk, json.data(), json.size());
    std::uint8_t *at = bytes + header + chunk + json.size();
    put(at, 60);
    std::memcpy(at + 4, "BIN", 4);
    std::memcpy(at + chunk, corners, sizeof corners);
    std::memcpy(at + chunk + sizeof corners, indices, sizeof indices);
    return total;
}
