// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/dilate.hpp"

#include <algorithm>
#include <bit>
#include <tbb/parallel_for.h>

namespace voxshell {
namespace {

/// Spreads a plane of 8 x 8 bits by one along each axis, inside the brick; the borders come from the
/// neighbours.
struct Neighbourhood {
    std::array<CellMask, 27> word{}; ///< brick (i, j, k) of -1..1 at 9 (i + 1) + 3 (j + 1) + k + 1

    /// Bits of plane `i` (-1..8), shifted so that the result's bit (j, k) is the source's (j + dj, k + dk).
    std::uint64_t plane(int i, int dj, int dk) const
    {
        const int bi = i < 0 ? 0 : i > 7 ? 2 : 1, local = i & 7;
        const auto part = [&](int bj, int bk) {
            return word[static_cast<std::size_t>(9 * bi + 3 * bj + bk)][static_cast<std::size_t>(local)];
        };
        const auto along_k = [&](int bj) { // shift by dk with the bytes of the k neighbour
            const std::uint64_t own = part(bj, 1);
            constexpr std::uint64_t top = 0x8080808080808080, bottom = 0x0101010101010101;
            if (dk > 0) return (own >> 1 & ~top) | (part(bj, 2) & bottom) << 7;
            if (dk < 0) return (own << 1 & ~bottom) | (part(bj, 0) & top) >> 7;
            return own;
        };
        if (dj > 0) return along_k(1) >> 8 | along_k(2) << 56;
        if (dj < 0) return along_k(1) << 8 | along_k(0) >> 56;
        return along_k(1);
    }
};

} // namespace

/// Adds every brick that has a cell within `reach` cells (Chebyshev) of a surface cell. Solid runs give way.
void widen(Cells &cells, int reach)
{
    std::vector<BrickAt> wanted;
    for (const Brick &b : cells.bricks) {
        std::uint64_t all = 0;
        int low[3] = {8, 0, 0}, high[3] = {-1, 0, 0};
        for (int i = 0; i < 8; ++i)
            if (b.surface[i]) all |= b.surface[i], low[0] = std::min(low[0], i), high[0] = i;
        if (!all) continue;
        std::uint64_t row = all | all >> 32;
        row |= row >> 16;
        row = (row | row >> 8) & 0xff;
        low[1] = std::countr_zero(all) / 8, high[1] = 7 - std::countl_zero(all) / 8;
        low[2] = std::countr_zero(row), high[2] = 63 - std::countl_zero(row);
        const auto reaches = [&](int axis, int step) {
            return step == 0 || (step < 0 ? low[axis] - reach < 0 : high[axis] + reach > 7);
        };
        for (int i = -1; i <= 1; ++i)
            for (int j = -1; j <= 1; ++j)
                for (int k = -1; k <= 1; ++k)
                    if ((i || j || k) && reaches(0, i) && reaches(1, j) && reaches(2, k))
                        wanted.push_back({b.at[0] + i, b.at[1] + j, b.at[2] + k});
    }
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());

    // The band may leave the box: move the origin down by whole chunks so that bricks stay >= 0.
    Cell shift{};
    for (const BrickAt &at : wanted)
        for (int a = 0; a < 3; ++a)
            if (at[a] < 0) shift[a] = VXS_VOXMAP_CHUNK_BRICKS;
    const auto moved = [&](const BrickAt &at) {
        return BrickAt{at[0] + static_cast<std::int32_t>(shift[0]),
                       at[1] + static_cast<std::int32_t>(shift[1]),
                       at[2] + static_cast<std::int32_t>(shift[2])};
    };
    for (Brick &b : cells.bricks) b.at = moved(b.at);
    for (SolidRun &r : cells.solid) {
        r.i += static_cast<std::int32_t>(shift[0]), r.j += static_cast<std::int32_t>(shift[1]);
        r.first += static_cast<std::int32_t>(shift[2]), r.last += static_cast<std::int32_t>(shift[2]);
    }
    for (int a = 0; a < 3; ++a) cells.origin[a] -= 8 * shift[a];

    std::vector<Brick> merged;
    std::vector<SolidRun> solid;
    merged.reserve(cells.bricks.size() + wanted.size());
    std::size_t b = 0, run = 0;
    SolidRun rest = cells.solid.empty() ? SolidRun{INT32_MAX, 0, 0, 0} : cells.solid[0];
    const auto next_run = [&] {
        rest = ++run < cells.solid.size() ? cells.solid[run] : SolidRun{INT32_MAX, 0, 0, 0};
    };
    for (const BrickAt &unmoved : wanted) {
        const BrickAt at = moved(unmoved);
        while (b < cells.bricks.size() && cells.bricks[b].at < at) merged.push_back(cells.bricks[b++]);
        if (b < cells.bricks.size() && cells.bricks[b].at == at) continue;
        while (BrickAt{rest.i, rest.j, rest.last} < at) solid.push_back(rest), next_run();
        Brick extra;
        extra.at = at;
        if (rest.i == at[0] && rest.j == at[1] && rest.first <= at[2]) {
            extra.interior.fill(~std::uint64_t{0});
            if (rest.first < at[2]) solid.push_back({rest.i, rest.j, rest.first, at[2] - 1});
            rest.first = at[2] + 1;
            if (rest.first > rest.last) next_run();
        }
        merged.push_back(extra);
    }
    merged.insert(merged.end(), cells.bricks.begin() + static_cast<std::ptrdiff_t>(b), cells.bricks.end());
    for (; run < cells.solid.size(); next_run()) solid.push_back(rest);
    cells.bricks = std::move(merged);
    cells.solid = std::move(solid);
}

BrickNeighbours::BrickNeighbours(const Cells &cells) : at(cells.bricks.size())
{
    tbb::parallel_for(std::size_t{0}, cells.bricks.size(), [&](std::size_t b) {
        const BrickAt &own = cells.bricks[b].at;
        for (int n = 0; n < 27; n += 3) { // three neighbours along k lie side by side
            const BrickAt first{own[0] + n / 9 - 1, own[1] + n / 3 % 3 - 1, own[2] - 1};
            auto found = std::lower_bound(cells.bricks.begin(), cells.bricks.end(), first,
                                          [](const Brick &x, const BrickAt &key) { return x.at < key; });
            for (int k = 0; k < 3; ++k) {
                const bool here =
                    found != cells.bricks.end() && found->at == BrickAt{first[0], first[1], first[2] + k};
                at[b][static_cast<std::size_t>(n + k)] =
                    here ? static_cast<std::uint32_t>(found++ - cells.bricks.begin()) : none;
            }
        }
    });
}

std::vector<CellMask> dilate(const std::vector<CellMask> &masks, const BrickNeighbours &neighbours)
{
    std::vector<CellMask> out(masks.size());
    tbb::parallel_for(std::size_t{0}, masks.size(), [&](std::size_t b) {
        Neighbourhood around;
        for (std::size_t n = 0; n < 27; ++n)
            if (neighbours.at[b][n] != BrickNeighbours::none) around.word[n] = masks[neighbours.at[b][n]];
        std::array<std::uint64_t, 10> grown{}; // planes -1..8, grown along j and k
        for (int i = -1; i <= 8; ++i)
            for (int dj = -1; dj <= 1; ++dj)
                for (int dk = -1; dk <= 1; ++dk)
                    grown[static_cast<std::size_t>(i + 1)] |= around.plane(i, dj, dk);
        for (std::size_t i = 0; i < 8; ++i) out[b][i] = grown[i] | grown[i + 1] | grown[i + 2];
    });
    return out;
}

std::vector<std::size_t> make_uniform(Cells &cells, const std::vector<std::uint8_t> &silent)
{
    std::vector<std::size_t> kept;
    std::vector<SolidRun> solid;
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        const BrickAt at = cells.bricks[b].at;
        if (!silent[b]) {
            cells.bricks[kept.size()] = cells.bricks[b];
            kept.push_back(b);
        } else if (cells.bricks[b].interior[0]) {
            solid.push_back({at[0], at[1], at[2], at[2]});
        }
    }
    cells.bricks.resize(kept.size());
    if (solid.empty()) return kept;
    solid.insert(solid.end(), cells.solid.begin(), cells.solid.end());
    std::sort(solid.begin(), solid.end(), [](const SolidRun &a, const SolidRun &b) {
        return BrickAt{a.i, a.j, a.first} < BrickAt{b.i, b.j, b.first};
    });
    cells.solid.clear();
    for (const SolidRun &r : solid) {
        if (!cells.solid.empty() && cells.solid.back().i == r.i && cells.solid.back().j == r.j &&
            cells.solid.back().last + 1 == r.first)
            cells.solid.back().last = r.last;
        else
            cells.solid.push_back(r);
    }
    return kept;
}

} // namespace voxshell
