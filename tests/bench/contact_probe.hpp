// SPDX-License-Identifier: GPL-3.0-or-later
// What every look-up of points has in common, so that rivals differ in the look-up alone: points to cells,
// contacts to a force.
#pragma once

#include "contact_rival.hpp"

#include <cmath>

namespace voxshell::bench {

/// u = m p + b: a point of the sphere in cells of the static frame, counted from `origin` [cells].
struct CellMotion {
    CellMotion(const Pose &pose, double voxel, const Vec3 &origin)
    {
        for (std::size_t i = 0; i < 9; ++i) m[i] = static_cast<float>(pose.rotation[i] / voxel);
        for (std::size_t i = 0; i < 3; ++i) b[i] = static_cast<float>(pose.position[i] / voxel - origin[i]);
    }
    [[gnu::always_inline]] std::array<float, 3> operator()(float x, float y, float z) const
    {
        return {m[0] * x + m[1] * y + m[2] * z + b[0], m[3] * x + m[4] * y + m[5] * z + b[1],
                m[6] * x + m[7] * y + m[8] * z + b[2]};
    }
    float m[9], b[3];
};

/// Adds contacts up. Only the few points in contact get here.
class ForceSum {
  public:
    ForceSum(const Points &points, const Pose &pose) : points_(points), pose_(pose) {}

    /// The point's inward normal in the static frame.
    Vec3 normal(std::uint32_t i) const { return turned(points_.nx[i], points_.ny[i], points_.nz[i]); }

    void add(std::uint32_t i, const Vec3 &direction, double depth)
    {
        ++contact.contacts;
        if (!(depth > 0)) return;
        const Vec3 arm = turned(points_.x[i], points_.y[i], points_.z[i]);
        const Vec3 f{depth * direction[0], depth * direction[1], depth * direction[2]};
        for (std::size_t a = 0; a < 3; ++a) {
            const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
            contact.force[a] += f[a];
            contact.torque[a] += arm[b] * f[c] - arm[c] * f[b];
        }
        contact.depth = std::max(contact.depth, depth);
    }
    /// Depth below the plane through the centre of the point's cell, at right angles to its normal: our own
    /// law, at `u` in the cell `cell` (same origin).
    void add_tangent_plane(std::uint32_t i, const std::array<float, 3> &u, const std::array<int, 3> &cell,
                           double voxel)
    {
        const Vec3 n = normal(i);
        double depth = 0;
        for (std::size_t a = 0; a < 3; ++a) depth += (cell[a] + 0.5 - static_cast<double>(u[a])) * n[a];
        add(i, n, depth * voxel);
    }

    Contact contact;

  private:
    Vec3 turned(float x, float y, float z) const
    {
        const auto &r = pose_.rotation;
        const double dx = static_cast<double>(x), dy = static_cast<double>(y), dz = static_cast<double>(z);
        return {r[0] * dx + r[1] * dy + r[2] * dz, r[3] * dx + r[4] * dy + r[5] * dz,
                r[6] * dx + r[7] * dy + r[8] * dz};
    }
    const Points &points_;
    const Pose &pose_;
};

/// Value and gradient (per cell) of the trilinear interpolation of the corners v[i][j][k] at the fraction t.
struct Trilinear {
    [[gnu::always_inline]] Trilinear(const float (&v)[2][2][2], const std::array<float, 3> &t)
    {
        float along_j[2][2], slope_k[2][2]; // interpolated along k: [i][j]
        for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j) {
                slope_k[i][j] = v[i][j][1] - v[i][j][0];
                along_j[i][j] = v[i][j][0] + t[2] * slope_k[i][j];
            }
        const float slope_j[2] = {along_j[0][1] - along_j[0][0], along_j[1][1] - along_j[1][0]};
        const float line[2] = {along_j[0][0] + t[1] * slope_j[0], along_j[1][0] + t[1] * slope_j[1]};
        const float k0 = slope_k[0][0] + t[1] * (slope_k[0][1] - slope_k[0][0]),
                    k1 = slope_k[1][0] + t[1] * (slope_k[1][1] - slope_k[1][0]);
        value = line[0] + t[0] * (line[1] - line[0]);
        gradient = {line[1] - line[0], slope_j[0] + t[0] * (slope_j[1] - slope_j[0]), k0 + t[0] * (k1 - k0)};
    }
    /// Unit length: the direction of the force.
    Vec3 direction() const
    {
        const double x = static_cast<double>(gradient[0]), y = static_cast<double>(gradient[1]),
                     z = static_cast<double>(gradient[2]), length = std::sqrt(x * x + y * y + z * z);
        return length > 0 ? Vec3{x / length, y / length, z / length} : Vec3{};
    }
    float value;
    std::array<float, 3> gradient;
};

} // namespace voxshell::bench
