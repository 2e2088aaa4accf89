// SPDX-License-Identifier: GPL-3.0-or-later
// An imported scene as an assembly: each distinct part once, and where it stands.
#pragma once

#include "container/container.hpp"
#include "import/scene.hpp"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace voxshell {

/// A shape that is converted once. Two meshes are the same part if their vertices and triangles are the same
/// bytes and they are stretched in the same way; turns and moves are the instances' own.
struct AssemblyPart {
    std::string name;   ///< fit for a file's name, unique in the assembly without regard to ASCII case
    std::uint32_t mesh; ///< index into Scene::meshes
    /// Part from mesh, 3 x 3 row-major, symmetric: the scale of the nodes above it, and its mirroring
    /// (negative determinant). Six digits; 1 exactly where no node scales by more than 2e-6.
    std::array<double, 9> shape{1, 0, 0, 0, 1, 0, 0, 0, 1};
    Sha256 hash{}; ///< of vertices, triangles and shape
    std::size_t instances = 0;
};

/// Assembly from part: a turn and a move. No scale, so that a rigid body of the runtime can stand there.
struct AssemblyInstance {
    std::string name;                              ///< node path, as Instance::name
    std::size_t part;                              ///< index into Assembly::parts
    std::array<double, 4> orientation{1, 0, 0, 0}; ///< w x y z, unit, w >= 0
    Point position{};                              ///< [m]
    std::optional<std::uint32_t> node{};           ///< index into Assembly::nodes
    std::uint32_t mesh = 0;                        ///< index into Assembly::materials_of_mesh
};

struct Assembly {
    std::vector<AssemblyPart> parts; ///< in the order of their first instance
    std::vector<AssemblyInstance> instances;
    std::vector<SceneNode> nodes; ///< the tree as the file has it
    std::vector<std::string> materials;
    std::vector<std::vector<std::uint32_t>> materials_of_mesh;
    double pose_error = 0; ///< most that a vertex is moved by rounding shapes and turns [m]
};

/// Throws Failure(invalid), naming the node, where a transform flattens its part.
Assembly assemble(const Scene &scene);

/// The part alone, in its own frame, named as it; source_hash is its hash.
Scene part_scene(const Scene &scene, const AssemblyPart &part);

/// Each solid of an STL as a mesh and an instance of its own; any other scene as it is.
Scene split_solids(Scene scene);

/// Text made fit for a file's name: '/', control characters and a leading '.' become '_', at most 120 bytes;
/// "part" if nothing is left.
std::string file_name(std::string_view text);

} // namespace voxshell
