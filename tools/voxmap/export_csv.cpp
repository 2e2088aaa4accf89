// SPDX-License-Identifier: GPL-3.0-or-later
#include "voxmap/export_cells.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <string>

namespace voxshell {
namespace {

/// Lines are put together in a block, and blocks go to the sink: ten million rows in a second or two.
class Table {
  public:
    explicit Table(const TextSink &sink) : sink_(sink) { block_.reserve(limit + 256); }
    ~Table() = default;
    template<typename Number>
    void number(Number value)
    {
        char text[32];
        block_.append(text, std::to_chars(text, text + sizeof text, value).ptr);
    }
    void text(std::string_view text) { block_ += text; }
    void end_line()
    {
        block_ += '\n';
        if (block_.size() >= limit) flush();
    }
    void flush()
    {
        sink_(block_);
        block_.clear();
    }

  private:
    static constexpr std::size_t limit = 1 << 20;
    const TextSink &sink_;
    std::string block_;
};

/// The bricks and solid runs of one column (i, j), along k.
struct Column {
    std::int32_t j;
    std::size_t brick, brick_end; ///< of Cells::bricks
    std::size_t run, run_end;     ///< of Cells::solid
};

class CellTable {
  public:
    CellTable(const VoxmapFile &file, const TextSink &sink)
        : cells_(file.cells), channels_(file.channels), table_(sink)
    {
    }

    void write()
    {
        table_.text("i,j,k,state");
        if (!channels_.layer.empty()) table_.text(",layer");
        if (!channels_.distance.empty()) table_.text(",distance_m");
        table_.end_line();
        std::size_t brick = 0, run = 0;
        while (brick < cells_.bricks.size() || run < cells_.solid.size()) {
            const std::int32_t i =
                std::min(brick < cells_.bricks.size() ? cells_.bricks[brick].at[0] : INT32_MAX,
                         run < cells_.solid.size() ? cells_.solid[run].i : INT32_MAX);
            const std::vector<Column> columns = columns_of(i, brick, run);
            for (std::int64_t slice = 0; slice < 8; ++slice)
                for (const Column &column : columns)
                    for (std::int64_t row = 0; row < 8; ++row)
                        write_row(8 * std::int64_t{i} + slice, row, column);
        }
        table_.flush();
    }

  private:
    std::vector<Column> columns_of(std::int32_t i, std::size_t &brick, std::size_t &run) const
    {
        std::vector<Column> columns;
        const auto brick_j = [&] {
            return brick < cells_.bricks.size() && cells_.bricks[brick].at[0] == i
                       ? cells_.bricks[brick].at[1]
                       : INT32_MAX;
        };
        const auto run_j = [&] {
            return run < cells_.solid.size() && cells_.solid[run].i == i ? cells_.solid[run].j : INT32_MAX;
        };
        for (std::int32_t j; (j = std::min(brick_j(), run_j())) != INT32_MAX;) {
            Column column{j, brick, brick, run, run};
            while (brick_j() == j) column.brick_end = ++brick;
            while (run_j() == j) column.run_end = ++run;
            columns.push_back(column);
        }
        return columns;
    }

    /// Cells of one i and one j, by k: bricks and runs merged.
    void write_row(std::int64_t i, std::int64_t row, const Column &column)
    {
        prefix_.clear();
        append(prefix_, cells_.origin[0] + i);
        append(prefix_, cells_.origin[1] + 8 * std::int64_t{column.j} + row);
        const auto slice = static_cast<std::size_t>(i & 7);
        std::size_t run = column.run;
        for (std::size_t brick = column.brick; brick <= column.brick_end; ++brick) {
            const std::int32_t next = brick < column.brick_end ? cells_.bricks[brick].at[2] : INT32_MAX;
            for (; run < column.run_end && cells_.solid[run].first < next; ++run) {
                const SolidRun &solid = cells_.solid[run];
                for (std::int64_t k = 8 * std::int64_t{solid.first}; k < 8 * (std::int64_t{solid.last} + 1);
                     ++k)
                    write_cell(k, VXS_CELL_INTERIOR, no_brick, 0);
            }
            if (brick == column.brick_end) break;
            const std::uint64_t surface = cells_.bricks[brick].surface[slice] >> (8 * row) & 0xff;
            const std::uint64_t filled = surface | (cells_.bricks[brick].interior[slice] >> (8 * row) & 0xff);
            for (std::uint64_t left = filled; left; left &= left - 1) {
                const int bit = std::countr_zero(left);
                write_cell(8 * std::int64_t{next} + bit,
                           surface >> bit & 1 ? VXS_CELL_SURFACE : VXS_CELL_INTERIOR, brick,
                           slice << 6 | static_cast<std::size_t>(row) << 3 | static_cast<std::size_t>(bit));
            }
        }
    }

    void write_cell(std::int64_t k, int state, std::size_t brick, std::size_t cell)
    {
        table_.text(prefix_);
        table_.number(cells_.origin[2] + k);
        table_.text(state == VXS_CELL_SURFACE ? ",1" : ",2");
        if (!channels_.layer.empty()) {
            table_.text(",");
            table_.number(brick == no_brick ? -(channels_.layer_count + 1)
                                            : int{channels_.layer[brick][cell]});
        }
        if (!channels_.distance.empty()) {
            table_.text(",");
            table_.number(brick == no_brick ? (channels_.unsigned_distance ? 1 : -1) * channels_.distance_band
                                            : channels_.distance[brick][cell] * channels_.distance_step);
        }
        table_.end_line();
    }

    static void append(std::string &text, std::int64_t value)
    {
        char digits[24];
        text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
        text += ',';
    }

    static constexpr std::size_t no_brick = SIZE_MAX;
    const Cells &cells_;
    const Channels &channels_;
    Table table_;
    std::string prefix_; ///< "i,j,"
};

} // namespace

void cells_csv(const VoxmapFile &file, const TextSink &sink)
{
    CellTable(file, sink).write();
}

} // namespace voxshell
