// SPDX-License-Identifier: GPL-3.0-or-later
// Inside the .vdb reader: what both of its processes agree on. Others include voxmap/vdb.hpp.
#pragma once

#include "fence/fence.hpp"
#include "voxmap/vdb.hpp"

#include <array>
#include <string_view>

namespace voxshell {

inline constexpr const char *vdb_grid_name = "state";
inline constexpr const char *vdb_meta_voxel = "voxel";          ///< double [m]
inline constexpr const char *vdb_meta_unit = "unit";            ///< of the transform: one of vdb_units
inline constexpr const char *vdb_meta_source = "source_sha256"; ///< 64 hexadecimal digits
inline constexpr const char *vdb_meta_options = "options";      ///< JSON
inline constexpr const char *vdb_meta_closed = "closed";        ///< bool
inline constexpr const char *vdb_layer_grid = "layer";
inline constexpr const char *vdb_distance_grid = "distance";
inline constexpr const char *vdb_meta_layers = "layer_count";         ///< int
inline constexpr const char *vdb_meta_step = "distance_step";         ///< double [m]
inline constexpr const char *vdb_meta_band = "distance_band";         ///< double [m]
inline constexpr const char *vdb_meta_error = "distance_error";       ///< double [m]
inline constexpr const char *vdb_meta_unsigned = "distance_unsigned"; ///< bool
inline constexpr std::int64_t vdb_max_index =
    (std::int64_t{1} << 31) - (1 << 13);                           ///< a 4096^3 node still fits
inline constexpr std::size_t vdb_max_meta = std::size_t{16} << 20; ///< bytes

/// OpenVDB calls a transform with a scale below 1.4e-5 singular and refuses it: a finer voxel takes a finer
/// unit.
struct VdbUnit {
    std::string_view name;
    double metres;
};
inline constexpr std::array<VdbUnit, 4> vdb_units{{{"m", 1}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}}};
inline constexpr double vdb_min_scale = 2e-5;

/// Reads the file with OpenVDB's own reader, in the calling process: a damaged file can crash it, hang it or
/// make it take all memory. Throws Failure or std::exception.
VdbFile parse_vdb(const std::filesystem::path &path, const ForeignGrid *foreign);

/// In the child: parses, and sends what came of it; false for a parent that is gone.
bool answer_vdb(Fenced &parent, const std::filesystem::path &path, const ForeignGrid *foreign,
                std::uint64_t memory);

/// What the child answers, or Failure: nothing of it is believed. No list takes more than `memory` bytes.
VdbFile receive_vdb(Answers &answers, std::uint64_t memory);

/// Throws Failure(invalid) unless the invariants of Cells hold and the box is within the format's limits.
void check_cells(const Cells &cells);

} // namespace voxshell
