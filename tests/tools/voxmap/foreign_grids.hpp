// SPDX-License-Identifier: GPL-3.0-or-later
// .vdb files as other programs write them, made with OpenVDB alone, and what OpenVDB sees in ours. Everything
// heavy is in foreign_grids.cpp, so that tests include this and not OpenVDB.
#pragma once

#include "import/scene.hpp"
#include "voxmap/lattice.hpp"

#include <array>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace foreign {

using voxshell::Cell;
using Vector = std::array<double, 3>;

/// Where index (0, 0, 0) is and how far apart samples are, in the file's world unit.
struct Frame {
    double voxel;
    Vector origin{0, 0, 0};
};

/// OpenVDB's meshToVolume with a band of three voxels, class level set.
void save_mesh(const std::filesystem::path &file, const voxshell::Mesh &mesh, const Frame &frame,
               bool half = false);

/// A float grid with a value per index of the box; 1 elsewhere.
using Sample = std::function<float(const Cell &)>;
void save_floats(const std::filesystem::path &file, const Cell &low, const Cell &high, const Sample &value,
                 const Frame &frame, bool level_set);

/// A mask (active) or bool grid (true) with what is on in the box; nothing elsewhere.
using On = std::function<bool(const Cell &)>;
void save_mask(const std::filesystem::path &file, const Cell &low, const Cell &high, const On &on,
               const Frame &frame);
void save_bools(const std::filesystem::path &file, const Cell &low, const Cell &high, const On &on,
                const Frame &frame);

/// A file for each of kinds(): "two", "fog", "vector", "nan" ... and tiles.
void save_kind(const std::string &kind, const std::filesystem::path &file);
std::vector<std::string> kinds();

/// A value of a grid as OpenVDB reads it from a file: 0 state, 1 layer, float or mask as they are.
class Reading {
  public:
    Reading(const std::filesystem::path &file, const std::string &grid);
    ~Reading();
    Reading(const Reading &) = delete;
    Reading &operator=(const Reading &) = delete;
    double operator()(const Cell &at) const;
    std::uint64_t active() const;
    Vector world(const Cell &at) const; ///< of an index

  private:
    struct Grid;
    Grid *grid_;
};

} // namespace foreign
