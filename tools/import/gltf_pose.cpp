// SPDX-License-Identifier: GPL-3.0-or-later
#include "import/gltf_pose.hpp"

#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

namespace voxshell {

GltfPose compose(const GltfPose &a, const GltfPose &b)
{
    GltfPose c;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t k = 0; k < 4; ++k)
            c[4 * r + k] = a[4 * r] * b[k] + a[4 * r + 1] * b[4 + k] + a[4 * r + 2] * b[8 + k] +
                           (k == 3 ? a[4 * r + 3] : 0);
    return c;
}

GltfPose from_trs(const double *t, const double *q, const double *s)
{
    const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    const double x = q[0] / n, y = q[1] / n, z = q[2] / n, w = q[3] / n;
    return {s[0] * (1 - 2 * (y * y + z * z)), s[1] * 2 * (x * y - w * z),
            s[2] * 2 * (x * z + w * y),       t[0],
            s[0] * 2 * (x * y + w * z),       s[1] * (1 - 2 * (x * x + z * z)),
            s[2] * 2 * (y * z - w * x),       t[1],
            s[0] * 2 * (x * z - w * y),       s[1] * 2 * (y * z + w * x),
            s[2] * (1 - 2 * (x * x + y * y)), t[2]};
}

GltfPose pose_of(const tinygltf::Node &node)
{
    if (!node.matrix.empty()) { // column-major
        GltfPose p;
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t c = 0; c < 4; ++c) p[4 * r + c] = node.matrix[4 * c + r];
        return p;
    }
    constexpr double zero[3] = {0, 0, 0}, no_turn[4] = {0, 0, 0, 1}, one[3] = {1, 1, 1};
    return from_trs(node.translation.empty() ? zero : node.translation.data(),
                    node.rotation.empty() ? no_turn : node.rotation.data(),
                    node.scale.empty() ? one : node.scale.data());
}

std::optional<GltfRigid> rigid_of(const GltfPose &pose)
{
    constexpr double most = 1e-5;
    const auto dot = [&](std::size_t a, std::size_t b) {
        return pose[a] * pose[b] + pose[4 + a] * pose[4 + b] + pose[8 + a] * pose[8 + b];
    };
    const double square = (dot(0, 0) + dot(1, 1) + dot(2, 2)) / 3, scale = std::sqrt(square);
    if (!(scale > 0) || !std::isfinite(scale)) return {};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b <= a; ++b)
            if (!(std::abs(dot(a, b) - (a == b ? square : 0)) <= most * square)) return {};
    const double determinant = pose[0] * (pose[5] * pose[10] - pose[6] * pose[9]) -
                               pose[1] * (pose[4] * pose[10] - pose[6] * pose[8]) +
                               pose[2] * (pose[4] * pose[9] - pose[5] * pose[8]);
    if (!(determinant > 0)) return {};
    GltfRigid rigid{pose, std::abs(scale - 1) <= most ? 1 : scale};
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t c = 0; c < 3; ++c) rigid.pose[4 * r + c] /= scale;
    return rigid;
}

} // namespace voxshell
