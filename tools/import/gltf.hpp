// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0 inside the import room: from bytes to a validated document, from there to numbers, triangles, a
// scene. tinygltf reads the document, but only what gltf_validate.cpp has checked and reduced to geometry:
// it trusts indices and sizes, follows any path, and cannot take Draco primitives or data-less buffers.
#pragma once

#include "import/importers.hpp"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace voxshell {

class Fence;

struct GltfBuffer {
    std::optional<std::string> uri;   ///< of a file, or a data URI that is written with escapes
    std::span<std::uint8_t> embedded; ///< a data URI in the document. Neither: the BIN chunk, or nothing
    std::uint64_t length = 0;         ///< [bytes], as declared
    bool fallback = false;            ///< stands for what a compression extension replaces; has no data
};

/// EXT_meshopt_compression or KHR_meshopt_compression of a bufferView.
struct GltfMeshopt {
    std::string extension;
    std::size_t buffer = 0;
    std::uint64_t offset = 0, length = 0, stride = 0, count = 0;
    std::string mode, filter;
};

/// KHR_draco_mesh_compression of a primitive.
struct GltfDraco {
    std::size_t view = 0;
    std::optional<std::uint32_t> position; ///< unique id of the attribute; none: positions are not compressed
};

/// A document in which every reference, type and range holds; what the buffers contain is not yet checked.
struct GltfDocument {
    tinygltf::Model model; ///< scenes, nodes, meshes, accessors, bufferViews; nothing else
    std::vector<GltfBuffer> buffers;
    std::span<const std::uint8_t> bin;                    ///< payload of the BIN chunk
    std::vector<std::optional<GltfMeshopt>> meshopt;      ///< per bufferView
    std::map<std::pair<int, int>, GltfDraco> draco;       ///< per {mesh, primitive}
    std::map<int, std::map<std::string, int>> instancing; ///< EXT_mesh_gpu_instancing: attributes per node
    std::vector<std::string> required;                    ///< extensionsRequired
    bool quantized = false;                               ///< KHR_mesh_quantization is in use
    bool declares_scene = false;
    std::size_t animations = 0;
    std::vector<std::string> materials; ///< names

    bool requires_extension(const std::string &name) const
    {
        return std::find(required.begin(), required.end(), name) != required.end();
    }
};

struct GltfJson;
/// Validates the JSON (gltf_validate.cpp).
GltfDocument read_gltf_document(const Source &source, const GltfJson &json,
                                std::span<const std::uint8_t> bin);

/// The document's default scene as meshes and instances, or of it what `node` and those below it hold
/// (gltf_scene.cpp).
Scene import_gltf_document(const Source &source, const GltfDocument &document, const std::string &node);

/// JSON and BIN chunk of a file: all of a .gltf, or the chunks of a GLB, which its first bytes say. Failure
/// for a GLB that is broken.
struct GltfParts {
    std::string_view json;
    std::span<const std::uint8_t> bin;
};
GltfParts gltf_parts(const Source &source, bool is_glb);

std::size_t gltf_component_size(int component_type); ///< [bytes]

/// Bytes and numbers of a document. Loads lazily, decodes each view once, keeps a budget of decoded elements
/// so that a small file cannot ask for unbounded memory or time.
class GltfBuffers {
  public:
    GltfBuffers(const Source &source, const GltfDocument &document, std::vector<Warning> &warnings);

    /// Exactly bufferView.byteLength bytes, decompressed where an extension says so.
    std::span<const std::uint8_t> view(std::size_t index);

    /// All elements of an accessor, components in a row, normalised integers as numbers.
    std::vector<double> numbers(std::size_t accessor);
    /// A SCALAR accessor of unsigned integers.
    std::vector<std::uint32_t> indices(std::size_t accessor);

    /// Takes `elements` from the budget; refuses when it is used up.
    void spend(std::uint64_t elements);

  private:
    std::span<const std::uint8_t> buffer(std::size_t index);
    std::span<const std::uint8_t> external(std::size_t index, const std::string &uri);
    Bytes decompress(std::size_t view, const GltfMeshopt &link);
    std::span<const std::uint8_t> elements(int view, std::uint64_t offset, std::uint64_t bytes);
    template<class T, class Read>
    std::vector<T> read(std::size_t accessor, Read read_component);

    const Source &source_;
    const GltfDocument &document_;
    std::vector<Warning> &warnings_;
    std::vector<std::optional<std::span<const std::uint8_t>>> buffers_;
    std::map<std::string, Bytes> files_;   ///< by canonical path
    std::map<std::size_t, Bytes> owned_;   ///< data URIs that are written with escapes, by buffer
    std::map<std::size_t, Bytes> decoded_; ///< decompressed views
    std::uint64_t loaded_, spent_ = 0;
};

/// Draco payload as points (accessor space, not yet normalised) and faces (gltf_draco.cpp).
struct DracoMesh {
    std::vector<std::array<double, 3>> points; ///< empty when `position` was none
    std::size_t point_count = 0;
    std::vector<Triangle> faces;
};

/// Decodes a document's payloads in one child process with bounds, which the first of them starts.
class DracoReader {
  public:
    explicit DracoReader(const Source &source);
    ~DracoReader();
    /// `max_faces`, `max_points`: what the payload may hold at most, checked before anything is allocated.
    /// Failure(invalid) with `where` in front.
    DracoMesh decode(std::span<const std::uint8_t> payload, std::optional<std::uint32_t> position,
                     std::uint64_t max_faces, std::uint64_t max_points, const std::string &where);

  private:
    DracoMesh ask(std::span<const std::uint8_t> payload, std::optional<std::uint32_t> position,
                  std::uint64_t max_faces, std::uint64_t max_points);

    const Source &source_;
    std::unique_ptr<Fence> fence_;
};

/// Meshes of a document as voxshell meshes, each made once (gltf_mesh.cpp).
class GltfMeshes {
  public:
    GltfMeshes(const Source &source, const GltfDocument &document, GltfBuffers &buffers);
    ~GltfMeshes();

    Mesh mesh(int index);
    std::size_t skipped_primitives() const { return skipped_; } ///< points and lines, so far
    bool saw_morph_targets() const { return morphs_; }

  private:
    struct Positions;
    Positions &positions(int accessor);
    void add_primitive(int mesh, int primitive, Mesh &out);
    void add_draco(int mesh, int primitive, const GltfDraco &link, Mesh &out);

    const Source &source_;
    const GltfDocument &document_;
    GltfBuffers &buffers_;
    DracoReader draco_;
    std::vector<std::uint32_t> users_; ///< meshes that use an accessor as POSITION
    std::map<int, std::unique_ptr<Positions>> positions_;
    std::uint32_t stamp_ = 0;
    std::size_t skipped_ = 0;
    bool morphs_ = false;
};

/// A normalised integer component as a number (glTF 2.0, 3.6.2.2).
double gltf_normalized(double raw, int component_type);

} // namespace voxshell
