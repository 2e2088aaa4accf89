// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/compare.hpp"

#include "cli/asset_kind.hpp"
#include "cli/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

namespace voxshell {
namespace {

constexpr std::int64_t farthest_search = 16;       // cells
constexpr std::uint64_t most_searches = 4'000'000; // cells

/// Bricks first..last of a column: one brick, or a solid run (brick == nullptr).
struct Segment {
    std::array<std::int64_t, 2> column;
    std::int64_t first, last;
    const Brick *brick;
};

std::vector<Segment> segments_of(const Cells &cells)
{
    std::vector<Segment> out;
    out.reserve(cells.bricks.size() + cells.solid.size());
    const std::int64_t i = cells.origin[0] >> 3, j = cells.origin[1] >> 3, k = cells.origin[2] >> 3;
    for (const Brick &brick : cells.bricks)
        out.push_back({{i + brick.at[0], j + brick.at[1]}, k + brick.at[2], k + brick.at[2], &brick});
    for (const SolidRun &run : cells.solid)
        out.push_back({{i + run.i, j + run.j}, k + run.first, k + run.last, nullptr});
    std::sort(out.begin(), out.end(), [](const Segment &a, const Segment &b) {
        return a.column != b.column ? a.column < b.column : a.first < b.first;
    });
    return out;
}

/// Calls piece(column, first, last, a, b) for each stretch where neither side changes its segment; nullptr:
/// free.
template<typename Piece>
void merge(const std::vector<Segment> &left, const std::vector<Segment> &right, Piece &&piece)
{
    std::size_t l = 0, r = 0;
    std::int64_t skip_left = 0, skip_right = 0; // bricks of the current segment that are done
    const auto advance = [](const std::vector<Segment> &list, std::size_t &at, std::int64_t &skip,
                            std::int64_t count) {
        skip += count;
        if (list[at].first + skip > list[at].last) {
            ++at;
            skip = 0;
        }
    };
    while (l < left.size() || r < right.size()) {
        const Segment *a = l < left.size() ? &left[l] : nullptr, *b = r < right.size() ? &right[r] : nullptr;
        if (a && b && a->column != b->column) (a->column < b->column ? b : a) = nullptr;
        std::int64_t from_a = a ? a->first + skip_left : 0, from_b = b ? b->first + skip_right : 0;
        std::int64_t last = a ? a->last : b->last;
        if (a && b) {
            last = std::min(a->last, b->last);
            if (from_a < from_b) {
                last = std::min(a->last, from_b - 1);
                b = nullptr;
            } else if (from_b < from_a) {
                last = std::min(b->last, from_a - 1);
                a = nullptr;
            }
        }
        const std::int64_t first = a ? from_a : from_b;
        piece(a ? a->column : b->column, first, last, a, b);
        if (a) advance(left, l, skip_left, last - first + 1);
        if (b) advance(right, r, skip_right, last - first + 1);
    }
}

std::uint64_t word(const Segment *segment, std::size_t w, int state)
{
    if (!segment) return 0;
    if (!segment->brick) return state == VXS_CELL_INTERIOR ? ~std::uint64_t{0} : 0;
    return state == VXS_CELL_INTERIOR ? segment->brick->interior[w] : segment->brick->surface[w];
}

/// Rings to the nearest cell of `state` around `at`; reach + 1 if there is none within reach.
std::int64_t rings_to(const Cells &cells, const Cell &at, int state, std::int64_t reach)
{
    for (std::int64_t ring = 0; ring <= reach; ++ring)
        for (std::int64_t i = -ring; i <= ring; ++i)
            for (std::int64_t j = -ring; j <= ring; ++j) {
                const bool face = std::abs(i) == ring || std::abs(j) == ring;
                for (std::int64_t k = -ring; k <= ring; k += face || ring == 0 ? 1 : 2 * ring)
                    if (cell_state(cells, {at[0] + i, at[1] + j, at[2] + k}) == state) return ring;
            }
    return reach + 1;
}

const char *state_name(int state)
{
    return state == VXS_CELL_SURFACE ? "surface" : state == VXS_CELL_INTERIOR ? "interior" : "free";
}

class CellComparison {
  public:
    CellComparison(const Cells &a, const Cells &b, double tolerance, Comparison &out)
        : a_(a), b_(b), allowed_(static_cast<std::int64_t>(tolerance / a.voxel * (1 + 1e-12))),
          reach_(std::max<std::int64_t>(2, allowed_)), out_(out)
    {
        if (tolerance / a.voxel > static_cast<double>(farthest_search) + 0.5)
            throw Failure(ExitCode::usage, "",
                          fmt::format("--tolerance: {} is more than {} voxels of {}",
                                      format_length(tolerance), farthest_search, format_length(a.voxel)));
    }

    void run()
    {
        merge(segments_of(a_), segments_of(b_),
              [this](const auto &column, auto first, auto last, auto *a, auto *b) {
                  piece(column, first, last, a, b);
              });
        out_.largest = static_cast<double>(std::min(largest_, reach_)) * a_.voxel;
        out_.largest_is_bound = largest_ > reach_;
        if (searches_ > most_searches)
            out_.notes.push_back(
                fmt::format("more than {} cells differ: only those were searched for how far they moved",
                            format_count(most_searches)));
    }

  private:
    void piece(const std::array<std::int64_t, 2> &column, std::int64_t first, std::int64_t last,
               const Segment *a, const Segment *b)
    {
        for (std::size_t w = 0; w < 8; ++w) {
            const std::uint64_t differ = (word(a, w, VXS_CELL_SURFACE) ^ word(b, w, VXS_CELL_SURFACE)) |
                                         (word(a, w, VXS_CELL_INTERIOR) ^ word(b, w, VXS_CELL_INTERIOR));
            if (!differ) continue;
            for (std::int64_t k = first; k <= last; ++k) {
                if (searches_ > most_searches) {
                    out_.changed += static_cast<std::uint64_t>(last - k + 1) *
                                    static_cast<std::uint64_t>(std::popcount(differ));
                    break;
                }
                for (std::uint64_t left = differ; left; left &= left - 1) {
                    const std::int64_t bit = std::countr_zero(left);
                    cell({column[0] * 8 + static_cast<std::int64_t>(w), column[1] * 8 + (bit >> 3),
                          k * 8 + (bit & 7)});
                }
            }
        }
    }

    void cell(const Cell &at)
    {
        ++searches_;
        const int before = cell_state(a_, at), after = cell_state(b_, at);
        const std::int64_t moved =
            std::max(rings_to(b_, at, before, reach_), rings_to(a_, at, after, reach_));
        if (moved <= allowed_) return;
        ++out_.changed;
        largest_ = std::max(largest_, moved);
        if (out_.first.size() >= 10) return;
        std::array<double, 3> centre{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            centre[axis] = (static_cast<double>(at[axis]) + 0.5) * a_.voxel;
        out_.first.push_back({centre, fmt::format("cell ({}, {}, {}): {} -> {}", at[0], at[1], at[2],
                                                  state_name(before), state_name(after))});
    }

    const Cells &a_, &b_;
    const std::int64_t allowed_, reach_; // cells
    Comparison &out_;
    std::int64_t largest_ = 0;
    std::uint64_t searches_ = 0;
};

} // namespace

Comparison compare(const VoxmapFile &a, const VoxmapFile &b, double tolerance)
{
    Comparison out;
    out.noun = "cells";
    if (a.cells.voxel != b.cells.voxel)
        out.structure.push_back(
            {"voxel", fmt::format("{} m", a.cells.voxel), fmt::format("{} m", b.cells.voxel)});
    if (a.cells.closed != b.cells.closed)
        out.structure.push_back(
            {"mesh", a.cells.closed ? "closed" : "open", b.cells.closed ? "closed" : "open"});
    const auto channels = [](const VoxmapFile &file) {
        const std::vector<std::string> names = channel_names(file.channels);
        return names.empty() ? std::string("none") : fmt::format("{}", fmt::join(names, ", "));
    };
    if (channels(a) != channels(b)) out.structure.push_back({"channels", channels(a), channels(b)});
    if (a.source_hash != b.source_hash) out.notes.push_back("made from different sources");
    if (a.meta != b.meta)
        out.notes.push_back("made with different options or version: " + a.meta + " / " + b.meta);
    out.compared = a.cells.voxel == b.cells.voxel;
    if (out.compared) CellComparison(a.cells, b.cells, tolerance, out).run();
    return out;
}

} // namespace voxshell
