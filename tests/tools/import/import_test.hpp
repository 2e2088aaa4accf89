// SPDX-License-Identifier: GPL-3.0-or-later
// What the import tests share: a folder for files, a glTF written piece by piece, measures of meshes.
#pragma once

#include "import/scene.hpp"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace import_test {

using Json = nlohmann::json;
using Bytes = std::vector<std::uint8_t>;
using Float3 = std::array<float, 3>;

/// An empty folder for one test case, gone at its end.
class Folder {
  public:
    Folder()
        : path_(std::filesystem::temp_directory_path() / ("voxshell-import-" + std::to_string(::getpid())))
    {
        std::filesystem::remove_all(path_);
        std::filesystem::create_directories(path_);
    }
    ~Folder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;

    std::filesystem::path path() const { return path_; }
    std::filesystem::path write(const std::string &name, std::string_view text) const
    {
        // A new file each time: some file systems flush one that is truncated and written again.
        std::filesystem::remove(path_ / name);
        std::ofstream(path_ / name, std::ios::binary)
            .write(text.data(), static_cast<std::streamsize>(text.size()));
        return path_ / name;
    }
    std::filesystem::path write(const std::string &name, const Bytes &bytes) const
    {
        return write(name, std::string_view(reinterpret_cast<const char *>(bytes.data()), bytes.size()));
    }

  private:
    std::filesystem::path path_;
};

template<class T>
void append(Bytes &bytes, const T &value)
{
    // Byte by byte: of anything shorter g++ 12 warns that it writes beyond the vector.
    const auto *p = reinterpret_cast<const std::uint8_t *>(&value);
    for (std::size_t i = 0; i < sizeof value; ++i) bytes.push_back(p[i]);
}

template<class T>
Bytes bytes_of(const std::vector<T> &values)
{
    Bytes bytes;
    for (const T &value : values) append(bytes, value);
    return bytes;
}

/// Unit cube from 0 to 1, outside outwards.
inline const std::vector<Float3> cube_points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                                {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
inline const std::vector<std::uint16_t> cube_indices = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                                        1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};

/// A glTF document under construction; buffer 0 is `bin`.
struct Gltf {
    Json json = {{"asset", {{"version", "2.0"}}}};
    Bytes bin;

    std::size_t add(const char *collection, Json object)
    {
        json[collection].push_back(std::move(object));
        return json[collection].size() - 1;
    }
    std::size_t view(const Bytes &bytes)
    {
        while (bin.size() % 4) bin.push_back(0);
        const std::size_t offset = bin.size();
        bin.insert(bin.end(), bytes.begin(), bytes.end());
        return add("bufferViews", {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes.size()}});
    }
    std::size_t accessor(std::size_t view_index, int component, const char *type, std::size_t count)
    {
        return add(
            "accessors",
            {{"bufferView", view_index}, {"componentType", component}, {"type", type}, {"count", count}});
    }
    std::size_t positions(const std::vector<Float3> &points)
    {
        return accessor(view(bytes_of(points)), 5126, "VEC3", points.size());
    }
    template<class T>
    std::size_t indices(const std::vector<T> &values)
    {
        const int component = sizeof(T) == 1 ? 5121 : sizeof(T) == 2 ? 5123 : 5125;
        return accessor(view(bytes_of(values)), component, "SCALAR", values.size());
    }
    std::size_t mesh(Json primitive) { return add("meshes", {{"primitives", {std::move(primitive)}}}); }
    std::size_t cube()
    {
        const std::size_t p = positions(cube_points), i = indices(cube_indices);
        return mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}});
    }
    /// A node in the scene.
    std::size_t root(Json node)
    {
        const std::size_t index = add("nodes", std::move(node));
        if (!json.contains("scenes")) {
            add("scenes", {{"nodes", Json::array()}});
            json["scene"] = 0;
        }
        json["scenes"][0]["nodes"].push_back(index);
        return index;
    }
    void use(const char *extension, bool required)
    {
        json["extensionsUsed"].push_back(extension);
        if (required) json["extensionsRequired"].push_back(extension);
    }

    Bytes glb() const
    {
        Json document = json;
        if (!bin.empty() && !document.contains("buffers"))
            document["buffers"] = {{{"byteLength", bin.size()}}};
        std::string text = document.dump();
        while (text.size() % 4) text.push_back(' ');
        Bytes payload = bin;
        while (payload.size() % 4) payload.push_back(0);
        Bytes out;
        append(out, std::uint32_t{0x46546c67});
        append(out, std::uint32_t{2});
        append(out,
               static_cast<std::uint32_t>(12 + 8 + text.size() + (bin.empty() ? 0 : 8 + payload.size())));
        append(out, static_cast<std::uint32_t>(text.size()));
        append(out, std::uint32_t{0x4e4f534a});
        out.insert(out.end(), text.begin(), text.end());
        if (!bin.empty()) {
            append(out, static_cast<std::uint32_t>(payload.size()));
            append(out, std::uint32_t{0x004e4942});
            out.insert(out.end(), payload.begin(), payload.end());
        }
        return out;
    }
    std::string data_uri() const
    {
        static const char *digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string out = "data:application/octet-stream;base64,";
        for (std::size_t i = 0; i < bin.size(); i += 3) {
            std::uint32_t x = 0;
            for (std::size_t k = 0; k < 3; ++k) x = x << 8 | (i + k < bin.size() ? bin[i + k] : 0u);
            for (std::size_t k = 0; k < 4; ++k)
                out.push_back(i + k > bin.size() ? '=' : digits[x >> (18 - 6 * k) & 63]);
        }
        return out;
    }
    /// The JSON with buffer 0 at `uri`.
    std::string text(const std::string &uri) const
    {
        Json document = json;
        document["buffers"] = {{{"byteLength", bin.size()}, {"uri", uri}}};
        return document.dump();
    }
};

/// Positive when the outside is outside.
inline double volume(const voxshell::Mesh &mesh)
{
    double v = 0;
    for (const voxshell::Triangle &t : mesh.triangles) {
        const voxshell::Point &a = mesh.vertices.at(t[0]), &b = mesh.vertices.at(t[1]),
                              &c = mesh.vertices.at(t[2]);
        v += (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) +
              a[2] * (b[0] * c[1] - b[1] * c[0])) /
             6;
    }
    return v;
}

struct Box {
    voxshell::Point low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
    double size(std::size_t axis) const { return high[axis] - low[axis]; }
};

inline Box box(const voxshell::Mesh &mesh)
{
    Box b;
    for (const voxshell::Point &p : mesh.vertices)
        for (std::size_t a = 0; a < 3; ++a) {
            b.low[a] = std::min(b.low[a], p[a]);
            b.high[a] = std::max(b.high[a], p[a]);
        }
    return b;
}

inline bool warns(const voxshell::Scene &scene, const std::string &code)
{
    for (const voxshell::Warning &w : scene.warnings)
        if (w.code == code) return true;
    return false;
}

/// "3: the message" of the refusal, or "converted".
inline std::string refusal(const std::filesystem::path &path, const voxshell::ImportOptions &options = {})
{
    try {
        voxshell::import_scene(path, options);
    } catch (const voxshell::Failure &failure) {
        const std::string what = failure.what();
        if (what.find('\n') != what.npos) return "more than one line: " + what;
        if (failure.file != path.string()) return "names the file '" + failure.file + "'";
        return std::to_string(static_cast<int>(failure.code)) + ": " + what;
    }
    return "converted";
}

inline bool contains(const std::string &text, const std::string &part)
{
    return text.find(part) != text.npos;
}

} // namespace import_test
