// SPDX-License-Identifier: GPL-3.0-or-later
// Order and bounding spheres of the points (formats/pointshell.md S401 to S405).
#pragma once

#include "pointshell/shell.hpp"

namespace voxshell {

/// Bits of three coordinates interleaved, i highest: neighbours in space are neighbours in order. Below 2^21
/// each.
std::uint64_t morton(std::uint32_t i, std::uint32_t j, std::uint32_t k);

/// Fills clusters, center and radius of a shell whose points stand in their final order. Radii are rounded
/// up, so that every stored point is inside under S404's and S405's own arithmetic.
void cluster(Shell &shell);

} // namespace voxshell
