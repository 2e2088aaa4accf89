// SPDX-License-Identifier: GPL-3.0-or-later
// Level sets, masks and bool grids of other programs as cells (the rules: voxmap/vdb.hpp).
#include "cli/failure.hpp"
#include "voxmap/vdb_cells.hpp"
#include "voxmap/vdb_child.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <optional>

namespace voxshell {
namespace {

using Grids = std::vector<std::pair<std::string, openvdb::GridBase::Ptr>>; ///< without their trees

std::string printable(std::string text)
{
    if (text.size() > 64) text = text.substr(0, 64) + "...";
    for (char &c : text)
        if (c < ' ' || c > '~' || c == '`') c = '?';
    return text;
}

std::string kind_of(const openvdb::GridBase &grid)
{
    if (grid.isType<openvdb::FloatGrid>())
        return grid.getGridClass() == openvdb::GRID_LEVEL_SET    ? "level set"
               : grid.getGridClass() == openvdb::GRID_FOG_VOLUME ? "fog volume"
                                                                 : "float grid";
    if (grid.isType<openvdb::MaskGrid>()) return "mask";
    if (grid.isType<openvdb::BoolGrid>()) return "bool grid";
    return fmt::format("grid of {}", printable(grid.valueType()));
}

Grids grids_of(openvdb::io::File &file)
{
    Grids grids;
    for (auto name = file.beginName(); name != file.endName(); ++name)
        grids.emplace_back(*name, file.readGridMetadata(*name));
    if (grids.empty()) refuse_vdb("holds no grid");
    return grids;
}

std::string list(const Grids &grids)
{
    std::string text;
    for (std::size_t g = 0; g < std::min<std::size_t>(grids.size(), 16); ++g)
        text +=
            fmt::format("{}`{}` ({})", g ? ", " : "", printable(grids[g].first), kind_of(*grids[g].second));
    return grids.size() > 16 ? text + ", ..." : text;
}

const Grids::value_type &choose(const Grids &grids, const ForeignGrid &wanted)
{
    const auto found = std::find_if(grids.begin(), grids.end(), [&](const auto &grid) {
        return wanted.name && grid.first == *wanted.name;
    });
    if (wanted.name && found == grids.end())
        throw Failure(
            ExitCode::usage, "",
            fmt::format("has no grid `{}`; --grid names one of {}", printable(*wanted.name), list(grids)));
    if (!wanted.name && grids.size() > 1)
        throw Failure(ExitCode::usage, "",
                      fmt::format("holds {} grids: --grid names one of {}", grids.size(), list(grids)));
    const auto &chosen = wanted.name ? *found : grids.front();
    const auto &name = chosen.first; // not a structured binding: clang 14 captures none
    const auto &grid = chosen.second;
    const std::string kind = kind_of(*grid);
    const auto refuse = [&](ExitCode code, const char *why) {
        throw Failure(code, "", fmt::format("grid `{}` is a {}: {}", printable(name), kind, why));
    };
    if (kind == "fog volume")
        refuse(ExitCode::unsupported, "densities say nothing of inside; make a level set of it first");
    if (kind == "float grid" && !wanted.name)
        refuse(ExitCode::usage, "if its values are signed distances, < 0 inside, name it with --grid");
    if (kind != "level set" && kind != "float grid" && kind != "mask" && kind != "bool grid")
        refuse(ExitCode::unsupported, "pack takes level sets in single precision, masks and bool grids");
    if (wanted.as && grid->isType<openvdb::FloatGrid>())
        refuse(ExitCode::usage, "its sign says what is inside; --as is for masks and bool grids");
    return wanted.name ? *found : grids.front();
}

/// Where samples lie on the lattice of cells: sample n of an axis is at cell coordinate n - first - fraction
/// / 65536, so that cell i reaches from there past sample i + first + 1 to sample i + first + 2 or nearer.
struct Placement {
    double voxel = 0; ///< [m]
    Cell first{};
    std::array<std::int64_t, 3> fraction{};
    std::array<double, 3>
        off{}; ///< [voxels] that the samples would have to move to be at the centres of cells
    bool centred() const
    {
        return fraction == std::array{lattice_per_cell / 2, lattice_per_cell / 2, lattice_per_cell / 2};
    }
};

Placement place(const openvdb::GridBase &grid, bool snap, ForeignTaken &taken)
{
    const auto unsupported = [&](const char *what) {
        throw Failure(
            ExitCode::unsupported, "",
            fmt::format(
                "the transform of grid `{}` {}: only a uniform scale with a translation has cubes for cells; "
                "resample the grid",
                taken.grid, what));
    };
    const openvdb::math::Transform &transform = grid.transform();
    if (!transform.isLinear()) unsupported("is a frustum");
    const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
    const double far = std::max({std::abs(origin[0]), std::abs(origin[1]), std::abs(origin[2])});
    double h = 0;
    for (int a = 0; a < 3; ++a) {
        openvdb::Vec3d step(0, 0, 0);
        step[a] = 1;
        step = transform.baseMap()->applyJacobian(step);
        if (a == 0) h = step[0];
        for (int b = 0; b < 3; ++b) {
            if (!std::isfinite(step[b]) || !std::isfinite(origin[b]))
                refuse_vdb(fmt::format("the transform of grid `{}` is not finite", taken.grid));
            // The last places of a float, which others save, and what OpenVDB's reader loses far from the
            // origin.
            const double tolerance = 2e-7 * std::abs(h) + 1e-15 * far;
            if (!(std::abs(step[b] - (a == b ? h : 0)) <= tolerance))
                unsupported("turns, shears or stretches");
        }
    }
    if (!(h > 0)) unsupported("mirrors");

    Placement out;
    out.voxel = h * taken.unit;
    if (!(out.voxel >= 1e-12 && out.voxel <= 1e3))
        throw Failure(
            ExitCode::requirement, "",
            fmt::format("grid `{}` has a voxel of {} m: a voxmap's is 1e-12 m to 1e3 m; is --unit right?",
                        taken.grid, out.voxel));
    for (std::size_t a = 0; a < 3; ++a) {
        const double cells = -origin[static_cast<int>(a)] / h;
        if (!(std::abs(cells) <= static_cast<double>(vdb_max_index)))
            throw Failure(ExitCode::requirement, "",
                          fmt::format("grid `{}` is {} cells away from the origin on axis {}: limit {}",
                                      taken.grid, cells, a, vdb_max_index));
        std::int64_t at = std::llround(cells * static_cast<double>(lattice_per_cell));
        // Half a cell either way is as near: then up, so that index (0,0,0) at the origin becomes cell
        // (0,0,0).
        const std::int64_t centre = (((at - 1) >> lattice_bits) << lattice_bits) + lattice_per_cell / 2;
        out.off[a] = static_cast<double>(at - centre) / static_cast<double>(lattice_per_cell);
        if (snap) {
            taken.moved[a] = out.off[a] * out.voxel;
            at = centre;
        }
        taken.origin[a] = origin[static_cast<int>(a)] * taken.unit;
        out.first[a] = at >> lattice_bits;
        out.fraction[a] = at & (lattice_per_cell - 1);
    }
    return out;
}

/// A brick of samples, or a box of bricks, inclusive.
struct Bricks {
    Cell low, high;
};

/// What a tree says of inside and outside, and the cells that follow.
template<typename Grid>
class Foreign {
  public:
    using Tree = typename Grid::TreeType;
    using Leaf = typename Tree::LeafNodeType;
    using Value = typename Tree::ValueType;
    static constexpr bool is_signed = std::is_same_v<Value, float>;

    Foreign(const Grid &grid, const Placement &placement, const ForeignTaken &taken)
        : grid_(grid), at_(placement), taken_(taken), accessor_(grid.getConstAccessor())
    {
        for (std::size_t a = 0; a < 3; ++a) {
            weight_[a] = static_cast<double>(at_.fraction[a]) / static_cast<double>(lattice_per_cell);
            least_[a] = at_.first[a] >> 3;
            most_[a] = (at_.first[a] + 9) >> 3;
        }
        if (inside(grid.background(), false))
            refuse_vdb(fmt::format("grid `{}` is inside everywhere beyond its nodes: turn it outside out",
                                   taken.grid));
    }

    /// `band` > 0: bricks with samples nearer than it to the surface are there even if all free or all
    /// interior.
    Cells cells(bool as_surface, float band)
    {
        survey(band);
        if (box_.empty())
            refuse_vdb(fmt::format("grid `{}` has nothing inside: no {}", taken_.grid, nothing()));
        check_box(box_, taken_.grid, ExitCode::requirement);
        Cells cells;
        cells.voxel = at_.voxel;
        cells.origin = box_.origin();
        cells.closed = !as_surface;
        std::vector<BrickAt> decide;
        for (const Cell &brick : mixed_) touched_by(brick, cells, decide);
        for (const Bricks &region : inside_) {
            if (as_surface)
                each(region.low, region.high, [&](const Cell &brick) { touched_by(brick, cells, decide); });
            else
                border(region, cells, decide);
        }
        make_unique(decide);
        if (!as_surface) add_solid(cells);
        take_out(cells.solid, decide);
        for (const BrickAt &at : decide) {
            Brick brick = decide_brick(cells, at, as_surface);
            if (brick.interior == all_cells)
                cells.solid.push_back({at[0], at[1], at[2], at[2]});
            else if (brick.surface != no_cells || brick.interior != no_cells)
                cells.bricks.push_back(brick);
        }
        join(cells.solid);
        std::vector<BrickAt> spoken;
        for (const Cell &leaf : spoken_) holding(leaf, cells, spoken);
        make_unique(spoken);
        add_spoken(spoken, cells);
        return cells;
    }

    /// Of the bricks' cells; samples are at their centres.
    void distances(const Cells &cells, double unit, Channels &channels)
    {
        const double band = double{grid_.background()} * unit;
        channels.distance_band = band;
        channels.distance_step = band / 32767;
        channels.distance_error = channels.distance_step / 2;
        channels.distance.resize(cells.bricks.size());
        for (std::size_t b = 0; b < cells.bricks.size(); ++b) {
            const openvdb::Coord first = sample(cells, cells.bricks[b].at, 1);
            for (int c = 0; c < 512; ++c) {
                const double value =
                    double{accessor_.getValue(first.offsetBy(c >> 6, c >> 3 & 7, c & 7))} * unit;
                channels.distance[b][static_cast<std::size_t>(c)] = static_cast<std::int16_t>(
                    std::round(std::clamp(value, -band, band) / channels.distance_step));
            }
        }
    }

    /// Whether all tiles are beyond the band, as those of a level set.
    bool tiles_are_beyond() const
    {
        if constexpr (is_signed)
            for (auto tile = tiles(); tile; ++tile)
                if (std::abs(tile.getValue()) < grid_.background()) return false;
        return true;
    }

  private:
    /// What decides a brick where no leaf has a say: the values of the 27 tiles, or parts of them, that its
    /// samples are in. All bricks lie alike in the leaves' grid.
    using Tiles = std::array<std::uint32_t, 27>;

    const Grid &grid_;
    const Placement &at_;
    const ForeignTaken &taken_;
    typename Grid::ConstAccessor accessor_;
    std::array<double, 3> weight_{};
    Cell least_{}, most_{};      ///< from a brick of cells to the bricks of samples that decide about it
    std::vector<Bricks> inside_; ///< of samples: inside throughout
    std::vector<Cell> mixed_, spoken_;
    BrickBox box_; ///< of cells
    std::size_t crowd_ = 1u << 20;
    std::map<Tiles, Brick> decided_;

    static bool inside(const Value &value, bool active)
    {
        if constexpr (is_signed)
            return value < 0;
        else if constexpr (std::is_same_v<Grid, openvdb::MaskGrid>)
            return active;
        else
            return value;
    }

    static const char *nothing()
    {
        return is_signed                                 ? "value is < 0"
               : std::is_same_v<Grid, openvdb::MaskGrid> ? "cell is active"
                                                         : "cell is true";
    }

    bool inside_at(const openvdb::Coord &at)
    {
        Value value;
        const bool active = accessor_.probeValue(at, value);
        return inside(value, active);
    }

    auto tiles() const
    {
        auto tile = grid_.tree().cbeginValueAll();
        tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
        return tile;
    }

    void check(const Value &value, const openvdb::Coord &at) const
    {
        if constexpr (is_signed)
            if (!std::isfinite(value))
                refuse_vdb(fmt::format("grid `{}` holds {} at {}", taken_.grid, value, text_of(at)));
    }

    Bricks bricks(const openvdb::Coord &low, const openvdb::Coord &high) const
    {
        Bricks out;
        for (int a = 0; a < 3; ++a) {
            if (low[a] < -vdb_max_index || high[a] > vdb_max_index || low[a] > high[a])
                refuse_vdb(fmt::format("grid `{}` reaches from {} to {}: limit {}", taken_.grid, text_of(low),
                                       text_of(high), vdb_max_index));
            out.low[static_cast<std::size_t>(a)] = low[a] >> 3;
            out.high[static_cast<std::size_t>(a)] = high[a] >> 3;
        }
        return out;
    }

    void grow(const Bricks &samples)
    {
        Cell low, high;
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] = samples.low[a] - most_[a];
            high[a] = samples.high[a] - least_[a];
        }
        box_.grow(low, high);
    }

    void survey(float band)
    {
        for (auto tile = tiles(); tile; ++tile) {
            const openvdb::CoordBBox span = tile.getBoundingBox();
            check(tile.getValue(), span.min());
            if (!inside(tile.getValue(), tile.isValueOn())) continue;
            inside_.push_back(bricks(span.min(), span.max()));
            grow(inside_.back());
        }
        for (auto leaf = grid_.tree().cbeginLeaf(); leaf; ++leaf) {
            const openvdb::Coord origin = leaf->origin();
            unsigned in = 0;
            bool near = false;
            for (openvdb::Index c = 0; c < Leaf::SIZE; ++c) {
                const Value value = leaf->getValue(c);
                check(value, leaf->offsetToGlobalCoord(c));
                in += inside(value, leaf->isValueOn(c));
                if constexpr (is_signed) near = near || std::abs(value) < band;
            }
            const Bricks brick = bricks(origin, origin.offsetBy(Leaf::DIM - 1));
            if (near) spoken_.push_back(brick.low);
            if (in == Leaf::SIZE)
                inside_.push_back(brick);
            else if (in)
                mixed_.push_back(brick.low);
            if (near || in) grow(brick);
        }
        if (inside_.empty() && mixed_.empty()) box_ = {};
    }

    template<typename Visit>
    static void each(const Cell &low, const Cell &high, Visit visit)
    {
        for (std::int64_t i = low[0]; i <= high[0]; ++i)
            for (std::int64_t j = low[1]; j <= high[1]; ++j)
                for (std::int64_t k = low[2]; k <= high[2]; ++k) visit(Cell{i, j, k});
    }

    static BrickAt relative(const Cell &brick, const Cells &cells)
    {
        BrickAt at;
        for (std::size_t a = 0; a < 3; ++a)
            at[a] = static_cast<std::int32_t>(brick[a] - (cells.origin[a] >> 3));
        return at;
    }

    /// The bricks of cells that a brick of samples has a say in.
    void touched_by(const Cell &samples, const Cells &cells, std::vector<BrickAt> &out) const
    {
        const Cell low{samples[0] - most_[0], samples[1] - most_[1], samples[2] - most_[2]};
        const Cell high{samples[0] - least_[0], samples[1] - least_[1], samples[2] - least_[2]};
        each(low, high, [&](const Cell &brick) { out.push_back(relative(brick, cells)); });
    }

    /// The bricks of cells whose centres are the samples of a brick.
    void holding(const Cell &samples, const Cells &cells, std::vector<BrickAt> &out) const
    {
        Cell low, high;
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] = (8 * samples[a] - at_.first[a] - 1) >> 3;
            high[a] = (8 * samples[a] + 7 - at_.first[a] - 1) >> 3;
        }
        each(low, high, [&](const Cell &brick) { out.push_back(relative(brick, cells)); });
    }

    /// Where a region that is inside ends, not at one of the mixed bricks but at one that is outside
    /// throughout.
    void border(const Bricks &region, const Cells &cells, std::vector<BrickAt> &out)
    {
        const auto look = [&](const Cell &brick) {
            for (int n = 0; n < 27; ++n) {
                const Cell next{brick[0] + n / 9 - 1, brick[1] + n / 3 % 3 - 1, brick[2] + n % 3 - 1};
                const openvdb::Coord at(static_cast<int>(8 * next[0]), static_cast<int>(8 * next[1]),
                                        static_cast<int>(8 * next[2]));
                if (!inside_at(at)) return touched_by(brick, cells, out);
            }
        };
        for (std::int64_t i = region.low[0]; i <= region.high[0]; ++i) {
            if (out.size() > crowd_) { // up to 27 for one: a tile has millions along its sides
                make_unique(out);
                crowd_ = 2 * out.size() + (1u << 20);
            }
            for (std::int64_t j = region.low[1]; j <= region.high[1]; ++j) {
                const bool side =
                    i == region.low[0] || i == region.high[0] || j == region.low[1] || j == region.high[1];
                const std::int64_t stride =
                    side ? 1 : std::max<std::int64_t>(1, region.high[2] - region.low[2]);
                for (std::int64_t k = region.low[2]; k <= region.high[2]; k += stride) look({i, j, k});
            }
        }
    }

    /// Each brick of cells begins in one brick of samples: if that is inside, it is solid, unless decided
    /// otherwise.
    void add_solid(Cells &cells) const
    {
        for (const Bricks &region : inside_) {
            Cell low, high;
            for (std::size_t a = 0; a < 3; ++a) {
                low[a] = region.low[a] - least_[a];
                high[a] = region.high[a] - least_[a];
            }
            const BrickAt from = relative(low, cells), to = relative(high, cells);
            for (std::int32_t i = from[0]; i <= to[0]; ++i)
                for (std::int32_t j = from[1]; j <= to[1]; ++j) cells.solid.push_back({i, j, from[2], to[2]});
        }
        join(cells.solid);
    }

    /// The first sample that a brick needs, moved by `more` along each axis.
    openvdb::Coord sample(const Cells &cells, const BrickAt &at, std::int64_t more) const
    {
        openvdb::Coord out;
        for (std::size_t a = 0; a < 3; ++a)
            out[static_cast<int>(a)] = static_cast<int>(cells.origin[a] + 8 * at[a] + at_.first[a] + more);
        return out;
    }

    /// The 10^3 samples that a brick needs, leaf by leaf: visit(i, j, k, value, active).
    template<typename Visit>
    void each_sample(const openvdb::Coord &first, Visit visit)
    {
        constexpr int dim = Leaf::DIM;
        const openvdb::Coord end = first.offsetBy(10),
                             from(first[0] & -dim, first[1] & -dim, first[2] & -dim);
        openvdb::Coord at;
        for (at[0] = from[0]; at[0] < end[0]; at[0] += dim)
            for (at[1] = from[1]; at[1] < end[1]; at[1] += dim)
                for (at[2] = from[2]; at[2] < end[2]; at[2] += dim) {
                    const Leaf *leaf = accessor_.probeConstLeaf(at);
                    Value tile{};
                    const bool active = !leaf && accessor_.probeValue(at, tile);
                    const auto low = openvdb::Coord::maxComponent(at, first);
                    const auto high = openvdb::Coord::minComponent(at.offsetBy(dim), end);
                    for (int i = low[0]; i < high[0]; ++i)
                        for (int j = low[1]; j < high[1]; ++j)
                            for (int k = low[2]; k < high[2]; ++k) {
                                const openvdb::Index c = Leaf::coordToOffset(openvdb::Coord(i, j, k));
                                visit(i - first[0], j - first[1], k - first[2],
                                      leaf ? leaf->getValue(c) : tile, leaf ? leaf->isValueOn(c) : active);
                            }
                }
    }

    std::optional<Tiles> tiles_from(const openvdb::Coord &first)
    {
        Tiles out{};
        openvdb::Index n = 0;
        for (int c = 0; c < 27; ++c) {
            const auto at = openvdb::Coord::minComponent(
                first.offsetBy(8 * (c / 9), 8 * (c / 3 % 3), 8 * (c % 3)), first.offsetBy(9));
            if (accessor_.probeConstLeaf(at)) return std::nullopt;
            Value tile{};
            const bool active = accessor_.probeValue(at, tile);
            if constexpr (is_signed)
                out[n++] = std::bit_cast<std::uint32_t>(tile);
            else
                out[n++] = inside(tile, active);
        }
        return out;
    }

    /// A tile of 4096^3 samples has a million and a half bricks along its sides, and 27 kinds of them.
    Brick decide_brick(const Cells &cells, const BrickAt &at, bool as_surface)
    {
        const openvdb::Coord first = sample(cells, at, 0);
        const std::optional<Tiles> tiles = tiles_from(first);
        if (!tiles) return decide_samples(first, at, as_surface);
        const auto known = decided_.find(*tiles);
        if (known != decided_.end()) return {at, known->second.surface, known->second.interior};
        const Brick brick = decide_samples(first, at, as_surface);
        if (decided_.size() < 4096) decided_.emplace(*tiles, brick);
        return brick;
    }

    Brick decide_samples(const openvdb::Coord &first, const BrickAt &at, bool as_surface)
    {
        Brick brick{at, {}, {}};
        // Rows of 17 points along k, of which 2 c to 2 c + 2 belong to cell c; a mask's point is a sample of
        // its own.
        static constexpr int rows = is_signed ? 17 : 10, per_cell = is_signed ? 2 : 1;
        std::array<std::array<std::uint32_t, rows>, rows> in{};
        if constexpr (is_signed) {
            if (!interpolate(first, in)) return brick;
        } else {
            each_sample(first, [&](int i, int j, int k, const Value &value, bool active) {
                in[i][j] |= std::uint32_t{inside(value, active)} << k;
            });
        }
        for (int i = 0; i < 8; ++i)
            for (int j = 0; j < 8; ++j) {
                std::uint32_t any = 0, all = ~0u;
                for (int r = 0; r < 9; ++r) {
                    any |= in[per_cell * i + r / 3][per_cell * j + r % 3];
                    all &= in[per_cell * i + r / 3][per_cell * j + r % 3];
                }
                for (int k = 0; k < 8; ++k) {
                    const std::uint64_t bit = std::uint64_t{1} << (8 * j + k);
                    const bool on = is_signed ? any >> 2 * k & 7 : in[i + 1][j + 1] >> (k + 1) & 1;
                    if (!on) continue;
                    const bool whole = !as_surface && (all >> per_cell * k & 7) == 7;
                    (whole ? brick.interior : brick.surface)[static_cast<std::size_t>(i)] |= bit;
                }
            }
        return brick;
    }

    /// Signs of the interpolation where its extremes over a cell can be: on the lattice's planes, and on
    /// those of the samples between them. A point that two cells share has one value. False: outside
    /// throughout.
    bool interpolate(const openvdb::Coord &first, std::array<std::array<std::uint32_t, 17>, 17> &in)
    {
        double value[10][10][10], along_i[17][10][10], along_j[17][10];
        unsigned count = 0;
        each_sample(first, [&](int i, int j, int k, const Value &sample, bool) {
            value[i][j][k] = static_cast<double>(sample);
            count += sample < 0;
        });
        if (count == 0 || count == 1000) {
            for (auto &row : in) row.fill(count ? 0x1ffff : 0);
            return count != 0;
        }
        const auto between = [](double weight, double a, double b) { return (1 - weight) * a + weight * b; };
        for (int i = 0; i < 17; ++i)
            for (int j = 0; j < 10; ++j)
                for (int k = 0; k < 10; ++k)
                    along_i[i][j][k] = i & 1
                                           ? value[(i + 1) / 2][j][k]
                                           : between(weight_[0], value[i / 2][j][k], value[i / 2 + 1][j][k]);
        for (int i = 0; i < 17; ++i) {
            for (int j = 0; j < 17; ++j)
                for (int k = 0; k < 10; ++k)
                    along_j[j][k] = j & 1
                                        ? along_i[i][(j + 1) / 2][k]
                                        : between(weight_[1], along_i[i][j / 2][k], along_i[i][j / 2 + 1][k]);
            for (int j = 0; j < 17; ++j)
                for (int k = 0; k < 17; ++k) {
                    const double at = k & 1 ? along_j[j][(k + 1) / 2]
                                            : between(weight_[2], along_j[j][k / 2], along_j[j][k / 2 + 1]);
                    in[i][j] |= std::uint32_t{at < 0} << k;
                }
        }
        return true;
    }
};

template<typename Grid>
void take(const openvdb::GridBase &base, const Placement &at, const ForeignGrid &wanted, VdbFile &file)
{
    const Grid &grid = static_cast<const Grid &>(base);
    ForeignTaken &taken = *file.foreign;
    const bool as_surface = wanted.as == ForeignGrid::As::surface;
    Foreign<Grid> foreign(grid, at, taken);
    if constexpr (Foreign<Grid>::is_signed) {
        const bool distance = at.centred() && foreign.tiles_are_beyond() && taken.kind == "level set" &&
                              double{grid.background()} * taken.unit >= 1e-25;
        file.cells = foreign.cells(false, distance ? grid.background() : 0);
        if (distance) foreign.distances(file.cells, taken.unit, file.channels);
        taken.distance_left_out = !distance && taken.kind == "level set";
    } else {
        if (!at.centred())
            throw Failure(ExitCode::unsupported, "",
                          fmt::format("the voxels of grid `{}` are no cells of a voxmap, whose corners are "
                                      "at multiples of {:.4g} m: "
                                      "--snap moves it by ({:.4g}, {:.4g}, {:.4g}) voxels and says so",
                                      taken.grid, at.voxel, at.off[0], at.off[1], at.off[2]));
        file.cells = foreign.cells(as_surface, 0);
    }
}

} // namespace

VdbFile parse_foreign(openvdb::io::File &file, const ForeignGrid &wanted)
{
    const Grids grids = grids_of(file);
    const auto &[name, metadata] = choose(grids, wanted);
    VdbFile result;
    result.foreign = ForeignTaken{};
    ForeignTaken &taken = *result.foreign;
    taken.grid = printable(name);
    taken.kind = kind_of(*metadata);
    taken.unit = wanted.unit ? *wanted.unit : unit_of(*file.getMetadata()).value_or(1);
    const Placement at = place(*metadata, wanted.snap, taken);
    const openvdb::GridBase::Ptr grid = file.readGrid(name);
    if (grid->isType<openvdb::FloatGrid>())
        take<openvdb::FloatGrid>(*grid, at, wanted, result);
    else if (grid->isType<openvdb::MaskGrid>())
        take<openvdb::MaskGrid>(*grid, at, wanted, result);
    else
        take<openvdb::BoolGrid>(*grid, at, wanted, result);
    return result;
}

} // namespace voxshell
