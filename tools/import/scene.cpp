// SPDX-License-Identifier: GPL-3.0-or-later
#include "import/scene.hpp"

#include "import/importers.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace voxshell {
namespace {

struct Importer {
    FileFormat format;
    Scene (*import)(const Source &, const ImportOptions &);
};

//                                    unit nodes refers
constexpr Importer importers[] = {{{".stl", false, false, false}, import_stl},
                                  {{".gltf", true, true, true}, import_gltf},
                                  {{".glb", true, true, true}, import_glb}};

const Importer *importer_of(const std::filesystem::path &path)
{
    std::string ending = path.extension().string();
    for (char &c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    for (const Importer &importer : importers)
        if (ending == importer.format.ending) return &importer;
    return nullptr;
}

// What flatten() unfolds at most: a small file with many instances must not fill the memory.
constexpr std::uint64_t max_flat = std::uint64_t{1} << 27;

/// Keeps what scene.hpp promises, whatever an importer did.
void check(const Source &source, const Scene &scene)
{
    for (const Mesh &mesh : scene.meshes) {
        for (const Triangle &t : mesh.triangles)
            for (const std::uint32_t v : t)
                if (v >= mesh.vertices.size()) source.refuse(ExitCode::bug, "an index beyond the vertices");
        for (const Point &p : mesh.vertices)
            for (const double x : p)
                if (!std::isfinite(x)) source.invalid("a coordinate is not finite");
    }
    std::uint64_t triangles = 0;
    for (const Instance &instance : scene.instances) {
        triangles += scene.meshes.at(instance.mesh).triangles.size();
        for (const double x : instance.pose)
            if (!std::isfinite(x)) {
                source.invalid(fmt::format("the transform of {} is not finite", instance.name));
            }
    }
    if (triangles == 0) source.invalid("no triangles reachable from the scene");
}

double determinant(const std::array<double, 12> &m)
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}

} // namespace

Bytes read_whole_file(const std::filesystem::path &path, const std::string &blame)
{
    const auto fail = [&](const std::string &why) {
        const std::string what =
            path.string() == blame ? "" : fmt::format("{}: ", printable(path.string(), 300));
        throw Failure(ExitCode::system, blame, what + why);
    };
    struct File {
        int descriptor;
        ~File()
        {
            if (descriptor >= 0) ::close(descriptor);
        }
    };
    // Without O_NONBLOCK a FIFO would wait for a writer before we can see what it is.
    const File file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (file.descriptor < 0) fail(fmt::format("cannot read: {}", std::strerror(errno)));
    struct stat status = {};
    if (::fstat(file.descriptor, &status) != 0) fail(fmt::format("cannot read: {}", std::strerror(errno)));
    if (!S_ISREG(status.st_mode)) fail("cannot read: not a regular file");

    Bytes bytes(static_cast<std::size_t>(status.st_size));
    std::size_t got = 0;
    while (got < bytes.size()) {
        const ssize_t n = ::read(file.descriptor, bytes.data() + got, bytes.size() - got);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) fail(fmt::format("cannot read: {}", std::strerror(errno)));
        if (n == 0) fail("cannot read: it shrank while it was read");
        got += static_cast<std::size_t>(n);
    }
    const std::string_view text(reinterpret_cast<const char *>(bytes.data()), bytes.size());
    if (text.starts_with("version https://git-lfs.github.com/spec/")) {
        const std::string which =
            path.string() == blame ? "this is" : printable(path.filename().string()) + " is";
        throw Failure(ExitCode::invalid, blame,
                      which + " a git-lfs pointer, not the file itself: run 'git lfs pull'");
    }
    return bytes;
}

std::string printable(std::string_view text, std::size_t limit)
{
    std::string out(text.substr(0, limit));
    if (text.size() > limit) {
        // Not in the middle of a UTF-8 character.
        while (!out.empty() && (static_cast<unsigned char>(text[out.size()]) & 0xc0) == 0x80) out.pop_back();
    }
    for (char &c : out)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '_';
    return text.size() > limit ? out + "..." : out;
}

const FileFormat *format_of(const std::filesystem::path &path)
{
    const Importer *importer = importer_of(path);
    return importer ? &importer->format : nullptr;
}

std::string import_endings()
{
    std::string out;
    for (const Importer &importer : importers)
        out += (out.empty() ? "" : ", ") + std::string(importer.format.ending);
    return out;
}

Scene import_scene(const std::filesystem::path &path, const ImportOptions &options)
{
    const std::string name = path.string();
    const Importer *importer = importer_of(path);
    if (!importer) {
        throw Failure(ExitCode::unsupported, name,
                      fmt::format("the ending '{}' is none of {}", printable(path.extension().string(), 20),
                                  import_endings()));
    }
    if (!options.node.empty() && !importer->format.has_nodes)
        throw Failure(ExitCode::usage, name, fmt::format("a {} file has no nodes", importer->format.ending));
    Bytes bytes = read_whole_file(path, name);
    Sha256Stream hash;
    hash.update(bytes);
    std::vector<std::filesystem::path> files{path};
    const Source source{path, name, bytes, hash, files};
    Scene scene;
    try {
        scene = importer->import(source, options);
    } catch (const std::bad_alloc &) {
        source.refuse(ExitCode::system, "not enough memory to import this file");
    }
    scene.name = path.stem().string();
    scene.source_hash = hash.digest();
    scene.files = std::move(files);
    for (Mesh &mesh : scene.meshes)
        if (mesh.name.empty()) mesh.name = scene.name;
    const auto stand_up = [](std::array<double, 12> &m) { // (x, y, z) -> (x, z, -y) after the pose
        std::swap_ranges(m.begin() + 4, m.begin() + 8, m.begin() + 8);
        for (std::size_t i = 8; i < 12; ++i) m[i] = 0.0 - m[i];
    };
    for (Instance &instance : scene.instances) {
        if (instance.name.empty()) instance.name = "/" + scene.name;
        if (options.z_up) stand_up(instance.pose);
    }
    for (SceneNode &node : scene.nodes)
        if (options.z_up && !node.parent) stand_up(node.pose);
    check(source, scene);
    return scene;
}

Mesh flatten(const Scene &scene)
{
    std::uint64_t vertices = 0, triangles = 0;
    for (const Instance &instance : scene.instances) {
        vertices += scene.meshes.at(instance.mesh).vertices.size();
        triangles += scene.meshes[instance.mesh].triangles.size();
    }
    if (vertices > max_flat || triangles > max_flat) {
        throw Failure(ExitCode::unsupported, scene.name,
                      fmt::format("the instances unfold to {} vertices and {} triangles, more than {}",
                                  vertices, triangles, max_flat));
    }
    Mesh flat;
    flat.name = scene.name;
    flat.vertices.reserve(vertices);
    flat.triangles.reserve(triangles);
    for (const Instance &instance : scene.instances) {
        const Mesh &mesh = scene.meshes[instance.mesh];
        const std::array<double, 12> &m = instance.pose;
        const auto base = static_cast<std::uint32_t>(flat.vertices.size());
        for (const Point &p : mesh.vertices) {
            Point q;
            for (std::size_t r = 0; r < 3; ++r) {
                q[r] = m[4 * r] * p[0] + m[4 * r + 1] * p[1] + m[4 * r + 2] * p[2] + m[4 * r + 3];
                if (!std::isfinite(q[r])) {
                    throw Failure(
                        ExitCode::invalid, scene.name,
                        fmt::format("a coordinate of {} is not finite in the scene", instance.name));
                }
            }
            flat.vertices.push_back(q);
        }
        const bool mirrored = determinant(m) < 0;
        for (Triangle t : mesh.triangles) {
            if (mirrored) std::swap(t[1], t[2]);
            flat.triangles.push_back({base + t[0], base + t[1], base + t[2]});
        }
    }
    return flat;
}

} // namespace voxshell
