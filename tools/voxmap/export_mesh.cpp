// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/failure.hpp"
#include "voxmap/export_cells.hpp"
#include "voxmap/export_glb.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fmt/core.h>
#include <tbb/parallel_sort.h>

namespace voxshell {
namespace {

using Words = std::array<std::uint64_t, 8>; ///< one bit a cell, Brick's bit order
constexpr Words none{}, all{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};

/// Cells that are not free.
Words filled(const Brick &brick)
{
    Words words;
    for (std::size_t i = 0; i < 8; ++i) words[i] = brick.surface[i] | brick.interior[i];
    return words;
}

/// The filled cells of the brick at `at`: none outside.
Words filled_at(const Cells &cells, const BrickAt &at)
{
    const auto brick = std::lower_bound(cells.bricks.begin(), cells.bricks.end(), at,
                                        [](const Brick &b, const BrickAt &key) { return b.at < key; });
    if (brick != cells.bricks.end() && brick->at == at) return filled(*brick);
    const Cell first{cells.origin[0] + 8 * std::int64_t{at[0]}, cells.origin[1] + 8 * std::int64_t{at[1]},
                     cells.origin[2] + 8 * std::int64_t{at[2]}};
    return cell_state(cells, first) == VXS_CELL_INTERIOR ? all : none;
}

/// For each cell, whether the cell one step along `axis` in direction `up` is filled.
Words filled_beside(const Words &here, const Words &next, int axis, bool up)
{
    Words beside;
    for (std::size_t i = 0; i < 8; ++i) {
        constexpr std::uint64_t low = 0x0101010101010101, high = 0x8080808080808080; // k = 0, k = 7
        if (axis == 0)
            beside[i] = up ? (i == 7 ? next[0] : here[i + 1]) : (i == 0 ? next[7] : here[i - 1]);
        else if (axis == 1)
            beside[i] = up ? here[i] >> 8 | next[i] << 56 : here[i] << 8 | next[i] >> 56;
        else
            beside[i] = up ? (here[i] >> 1 & ~high) | (next[i] << 7 & high)
                           : (here[i] << 1 & ~low) | (next[i] >> 7 & low);
    }
    return beside;
}

/// A corner as one number that sorts like (i, j, k), relative to Cells::origin: at most 2^20 + 1 per axis.
using Key = std::uint64_t;
constexpr int key_bits = 21;

Key key(const std::array<std::uint32_t, 3> &at)
{
    return (Key{at[0]} << key_bits | at[1]) << key_bits | at[2];
}

/// The four corners of a cell's side, counter-clockwise from outside.
std::array<Key, 4> side(const std::array<std::uint32_t, 3> &cell, int axis, bool up)
{
    const int b = (axis + 1) % 3, c = (axis + 2) % 3;
    static constexpr std::uint32_t turn[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    std::array<Key, 4> keys;
    for (std::size_t n = 0; n < 4; ++n) {
        auto corner = cell;
        const auto &step = turn[up ? n : 3 - n];
        corner[static_cast<std::size_t>(axis)] += up;
        corner[static_cast<std::size_t>(b)] += step[0];
        corner[static_cast<std::size_t>(c)] += step[1];
        keys[n] = key(corner);
    }
    return keys;
}

std::vector<std::array<Key, 4>> sides(const Cells &cells)
{
    std::vector<std::array<Key, 4>> quads;
    for (const Brick &brick : cells.bricks) {
        if (brick.surface == none) continue;
        const Words here = filled(brick);
        for (int axis = 0; axis < 3; ++axis)
            for (const bool up : {false, true}) {
                BrickAt neighbour = brick.at;
                neighbour[static_cast<std::size_t>(axis)] += up ? 1 : -1;
                const Words beside = filled_beside(here, filled_at(cells, neighbour), axis, up);
                for (std::uint32_t i = 0; i < 8; ++i)
                    for (std::uint64_t left = brick.surface[i] & ~beside[i]; left; left &= left - 1) {
                        const auto bit = static_cast<std::uint32_t>(std::countr_zero(left));
                        quads.push_back(side({8 * static_cast<std::uint32_t>(brick.at[0]) + i,
                                              8 * static_cast<std::uint32_t>(brick.at[1]) + (bit >> 3),
                                              8 * static_cast<std::uint32_t>(brick.at[2]) + (bit & 7)},
                                             axis, up));
                    }
            }
    }
    return quads;
}

template<typename T>
void append(std::string &bytes, T value)
{
    bytes.append(reinterpret_cast<const char *>(&value), sizeof value);
}

} // namespace

CellSkin skin(const Cells &cells)
{
    const std::vector<std::array<Key, 4>> quads = sides(cells);
    std::vector<Key> keys;
    keys.reserve(4 * quads.size());
    for (const auto &quad : quads) keys.insert(keys.end(), quad.begin(), quad.end());
    tbb::parallel_sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    if (keys.size() > INT32_MAX)
        throw Failure(
            ExitCode::requirement, "",
            fmt::format("the cells' skin has {} corners, the file holds 2^31: export as .csv", keys.size()));
    CellSkin out;
    constexpr Key mask = (Key{1} << key_bits) - 1;
    out.corners.reserve(keys.size());
    for (const Key k : keys)
        out.corners.push_back({cells.origin[0] + static_cast<std::int64_t>(k >> (2 * key_bits)),
                               cells.origin[1] + static_cast<std::int64_t>(k >> key_bits & mask),
                               cells.origin[2] + static_cast<std::int64_t>(k & mask)});
    out.quads.resize(quads.size());
    for (std::size_t q = 0; q < quads.size(); ++q)
        for (std::size_t n = 0; n < 4; ++n)
            out.quads[q][n] = static_cast<std::uint32_t>(
                std::lower_bound(keys.begin(), keys.end(), quads[q][n]) - keys.begin());
    return out;
}

void cells_ply(const Cells &cells, const TextSink &sink)
{
    const CellSkin mesh = skin(cells);
    sink(fmt::format(
        "ply\nformat binary_little_endian 1.0\ncomment skin of the surface cells, metres\nelement vertex {}\n"
        "property double x\nproperty double y\nproperty double z\nelement face {}\n"
        "property list uchar int vertex_indices\nend_header\n",
        mesh.corners.size(), mesh.quads.size()));
    std::string block;
    const auto flush = [&](std::size_t limit) {
        if (block.size() < limit) return;
        sink(block);
        block.clear();
    };
    for (const Cell &corner : mesh.corners) {
        for (const std::int64_t c : corner) append(block, cells.voxel * static_cast<double>(c));
        flush(1 << 20);
    }
    for (const auto &quad : mesh.quads) {
        append(block, std::uint8_t{4});
        for (const std::uint32_t index : quad) append(block, static_cast<std::int32_t>(index));
        flush(1 << 20);
    }
    flush(1);
}

std::vector<std::uint8_t> cells_glb(const Cells &cells)
{
    const CellSkin mesh = skin(cells);
    const std::size_t positions = 12 * mesh.corners.size(), indices = 24 * mesh.quads.size();
    check_glb_size(positions + indices);
    std::string binary;
    binary.reserve(positions + indices);
    std::array<float, 3> low{}, high{};
    for (std::size_t c = 0; c < mesh.corners.size(); ++c)
        for (std::size_t a = 0; a < 3; ++a) {
            const auto x =
                static_cast<float>(cells.voxel * static_cast<double>(mesh.corners[c][a] - cells.origin[a]));
            low[a] = c ? std::min(low[a], x) : x;
            high[a] = c ? std::max(high[a], x) : x;
            append(binary, x);
        }
    for (const auto &quad : mesh.quads)
        for (const std::size_t n : {0, 1, 2, 0, 2, 3}) append(binary, quad[n]);
    const auto at = [&](std::size_t a) { return cells.voxel * static_cast<double>(cells.origin[a]); };
    const std::string json = fmt::format(
        R"({{"asset":{{"version":"2.0","generator":"voxshell"}},"scene":0,"scenes":[{{"nodes":[0]}}],)"
        R"("nodes":[{{"name":"surface cells","mesh":0,"translation":[{},{},{}]}}],)"
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"mode":4}}]}}],)"
        R"("buffers":[{{"byteLength":{}}}],)"
        R"("bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{},"target":34962}},{{"buffer":0,"byteOffset":{},"byteLength":{},"target":34963}}],)"
        R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}},)"
        R"({{"bufferView":1,"componentType":5125,"count":{},"type":"SCALAR"}}]}})",
        at(0), at(1), at(2), positions + indices, positions, positions, indices, mesh.corners.size(), low[0],
        low[1], low[2], high[0], high[1], high[2], 6 * mesh.quads.size());
    return glb_bytes(json, {reinterpret_cast<const std::uint8_t *>(binary.data()), binary.size()});
}

} // namespace voxshell
