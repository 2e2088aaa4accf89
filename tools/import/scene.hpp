// SPDX-License-Identifier: GPL-3.0-or-later
// What every importer makes: meshes, their instances, and where they came from.
#pragma once

#include "cli/failure.hpp"
#include "import/point.hpp"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

using Triangle = std::array<std::uint32_t, 3>; ///< vertex indices, counter-clockwise seen from outside

/// Triangles in one frame, lengths in metres. Every index is below vertices.size(), every
/// coordinate is finite: importers guarantee it.
struct Mesh {
    /// A run of triangles that the file has under a name of its own.
    struct Solid {
        std::string name; ///< may be empty
        std::size_t first;
    };
    std::string name;
    std::vector<Point> vertices;
    std::vector<Triangle> triangles;
    std::vector<Solid> solids = {}; ///< of an STL with several, in order; else none
    std::vector<std::uint32_t> materials =
        {}; ///< of Scene::materials, each once, as its triangles come to them
};

/// One occurrence of a mesh in the scene.
struct Instance {
    std::string name;   ///< node path, "/arm/gripper/jaw"; unique within the scene
    std::uint32_t mesh; ///< index into Scene::meshes
    /// Scene from mesh, 3 x 4 row-major (rotation, scale, shear | translation [m]). A negative
    /// determinant mirrors: flatten() turns the winding round so that the outside stays outside.
    std::array<double, 12> pose{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    std::optional<std::uint32_t> node = {}; ///< of Scene::nodes, where there are any
};

/// A node of the tree that the instances hang on.
struct SceneNode {
    std::string name;                    ///< as the file has it: may be empty, and another's too
    std::optional<std::uint32_t> parent; ///< of Scene::nodes, before this one; none: it stands in the scene
    std::array<double, 12> pose;         ///< parent (or scene) from node, 3 x 4 row-major
};

struct Scene {
    std::string name; ///< file name without folder and ending
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<SceneNode> nodes = {};       ///< glTF: all of the scene's; else none
    std::vector<std::string> materials = {}; ///< glTF: names of the file's, which may be empty
    std::array<std::uint8_t, 32>
        source_hash{}; ///< SHA-256 of the input file's bytes and then of each external buffer's
    std::array<double, 12> stand{
        1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};  ///< with ImportOptions::node: where it stands, file from node
    std::vector<std::filesystem::path> files; ///< all that was read: the input file, then external buffers
    std::vector<Warning> warnings;
};

struct ImportOptions {
    std::optional<double> unit; ///< metres per file unit; required for STL, refused for glTF
    bool z_up = false;          ///< turn a Z-up part into the scene frame (+Y up): (x, y, z) -> (x, z, -y)
    std::string
        node{}; ///< glTF: only this node of the scene and what is below it, in its own frame (its scale
                ///< applied); refused unless its name occurs once and its pose is one of a solid
};

/// What an importer's files are, told by their ending, of any case.
struct FileFormat {
    const char *ending;
    bool has_unit;  ///< else ImportOptions::unit has to say it
    bool has_nodes; ///< ImportOptions::node
    bool refers;    ///< other files may belong to it
};
const FileFormat *format_of(const std::filesystem::path &path); ///< nullptr: nobody reads it
std::string import_endings();                                   ///< ".stl, .gltf, .glb"

/// Reads `path` by its ending. Throws Failure with the file's path: system
/// (cannot read), invalid (not what it says it is), unsupported (valid but not readable by us).
/// Never returns a scene without triangles, with an index out of range or a non-finite coordinate.
Scene import_scene(const std::filesystem::path &path, const ImportOptions &options);

/// All instances as one mesh in the scene frame, in instance order. Mirrored instances get their
/// winding turned round. No welding: vertices stay as they came.
Mesh flatten(const Scene &scene);

} // namespace voxshell
