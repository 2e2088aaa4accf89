// SPDX-License-Identifier: GPL-3.0-or-later
// Cells <-> OpenVDB. The only header through which the tools know that OpenVDB exists.
#pragma once

#include "container/container.hpp"
#include "voxmap/channels.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace voxshell {

/// A reproducible .vdb: Int32 grid `state` (1 surface, 2 interior, background 0), index (i,j,k) = cell,
/// transform with index (0,0,0) at world (h/2, h/2, h/2) in metres (a voxel below 20 micrometres: in the
/// `unit` that the metadata name), file metadata (`voxel` in metres, `unit`, `source_sha256`, `options`,
/// `closed`), the file's UUID derived from the content instead of OpenVDB's random one. Solid runs become
/// tiles, not voxels. Throws Failure(requirement) if a cell's index does not fit 32 bits. Channels become
/// grids `layer` (Int32) and `distance` (Float, in the transform's unit; a level set if it is signed): active
/// where they speak, else "beyond".
/// `progress`, if given, is asked whether to go on.
std::vector<std::uint8_t> vdb_bytes(const Cells &cells, const Sha256 &source_hash, const std::string &meta,
                                    const Channels &channels = {}, Progress *progress = nullptr);

/// Which grid of a .vdb of another program to take, and how. What is not said is found in the file, or
/// refused.
struct ForeignGrid {
    enum class As { solid, surface };
    std::optional<std::string> name; ///< default: the file's only grid
    std::optional<double> unit;      ///< [m] of the world's unit; default: the file metadata `unit`, or 1
    std::optional<As> as;            ///< what is on in a mask or bool grid; default solid
    bool snap = false; ///< move by up to half a cell so that samples are at the centres of cells
};

/// What became of a grid of another program.
struct ForeignTaken {
    std::string grid;               ///< printable
    std::string kind;               ///< "level set", "float grid", "mask", "bool grid"
    double unit = 1;                ///< [m]
    std::array<double, 3> origin{}; ///< of index (0, 0, 0) in the file [m]
    std::array<double, 3> moved{};  ///< by `snap` [m]
    bool distance_left_out =
        false; ///< a level set whose samples are not at the centres of cells, or whose tiles have distances
};

struct VdbFile {
    Cells cells;
    Channels channels;    ///< none by default
    Sha256 source_hash{}; ///< zero if the file names none; of the file itself, if it is another program's
    std::string meta;     ///< JSON; "{}" if the file has none
    std::optional<ForeignTaken> foreign;
};

/// Reads a `state` grid written by vdb_bytes(), or by another program that kept its meaning (any compression,
/// tiles or voxels). Throws Failure(invalid) for anything that is not one, Failure(system) if the file cannot
/// be read. OpenVDB's reader crashes on damaged files, so it runs in a child process with limited time and
/// memory.
///
/// With `foreign`, a grid of another program is taken where there is no `state`, or where it is named. A
/// value is a sample at its index; the transform must be a uniform scale and a translation, which is snapped
/// to h/65536 as the vertices of meshes are.
///  - A float grid (as it is or saved in half) that is a level set, or is named: the solid is where the
///  trilinear
///    interpolation of the samples is < 0, inactive ones and tiles included. A cell is surface if the
///    interpolation is < 0 at one point of the closed cell and >= 0 at another, interior if < 0 throughout,
///    else free: exact, wherever the samples lie on the lattice. If they are at the centres of cells (after
///    `snap`), a level set's values become the channel `distance`: band = background, step = band / 32767,
///    error half a step beyond the file's own.
///  - A mask or bool grid: index (i, j, k) is a cell, so that samples must be at the centres of cells (else
///  `snap`). As
///    solid, a cell that is on is interior if its 26 neighbours are on, else surface; as surface, it is
///    surface, and all others are free.
/// Free and interior cells so touch nowhere, not at a corner, and no fill leaks. Throws Failure: usage if
/// there are several grids and none is named, unsupported for other grids and transforms, requirement for a
/// voxel or a box beyond the format's limits, invalid where nothing is inside, or everything, or a value is
/// not finite.
/// `progress`, if given, is asked every 50 ms whether to go on.
VdbFile read_vdb(const std::filesystem::path &path, const ForeignGrid *foreign = nullptr,
                 Progress *progress = nullptr);

/// Whether the UUID at bytes 21..56 is the one that vdb_bytes() derives from the other bytes: false for a
/// file that is damaged or that another program saved.
bool vdb_uuid_matches(std::span<const std::uint8_t> bytes);

} // namespace voxshell
