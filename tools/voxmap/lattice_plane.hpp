// SPDX-License-Identifier: GPL-3.0-or-later
// 8 x 8 cells of a coordinate plane on one side of a line: what voxeliser and crossings ask of a triangle's
// edges.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

namespace voxshell {

__extension__ typedef __int128 Wide;

/// Cells (x, y) of 0..7, bit 8 x + y, with na x + nb y >= least. Int: 64 or 128 bits; 15 times the largest of
/// the three must fit.
template<class Int>
std::uint64_t half_plane(Int na, Int nb, Int least)
{
    // Edges of up to 256 cells: four rows x at once, in 32 bits.
    constexpr Int small = Int{1} << 24;
    if (-small <= na && na <= small && -small <= nb && nb <= small) {
        typedef std::int32_t Rows __attribute__((vector_size(16)));
        typedef std::uint8_t Bytes __attribute__((vector_size(4)));
        const auto a = static_cast<std::int32_t>(na), b = static_cast<std::int32_t>(nb),
                   c = static_cast<std::int32_t>(std::clamp<Int>(least, -32 * small, 32 * small));
        Rows low = Rows{0, a, 2 * a, 3 * a} - c, high = low + 4 * a, in_low{}, in_high{};
        for (int y = 0; y < 8; ++y, low += b, high += b) {
            in_low |= (low >= 0) & (1 << y);
            in_high |= (high >= 0) & (1 << y);
        }
        return std::bit_cast<std::uint32_t>(__builtin_convertvector(in_low, Bytes)) |
               std::uint64_t{std::bit_cast<std::uint32_t>(__builtin_convertvector(in_high, Bytes))} << 32;
    }
    std::uint64_t in = 0;
    for (int x = 0; x < 8; ++x)
        for (int y = 0; y < 8; ++y) in |= static_cast<std::uint64_t>(na * x + nb * y >= least) << (8 * x + y);
    return in;
}

} // namespace voxshell
