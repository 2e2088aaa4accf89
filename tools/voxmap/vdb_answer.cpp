// SPDX-License-Identifier: GPL-3.0-or-later
// What the two processes of the .vdb reader say to each other: the child's answer, and what the parent believes of it.
#include "cli/failure.hpp"
#include "voxmap/vdb_parse.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fmt/core.h>
#include <new>

namespace voxshell {
namespace {

struct Answer {        ///< what the child says first
    std::int32_t code; ///< ExitCode; ok: all lists follow, else the error's text as meta
    std::uint32_t closed;
    double voxel;
    Cell origin;
    std::uint64_t bricks, runs, layers, distances, meta;
    Sha256 source_hash;
    std::int32_t layer_count;
    std::uint32_t unsigned_distance;
    double distance_band, distance_step, distance_error;
    std::uint64_t foreign, grid, kind; ///< whether it is another program's, and two texts
    double unit;
    std::array<double, 3> world_origin, moved;
    std::uint64_t distance_left_out;
};

/// OpenVDB quotes the file in its messages: no control character may reach a terminal.
std::string printable(std::string text, std::size_t most)
{
    if (text.size() > most) text = text.substr(0, most) + "...";
    for (char &c : text)
        if (c < ' ' || c > '~') c = '?';
    return text;
}

void require(bool holds, const char *what)
{
    if (!holds) throw Failure(ExitCode::invalid, "", what);
}

int state_of(const Brick &brick, std::size_t c)
{
    return brick.surface[c >> 6] >> (c & 63) & 1    ? VXS_CELL_SURFACE
           : brick.interior[c >> 6] >> (c & 63) & 1 ? VXS_CELL_INTERIOR
                                                    : VXS_CELL_FREE;
}

/// As the formats want them: each value fits its cell's state.
void check_channels(const VdbFile &file)
{
    const Channels &channels = file.channels;
    const bool has_layers = !channels.layer.empty(), has_distance = !channels.distance.empty();
    require(!has_layers || (channels.layer_count >= 1 && channels.layer_count <= VXS_VOXMAP_MAX_LAYERS),
            "grid `layer` has too many layers, or none");
    const double most = has_distance ? std::round(channels.distance_band / channels.distance_step) : 0;
    require(!has_distance || (channels.distance_step >= 1e-30 && most >= 1 && most <= 32767 &&
                              channels.distance_error >= 0 && channels.distance_error < 1e30),
            "grid `distance` has a step, a band or an error that makes no sense");
    for (std::size_t b = 0; b < file.cells.bricks.size() && (has_layers || has_distance); ++b)
        for (std::size_t c = 0; c < 512; ++c) {
            const int state = state_of(file.cells.bricks[b], c);
            const int sign = state == VXS_CELL_SURFACE ? 0 : state == VXS_CELL_FREE ? 1 : -1;
            const int ring = has_layers ? channels.layer[b][c] : 0;
            require(!has_layers ||
                        ((ring > 0) - (ring < 0) == sign && std::abs(ring) <= channels.layer_count + 1),
                    "grid `layer` does not fit the cells");
            const int steps = has_distance ? channels.distance[b][c] : 0;
            const bool is_side =
                channels.unsigned_distance || sign > 0 ? steps >= 0 : sign == 0 || steps <= 0;
            require(std::abs(steps) <= most && is_side, "grid `distance` does not fit the cells");
        }
}

} // namespace

bool answer_vdb(Fenced &parent, const std::filesystem::path &path, const ForeignGrid *foreign,
                std::uint64_t memory)
{
    Answer answer{};
    std::string error;
    try {
        const VdbFile file = parse_vdb(path, foreign);
        const Cells &cells = file.cells;
        answer.closed = cells.closed;
        answer.voxel = cells.voxel;
        answer.origin = cells.origin;
        answer.bricks = cells.bricks.size();
        answer.runs = cells.solid.size();
        answer.layers = file.channels.layer.size();
        answer.distances = file.channels.distance.size();
        answer.meta = file.meta.size();
        answer.source_hash = file.source_hash;
        answer.layer_count = file.channels.layer_count;
        answer.unsigned_distance = file.channels.unsigned_distance;
        answer.distance_band = file.channels.distance_band;
        answer.distance_step = file.channels.distance_step;
        answer.distance_error = file.channels.distance_error;
        const ForeignTaken taken = file.foreign.value_or(ForeignTaken{});
        answer.foreign = file.foreign.has_value();
        answer.grid = taken.grid.size();
        answer.kind = taken.kind.size();
        answer.unit = taken.unit;
        answer.world_origin = taken.origin;
        answer.moved = taken.moved;
        answer.distance_left_out = taken.distance_left_out;
        return parent.write(&answer, sizeof answer) && parent.write_list(cells.bricks) &&
               parent.write_list(cells.solid) && parent.write_list(file.channels.layer) &&
               parent.write_list(file.channels.distance) && parent.write_list(file.meta) &&
               parent.write_list(taken.grid) && parent.write_list(taken.kind);
    } catch (const Failure &failure) {
        answer.code = static_cast<std::int32_t>(failure.code);
        error = failure.what();
    } catch (const std::bad_alloc &) {
        answer.code = static_cast<std::int32_t>(ExitCode::invalid);
        error =
            fmt::format("needs more than {} MiB to read, too much for a file of its size: damaged or hostile",
                        memory >> 20);
    } catch (const std::exception &other) {
        answer.code = static_cast<std::int32_t>(ExitCode::invalid);
        error = fmt::format("OpenVDB cannot read this file ({})", printable(other.what(), 200));
    }
    answer.meta = error.size();
    return parent.write(&answer, sizeof answer) && parent.write_list(error);
}

VdbFile receive_vdb(Answers &reader, std::uint64_t memory)
{
    const auto give_up = [&] { throw Failure(ExitCode::invalid, "", reader.obituary()); };
    Answer answer;
    if (!reader.read(&answer, sizeof answer)) give_up();
    const std::uint64_t most = std::min<std::uint64_t>(vdb_max_meta, memory); // of a text
    const bool sane =
        answer.meta <= most && answer.grid <= most && answer.kind <= most &&
        answer.bricks <= memory / sizeof(Brick) && answer.runs <= memory / sizeof(SolidRun) &&
        (answer.layers == 0 || answer.layers == answer.bricks) &&
        (answer.distances == 0 || answer.distances == answer.bricks) &&
        answer.bricks * (sizeof(Brick) + (answer.layers ? 512 : 0) + (answer.distances ? 1024 : 0)) <= memory;
    if (!sane)
        throw Failure(ExitCode::invalid, "", "OpenVDB's reader sent nonsense: damaged or hostile file");
    VdbFile file;
    if (answer.code != 0) {
        if (!reader.read_text(file.meta, answer.meta)) give_up();
        require(!file.meta.empty(), "OpenVDB's reader gave up on this file without a word");
        const auto code = static_cast<ExitCode>(answer.code);
        const bool is_refusal = code >= ExitCode::usage && code <= ExitCode::unsupported;
        throw Failure(is_refusal ? code : ExitCode::invalid, "", printable(std::move(file.meta), 1000));
    }
    const auto receive_all = [&](auto &list, std::uint64_t count) {
        if (!reader.read_list(list, count)) give_up();
    };
    receive_all(file.cells.bricks, answer.bricks);
    receive_all(file.cells.solid, answer.runs);
    receive_all(file.channels.layer, answer.layers);
    receive_all(file.channels.distance, answer.distances);
    ForeignTaken taken;
    if (!reader.read_text(file.meta, answer.meta) || !reader.read_text(taken.grid, answer.grid) ||
        !reader.read_text(taken.kind, answer.kind))
        give_up();
    taken.unit = answer.unit;
    taken.origin = answer.world_origin;
    taken.moved = answer.moved;
    taken.distance_left_out = answer.distance_left_out != 0;
    if (answer.foreign) file.foreign = taken;
    file.channels.layer_count = answer.layer_count;
    file.channels.unsigned_distance = answer.unsigned_distance != 0;
    file.channels.distance_band = answer.distance_band;
    file.channels.distance_step = answer.distance_step;
    file.channels.distance_error = answer.distance_error;
    file.cells.voxel = answer.voxel;
    file.cells.origin = answer.origin;
    file.cells.closed = answer.closed != 0;
    file.source_hash = answer.source_hash;
    check_cells(file.cells);
    check_channels(file);
    recount(file.cells);
    return file;
}

void check_cells(const Cells &cells)
{
    require(cells.voxel >= 1e-12 && cells.voxel <= 1e3, "the voxel is not within 1e-12 m to 1e3 m");
    constexpr std::int32_t limit = VXS_VOXMAP_MAX_CELLS / VXS_VOXMAP_BRICK_CELLS;
    for (const std::int64_t o : cells.origin)
        require(o % VXS_VOXMAP_CHUNK_CELLS == 0 && std::abs(o) <= vdb_max_index + 1,
                "a cell is beyond the limits");
    std::uint64_t surface = 0;
    auto run = cells.solid.begin();
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        const Brick &brick = cells.bricks[b];
        require(b == 0 || cells.bricks[b - 1].at < brick.at, "grid `state` has two leaves in one place");
        std::uint64_t overlap = 0;
        for (int i = 0; i < 8; ++i) {
            require(brick.at[i % 3] >= 0 && brick.at[i % 3] < limit, "a cell is beyond the limits");
            surface |= brick.surface[i];
            overlap |= brick.surface[i] & brick.interior[i];
        }
        require(overlap == 0, "a cell has two states");
        while (run != cells.solid.end() && BrickAt{run->i, run->j, run->last} < brick.at) ++run;
        require(run == cells.solid.end() || brick.at < BrickAt{run->i, run->j, run->first},
                "grid `state` has a leaf and a tile in one place");
    }
    require(surface != 0, "grid `state` holds no surface cell");
    for (std::size_t r = 0; r < cells.solid.size(); ++r) {
        const SolidRun &s = cells.solid[r];
        require(s.i >= 0 && s.j >= 0 && s.first >= 0 && s.first <= s.last && s.i < limit && s.j < limit &&
                    s.last < limit,
                "a cell is beyond the limits");
        require(r == 0 || BrickAt{cells.solid[r - 1].i, cells.solid[r - 1].j, cells.solid[r - 1].last} <
                              BrickAt{s.i, s.j, s.first},
                "grid `state` has two tiles in one place");
    }
}

} // namespace voxshell
