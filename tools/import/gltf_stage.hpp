// SPDX-License-Identifier: GPL-3.0-or-later
// What a glTF says of its scene besides triangles: where nodes are, how they go, and what people wrote to
// them (extras).
#pragma once

#include "import/gltf_pose.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace voxshell {

struct GltfStage {
    struct Node {
        std::string name; ///< as the file has it, may be empty
        std::optional<std::size_t> parent;
        bool is_in_scene = false;      ///< in the default scene
        GltfPose pose = gltf_identity; ///< parent from node
        double translation[3] = {0, 0, 0}, rotation[4] = {0, 0, 0, 1}, scale[3] = {1, 1, 1};
        bool has_matrix = false; ///< in place of these three
    };
    /// What an animation does to a node.
    struct Channel {
        std::size_t animation, channel, node;
        std::string path;           ///< translation, rotation, scale, weights
        std::string interpolation;  ///< LINEAR, STEP, CUBICSPLINE
        std::vector<double> times;  ///< [s], ascending; of translation and rotation that are LINEAR
        std::vector<double> values; ///< three or four for each time
    };
    std::string json;                           ///< the document
    std::array<std::uint8_t, 32> source_hash{}; ///< SHA-256 of the file
    std::optional<std::size_t> scene;           ///< the default one's number
    std::vector<Node> nodes;
    std::vector<Channel> channels;

    /// Scene from node, where it is stored.
    GltfPose pose_in_scene(std::size_t node) const;
};

/// Throws as import_scene(). Checks the document and the animations' data, not that of meshes.
GltfStage read_gltf_stage(const std::filesystem::path &path);

} // namespace voxshell
