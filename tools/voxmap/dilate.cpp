// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/dilate.hpp"

#include <algorithm>
#include <bit>
#include <iterator>
#include <numeric>
#include <span>
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

/// Bit 9 (i + 1) + 3 (j + 1) + k + 1: the neighbour (i, j, k) has a cell within `reach` of a surface cell of
/// the brick.
std::uint32_t reached(const Brick &b, int reach)
{
    std::uint64_t all = 0;
    int low[3] = {8, 0, 0}, high[3] = {-1, 0, 0};
    for (int i = 0; i < 8; ++i)
        if (b.surface[i]) all |= b.surface[i], low[0] = std::min(low[0], i), high[0] = i;
    if (!all) return 0;
    std::uint64_t row = all | all >> 32;
    row |= row >> 16;
    row = (row | row >> 8) & 0xff;
    low[1] = std::countr_zero(all) / 8, high[1] = 7 - std::countl_zero(all) / 8;
    low[2] = std::countr_zero(row), high[2] = 63 - std::countl_zero(row);
    const auto reaches = [&](int axis, int step) {
        return step == 0 || (step < 0 ? low[axis] - reach < 0 : high[axis] + reach > 7);
    };
    std::uint32_t out = 0;
    for (int n = 0; n < 27; ++n)
        if (reaches(0, n / 9 - 1) && reaches(1, n / 3 % 3 - 1) && reaches(2, n % 3 - 1)) out |= 1u << n;
    return out;
}

/// Cells move to an origin that lies `shift` bricks lower.
void lower_origin(Cells &cells, const BrickAt &shift)
{
    if (shift == BrickAt{}) return;
    for (Brick &b : cells.bricks)
        for (std::size_t a = 0; a < 3; ++a) b.at[a] += shift[a];
    for (SolidRun &r : cells.solid) r.i += shift[0], r.j += shift[1], r.first += shift[2], r.last += shift[2];
    for (std::size_t a = 0; a < 3; ++a) cells.origin[a] -= 8 * std::int64_t{shift[a]};
}

using Column = std::pair<std::int32_t, std::int32_t>; ///< (i, j) of bricks

/// What of a list sorted by columns lies in one of them.
template<class List, class ColumnOf>
auto in_column(List &list, const Column &column, const ColumnOf &column_of)
{
    const auto first =
        std::partition_point(list.begin(), list.end(), [&](const auto &x) { return column_of(x) < column; });
    return std::span(first,
                     std::find_if(first, list.end(), [&](const auto &x) { return column_of(x) != column; }));
}

/// Adds to `cells` the neighbours that `reaches` names for each brick (bits as those of reached()). Column by
/// column: the bricks that a column of bricks gets come from its own and the eight columns around it.
void grow(Cells &cells, const std::vector<std::uint32_t> &reaches, Progress &progress)
{
    // The band may leave the box: the origin moves down by whole chunks so that bricks stay >= 0.
    constexpr std::uint32_t downwards[3] = {0x1ff, 0x1c0e07, 0x1249249}; // reached bits of step -1 per axis
    BrickAt shift{};
    for (std::size_t b = 0; b < reaches.size(); ++b)
        for (std::size_t a = 0; a < 3; ++a)
            if (cells.bricks[b].at[a] == 0 && reaches[b] & downwards[a]) shift[a] = VXS_VOXMAP_CHUNK_BRICKS;
    lower_origin(cells, shift);

    const auto brick_column = [](const Brick &b) { return Column{b.at[0], b.at[1]}; };
    const auto run_column = [](const SolidRun &r) { return Column{r.i, r.j}; };
    std::vector<Column> columns;
    for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
        const auto [i, j] = brick_column(cells.bricks[b]);
        if (b != 0 && brick_column(cells.bricks[b - 1]) == Column{i, j}) continue;
        for (int n = 0; n < 9; ++n) columns.emplace_back(i + n / 3 - 1, j + n % 3 - 1);
    }
    for (const SolidRun &r : cells.solid) columns.push_back(run_column(r));
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());

    struct Part {
        std::vector<std::int32_t> fresh; ///< k of bricks to add
        std::vector<SolidRun> solid;     ///< what they leave of the solid runs
    };
    std::vector<Part> parts(columns.size());
    std::vector<std::size_t> start(columns.size() + 1, 0);
    tbb::parallel_for(std::size_t{0}, columns.size(), [&](std::size_t c) {
        if ((c & 255) == 0) progress.check();
        const auto [i, j] = columns[c];
        std::vector<std::int32_t> wanted;
        for (int n = 0; n < 27; n += 3)
            for (const Brick &b : in_column(cells.bricks, {i - n / 9 + 1, j - n / 3 % 3 + 1}, brick_column))
                for (int k = 0; k < 3; ++k)
                    if (reaches[static_cast<std::size_t>(&b - cells.bricks.data())] >> (n + k) & 1)
                        wanted.push_back(b.at[2] + k - 1);
        std::sort(wanted.begin(), wanted.end());
        wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
        std::vector<std::int32_t> own;
        for (const Brick &b : in_column(cells.bricks, columns[c], brick_column)) own.push_back(b.at[2]);
        std::set_difference(wanted.begin(), wanted.end(), own.begin(), own.end(),
                            std::back_inserter(parts[c].fresh));
        for (const SolidRun &r : in_column(cells.solid, columns[c], run_column)) {
            std::int32_t first = r.first;
            for (auto k = std::lower_bound(parts[c].fresh.begin(), parts[c].fresh.end(), r.first);
                 k != parts[c].fresh.end() && *k <= r.last; ++k) {
                if (first < *k) parts[c].solid.push_back({i, j, first, *k - 1});
                first = *k + 1;
            }
            if (first <= r.last) parts[c].solid.push_back({i, j, first, r.last});
        }
        start[c + 1] = own.size() + parts[c].fresh.size();
    });
    std::partial_sum(start.begin(), start.end(), start.begin());

    std::vector<Brick> merged(start.back());
    tbb::parallel_for(std::size_t{0}, columns.size(), [&](std::size_t c) {
        const auto own = in_column(cells.bricks, columns[c], brick_column);
        const auto runs = in_column(cells.solid, columns[c], run_column);
        auto brick = own.begin();
        auto run = runs.begin();
        Brick *out = merged.data() + start[c];
        for (const std::int32_t k : parts[c].fresh) {
            while (brick != own.end() && brick->at[2] < k) *out++ = *brick++;
            while (run != runs.end() && run->last < k) ++run;
            out->at = {columns[c].first, columns[c].second, k};
            if (run != runs.end() && run->first <= k) out->interior.fill(~std::uint64_t{0});
            ++out;
        }
        std::copy(brick, own.end(), out);
    });
    cells.bricks = std::move(merged);
    cells.solid.clear();
    for (const Part &part : parts)
        cells.solid.insert(cells.solid.end(), part.solid.begin(), part.solid.end());
}

} // namespace

void widen(Cells &cells, int reach, Progress &progress)
{
    // Whole bricks last: they need no look at the cells.
    const int whole = std::max(0, reach - 1) / 8;
    std::vector<std::uint32_t> reaches(cells.bricks.size());
    tbb::parallel_for(std::size_t{0}, reaches.size(),
                      [&](std::size_t b) { reaches[b] = reached(cells.bricks[b], reach - 8 * whole); });
    progress.check();
    grow(cells, reaches, progress);
    for (int n = 0; n < whole; ++n) {
        reaches.assign(cells.bricks.size(), (1u << 27) - 1);
        grow(cells, reaches, progress);
    }
}

BrickNeighbours::BrickNeighbours(const Cells &cells, Progress &progress) : at(cells.bricks.size())
{
    tbb::parallel_for(std::size_t{0}, cells.bricks.size(), [&](std::size_t b) {
        if ((b & 1023) == 0) progress.check();
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

std::vector<CellMask> dilate(const std::vector<CellMask> &masks, const BrickNeighbours &neighbours,
                             Progress &progress)
{
    std::vector<CellMask> out(masks.size());
    tbb::parallel_for(std::size_t{0}, masks.size(), [&](std::size_t b) {
        if ((b & 1023) == 0) progress.check();
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
