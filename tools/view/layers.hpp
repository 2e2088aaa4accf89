// SPDX-License-Identifier: GPL-3.0-or-later
// What a page draws, as its JSON and the arrays that belong to it. Lengths in metres; what is only looked at is
// rounded: a point to a 64th of its voxel, a vertex to 1/65535 of its mesh's box.
#pragma once

#include "import/scene.hpp"
#include "pointshell/pointshell_file.hpp"
#include "view/page_data.hpp"
#include "view/recorded.hpp"
#include "voxmap/voxmap_file.hpp"

namespace voxshell {

/// {voxel, origin, min, max, closed, bricks, at, surface, interior, solid[, layers, layer][, band, distance]}:
/// origin in cells; at: bricks' three coordinates each; surface, interior: 64 bytes a brick, as Brick has
/// them; solid: four numbers a run; layer, distance: 512 bytes a brick, each but the first of a row of eight
/// as its difference from the one before; distance in 127ths of the band.
nlohmann::ordered_json cells_layer(const VoxmapFile &file, PageData &data);

/// {voxel, step, base, at, normal, counts, spheres}: at in steps from base; normal: two bytes a point, on an
/// octahedron, as differences; counts: of each cluster's points, in order; spheres: centre and radius.
nlohmann::ordered_json points_layer(const PointshellFile &file, PageData &data);

/// {step, base, at, triangles}: equal vertices once, triangles that have become lines left out.
nlohmann::ordered_json mesh_layer(const Mesh &mesh, PageData &data);

/// {source, rows, of, forces, columns}: columns one after the other, as recorded.hpp names them.
nlohmann::ordered_json recorded_layer(const Recorded &recorded, PageData &data);

/// A body's way: position and orientation (x y z w), seven columns of the recorded rows.
nlohmann::ordered_json track_layer(std::span<const Pose> poses, PageData &data);

} // namespace voxshell
