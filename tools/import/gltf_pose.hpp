// SPDX-License-Identifier: GPL-3.0-or-later
// Transforms of glTF nodes as matrices: 3 x 4, row-major, rotation, scale and shear | translation [m].
#pragma once

#include <array>
#include <optional>

namespace tinygltf {
class Node;
}

namespace voxshell {

using GltfPose = std::array<double, 12>;
inline constexpr GltfPose gltf_identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/// First `b`, then `a`.
GltfPose compose(const GltfPose &a, const GltfPose &b);

/// T * R * S; `q` is x y z w, of any length but zero.
GltfPose from_trs(const double *t, const double *q, const double *s);

/// Of a node in its parent.
GltfPose pose_of(const tinygltf::Node &node);

/// A pose that a solid can have, and the one scale that its geometry has before it: pose * scale.
struct GltfRigid {
    GltfPose pose;
    double scale;
};

/// Nothing for what stretches, shears or mirrors by more than 1e-5, which is what a file's float32 leave.
std::optional<GltfRigid> rigid_of(const GltfPose &pose);

} // namespace voxshell
