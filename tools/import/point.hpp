// SPDX-License-Identifier: GPL-3.0-or-later
// A point or a direction, and what is computed with them: in doubles, each sum from left to right.
#pragma once

#include <array>
#include <cmath>

namespace voxshell {

using Point = std::array<double, 3>;

inline Point minus(const Point &a, const Point &b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double dot(const Point &a, const Point &b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline Point cross(const Point &a, const Point &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

inline double length(const Point &a)
{
    return std::sqrt(dot(a, a));
}

} // namespace voxshell
