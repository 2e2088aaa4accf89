// SPDX-License-Identifier: GPL-3.0-or-later
// Grids of other programs as cells: the documented rule against its own definition and against the analytic
// solid.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "cli/failure.hpp"
#include "voxmap/vdb.hpp"
#include "voxmap/voxmap_file.hpp"

#include "foreign_grids.hpp"
#include "solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <doctest/doctest.h>
#include <fstream>
#include <map>
#include <random>
#include <unistd.h>

using namespace voxshell;

namespace {

struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("voxshell_test_foreign." + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
    std::filesystem::path operator/(const char *name) const { return path / name; }
    std::filesystem::path write(const char *name, const std::vector<std::uint8_t> &bytes) const
    {
        std::ofstream(path / name, std::ios::binary)
            .write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        return path / name;
    }
};

const Folder folder;

ForeignGrid named(const char *name, bool snap = false, std::optional<ForeignGrid::As> as = {})
{
    ForeignGrid wanted;
    wanted.name = name;
    wanted.snap = snap;
    wanted.as = as;
    return wanted;
}

VdbFile take(const std::filesystem::path &path, const ForeignGrid &wanted = {})
{
    return read_vdb(path, &wanted);
}

template<typename Visit>
void each(const Cell &low, const Cell &high, Visit visit)
{
    for (std::int64_t i = low[0]; i <= high[0]; ++i)
        for (std::int64_t j = low[1]; j <= high[1]; ++j)
            for (std::int64_t k = low[2]; k <= high[2]; ++k) visit(Cell{i, j, k});
}

/// No free cell touches an interior one, not even at a corner: nothing can leak.
void check_separate(const Cells &cells)
{
    std::uint64_t touching = 0;
    const Cell low{cells.min[0] - 1, cells.min[1] - 1, cells.min[2] - 1};
    each(low, cells.max, [&](const Cell &at) {
        bool free = false, interior = false;
        each({0, 0, 0}, {1, 1, 1}, [&](const Cell &d) {
            const int state = cell_state(cells, {at[0] + d[0], at[1] + d[1], at[2] + d[2]});
            free = free || state == VXS_CELL_FREE;
            interior = interior || state == VXS_CELL_INTERIOR;
        });
        touching += free && interior;
    });
    CHECK(touching == 0);
}

/// The same cells as OpenVDB reads them from our own .vdb, and the same bytes when that is packed again.
void check_round_trip(const VdbFile &taken)
{
    VoxmapFile map{taken.cells, taken.channels, taken.source_hash, "{}"};
    const auto packed = voxmap_bytes(map);
    const VoxmapFile back = read_voxmap(folder.write("round.voxmap", packed));
    const auto file =
        folder.write("round.vdb", vdb_bytes(back.cells, back.source_hash, back.meta, back.channels));
    const foreign::Reading state(file, "state");
    CHECK(state.active() == taken.cells.surface_cells + taken.cells.interior_cells);
    std::uint64_t differing = 0;
    each({taken.cells.min[0] - 2, taken.cells.min[1] - 2, taken.cells.min[2] - 2},
         {taken.cells.max[0] + 2, taken.cells.max[1] + 2, taken.cells.max[2] + 2},
         [&](const Cell &at) { differing += static_cast<int>(state(at)) != cell_state(taken.cells, at); });
    CHECK(differing == 0);
    const VdbFile again = read_vdb(file);
    CHECK_FALSE(again.foreign);
    CHECK(voxmap_bytes({again.cells, again.channels, again.source_hash, again.meta}) == packed);
}

/// Least and greatest distance of a closed cell from a point.
std::pair<double, double> reach(const Cell &at, double h, const Point &center)
{
    double least = 0, most = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        const double low = h * static_cast<double>(at[a]) - center[a], high = low + h;
        const double near = low > 0    ? low
                            : high < 0 ? -high
                                       : 0,
                     far = std::max(std::abs(low), std::abs(high));
        least += near * near;
        most += far * far;
    }
    return {std::sqrt(least), std::sqrt(most)};
}

/// Cells against a ball, whose surface the level set knows to within `error`.
void check_ball(const Cells &cells, const Point &center, double radius, double error)
{
    const double h = cells.voxel;
    std::uint64_t wrong = 0, decided = 0, all = 0;
    Cell low, high;
    for (std::size_t a = 0; a < 3; ++a) {
        low[a] = static_cast<std::int64_t>(std::floor((center[a] - radius) / h)) - 3;
        high[a] = static_cast<std::int64_t>(std::floor((center[a] + radius) / h)) + 3;
    }
    each(low, high, [&](const Cell &at) {
        const auto [least, most] = reach(at, h, center);
        const int state = cell_state(cells, at);
        const bool out = least > radius + error, in = most < radius - error,
                   crossed = least < radius - error && most > radius + error;
        ++all;
        decided += out || in || crossed;
        wrong += (out && state != VXS_CELL_FREE) || (in && state != VXS_CELL_INTERIOR) ||
                 (crossed && state != VXS_CELL_SURFACE);
    });
    CHECK(wrong == 0);
    CHECK(static_cast<double>(decided) > 0.98 * static_cast<double>(all));
    for (std::size_t a = 0; a < 3; ++a) {
        CHECK(cells.min[a] > low[a]);
        CHECK(cells.max[a] < high[a]);
    }
}

using Samples = std::map<Cell, float>;

/// The rule by its definition: the trilinear interpolation at every point of a cell where it can be extreme.
int state_by_definition(const Samples &samples, const Cell &cell, const foreign::Frame &frame)
{
    const auto sample = [&](const Cell &at) {
        const auto found = samples.find(at);
        return found == samples.end() ? 1.0 : static_cast<double>(found->second);
    };
    std::array<std::vector<double>, 3> planes; // in indices
    for (std::size_t a = 0; a < 3; ++a) {
        const double low =
            static_cast<double>(cell[a]) - std::round(frame.origin[a] / frame.voxel * 65536) / 65536;
        planes[a] = {low, low + 1};
        for (double n = std::ceil(low); n < low + 1; ++n) planes[a].push_back(n);
    }
    bool any = false, all = true;
    for (const double x : planes[0])
        for (const double y : planes[1])
            for (const double z : planes[2]) {
                const Cell base{static_cast<std::int64_t>(std::floor(x)),
                                static_cast<std::int64_t>(std::floor(y)),
                                static_cast<std::int64_t>(std::floor(z))};
                const double f[3] = {x - static_cast<double>(base[0]), y - static_cast<double>(base[1]),
                                     z - static_cast<double>(base[2])};
                double value = 0;
                for (int c = 0; c < 8; ++c) {
                    const double weight =
                        (c & 4 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 1 ? f[2] : 1 - f[2]);
                    if (weight > 0)
                        value +=
                            weight * sample({base[0] + (c >> 2), base[1] + (c >> 1 & 1), base[2] + (c & 1)});
                }
                any = any || value < 0;
                all = all && value < 0;
            }
    return all ? VXS_CELL_INTERIOR : any ? VXS_CELL_SURFACE : VXS_CELL_FREE;
}

std::string refusal(const std::string &kind, ExitCode expected, const ForeignGrid &wanted = {})
{
    const auto path = folder / "refused.vdb";
    foreign::save_kind(kind, path);
    CAPTURE(kind);
    try {
        take(path, wanted);
    } catch (const Failure &failure) {
        CHECK(failure.code == expected);
        CHECK(failure.file == path.string());
        CHECK(std::string(failure.what()).find('\n') == std::string::npos);
        return failure.what();
    }
    FAIL_CHECK("was taken");
    return {};
}

bool says(const std::string &text, const char *part)
{
    if (text.find(part) == std::string::npos) MESSAGE("'", text, "' does not say '", part, "'");
    return text.find(part) != std::string::npos;
}

} // namespace

TEST_CASE("a level set that OpenVDB makes of a mesh is the solid it was made of")
{
    const double h = 0.001, radius = 0.0203;
    const Point center{0.0031, -0.0047, 0.0102};
    const foreign::Frame frames[] = {
        {h},                                      // OpenVDB's and Houdini's own: samples at corners of cells
        {h, {h / 2, h / 2, h / 2}},               // ours: at centres
        {h, {0.3 * h, -0.75 * h, 0.11 * h}},      // anywhere
        {h, {-1000.5 * h, 77 * h, 12345.25 * h}}, // far away, and on a lattice of bricks of its own
    };
    for (const foreign::Frame &frame : frames)
        for (const bool half : {false, true}) {
            CAPTURE(frame.origin[0]);
            CAPTURE(half);
            foreign::save_mesh(folder / "ball.vdb", solids::sphere(center, radius, 96), frame, half);
            const VdbFile taken = take(folder / "ball.vdb");
            REQUIRE(taken.foreign);
            CHECK(taken.foreign->grid == "surface");
            CHECK(taken.foreign->kind == "level set");
            CHECK(taken.foreign->moved == std::array<double, 3>{});
            CHECK(taken.cells.closed);
            // The faces lie inside the ball by 0.012 h; the interpolation is off by h^2 / (4 R), a half float
            // by h / 700.
            check_ball(taken.cells, center, radius, 0.03 * h);
            check_separate(taken.cells);
            check_round_trip(taken);
        }
}

TEST_CASE("a box, its faces anywhere")
{
    const double h = 0.002;
    const Point low{-0.0113, 0.0042, -0.0307}, high{0.0284, 0.0351, 0.0109};
    foreign::save_mesh(folder / "box.vdb", solids::box(low, high), {h});
    const VdbFile taken = take(folder / "box.vdb");
    std::uint64_t wrong = 0;
    each({-20, -10, -30}, {30, 30, 20}, [&](const Cell &at) {
        bool out = false, in = true, clear = true;
        for (std::size_t a = 0; a < 3; ++a) {
            const double from = h * static_cast<double>(at[a]), to = from + h;
            out = out || to < low[a] - 0.01 * h || from > high[a] + 0.01 * h;
            in = in && from > low[a] + 0.01 * h && to < high[a] - 0.01 * h;
            // Along edges the interpolation of the distance is round: those cells may be either.
            clear =
                clear && std::abs(from + h / 2 - low[a]) > 2 * h && std::abs(from + h / 2 - high[a]) > 2 * h;
        }
        const int state = cell_state(taken.cells, at);
        int near_faces = 0;
        for (std::size_t a = 0; a < 3; ++a) {
            const double middle = h * (static_cast<double>(at[a]) + 0.5);
            near_faces += std::abs(middle - low[a]) < 2 * h || std::abs(middle - high[a]) < 2 * h;
        }
        if (near_faces > 1) return;
        wrong += out ? state != VXS_CELL_FREE : in ? state != VXS_CELL_INTERIOR : state != VXS_CELL_SURFACE;
    });
    CHECK(wrong == 0);
    check_separate(taken.cells);
    check_round_trip(taken);
}

TEST_CASE("the rule is what it says, on noise")
{
    std::mt19937 random(5);
    std::uniform_real_distribution<float> value(-1, 1);
    std::uniform_real_distribution<double> offset(-30, 30);
    for (int trial = 0; trial < 12; ++trial) {
        CAPTURE(trial);
        foreign::Frame frame{0.25};
        for (double &o : frame.origin)
            o = trial == 0   ? 0
                : trial == 1 ? 0.125
                : trial == 2 ? -7 * 0.25
                : trial == 3 ? 9.5 * 0.25
                             : offset(random);
        Samples samples;
        const Cell low{-9, -3, 5}, high{6, 12, 22};
        const bool smooth = trial % 2; // larger regions of one sign
        each(low, high, [&](const Cell &at) {
            samples[at] =
                smooth ? value(random) +
                             static_cast<float>(std::sin(static_cast<double>(at[0] + 2 * at[1]) / 3)) * 1.5f
                       : value(random);
        });
        foreign::save_floats(
            folder / "noise.vdb", low, high, [&](const Cell &at) { return samples.at(at); }, frame, false);
        const VdbFile taken = take(folder / "noise.vdb", named("values"));
        CHECK(taken.channels.distance.empty());
        std::uint64_t wrong = 0, seen[3] = {};
        Cell from = low, to = high;
        for (std::size_t a = 0; a < 3; ++a) {
            from[a] += static_cast<std::int64_t>(std::floor(frame.origin[a] / frame.voxel)) - 3;
            to[a] += static_cast<std::int64_t>(std::floor(frame.origin[a] / frame.voxel)) + 3;
        }
        each(from, to, [&](const Cell &at) {
            const int state = state_by_definition(samples, at, frame);
            wrong += state != cell_state(taken.cells, at);
            ++seen[state];
        });
        CHECK(wrong == 0);
        CHECK(taken.cells.surface_cells == seen[VXS_CELL_SURFACE]);
        CHECK(taken.cells.interior_cells == seen[VXS_CELL_INTERIOR]);
        check_separate(taken.cells);
    }
}

TEST_CASE("tiles without a leaf beside them have a surface too")
{
    // A tile of samples low .. high < 0 among 1: inside up to half way to the samples beside it.
    const struct {
        const char *kind;
        Cell low;
        std::int64_t size;
    } parts[] = {{"tile-8", {-8, 0, 16}, 8}, {"tile-128", {-128, 0, 128}, 128}};
    for (const auto &part : parts)
        for (const bool snap : {false, true}) {
            CAPTURE(part.kind);
            CAPTURE(snap);
            foreign::save_kind(part.kind, folder / "tile.vdb");
            const VdbFile taken = take(folder / "tile.vdb", named("tile", snap));
            std::uint64_t wrong = 0;
            const Cell last{part.low[0] + part.size - 1, part.low[1] + part.size - 1,
                            part.low[2] + part.size - 1};
            each({part.low[0] - 2, part.low[1] - 2, part.low[2] - 2}, {last[0] + 2, last[1] + 2, last[2] + 2},
                 [&](const Cell &at) {
                     // Corners are samples; snapped, centres are. Then a value at a face, half way between -1
                     // and 1, is not < 0.
                     int depth = 2;
                     for (std::size_t a = 0; a < 3; ++a) {
                         const std::int64_t from = at[a] - part.low[a], to = last[a] - at[a];
                         depth = std::min(depth, snap ? (from < 0 || to < 0     ? 0
                                                         : from == 0 || to == 0 ? 1
                                                                                : 2)
                                                      : (from < -1 || to < 0     ? 0
                                                         : from == -1 || to == 0 ? 1
                                                                                 : 2));
                     }
                     wrong += cell_state(taken.cells, at) != (depth == 0   ? VXS_CELL_FREE
                                                              : depth == 1 ? VXS_CELL_SURFACE
                                                                           : VXS_CELL_INTERIOR);
                 });
            CHECK(wrong == 0);
            check_round_trip(taken);
        }
}

TEST_CASE("a tile of 4096^3 samples costs its sides")
{
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) &&                                       \
    !defined(VXS_COUNTING) // they multiply the reader's processor time
    foreign::save_kind("tile-4096", folder / "tile.vdb");
    const VdbFile taken = take(folder / "tile.vdb", named("tile", false));
    constexpr std::uint64_t side =
        4096; // corners are samples: as of tile-8 and tile-128, n + 1 cells of n samples
    CHECK(taken.cells.interior_cells == (side - 1) * (side - 1) * (side - 1));
    CHECK(taken.cells.surface_cells == 6 * side * side + 2);
#endif
}

TEST_CASE("a level set's values become the channel distance where they are at the centres of cells")
{
    const double h = 0.0005;
    const foreign::Frame frames[] = {{h, {h / 2, h / 2, h / 2}}, {h, {-20.5 * h, 13.5 * h, 0.5 * h}}, {h}};
    for (const foreign::Frame &frame : frames) {
        CAPTURE(frame.origin[0]);
        const bool snap = frame.origin[0] == 0;
        const auto path = folder / "distance.vdb";
        foreign::save_mesh(path, solids::sphere({0, 0, 0}, 0.0102, 64), frame);
        if (snap) {
            const VdbFile as_it_is = take(path);
            CHECK(as_it_is.foreign->distance_left_out);
            CHECK(as_it_is.channels.distance.empty());
        }
        const VdbFile taken = take(path, named("surface", snap));
        CHECK_FALSE(taken.foreign->distance_left_out);
        for (const double moved : taken.foreign->moved) CHECK(moved == doctest::Approx(snap ? h / 2 : 0));
        const Channels &channels = taken.channels;
        REQUIRE(channels.distance.size() == taken.cells.bricks.size());
        CHECK(channels.distance_band == doctest::Approx(3 * h));
        CHECK(channels.distance_error == doctest::Approx(1.5 * h / 32767));
        const foreign::Reading values(path, "surface");
        double worst = 0;
        std::uint64_t in_band = 0, told = 0;
        for (std::size_t b = 0; b < taken.cells.bricks.size(); ++b)
            for (int c = 0; c < 512; ++c) {
                const BrickAt &at = taken.cells.bricks[b].at;
                Cell cell{taken.cells.origin[0] + 8 * at[0] + (c >> 6),
                          taken.cells.origin[1] + 8 * at[1] + (c >> 3 & 7),
                          taken.cells.origin[2] + 8 * at[2] + (c & 7)};
                for (std::size_t a = 0; a < 3; ++a)
                    cell[a] -= static_cast<std::int64_t>(std::floor(frame.origin[a] / h));
                const double steps = channels.distance[b][static_cast<std::size_t>(c)],
                             expected = values(cell);
                told += std::abs(expected) < 3 * h * 0.999999;
                worst = std::max(worst, std::abs(steps * channels.distance_step - expected));
            }
        each({-60, -60, -60}, {60, 60, 60}, [&](Cell at) {
            for (std::size_t a = 0; a < 3; ++a)
                at[a] -= static_cast<std::int64_t>(std::floor(frame.origin[a] / h));
            in_band += std::abs(values(at)) < 3 * h * 0.999999;
        });
        CHECK(told == in_band); // none is lost between the bricks
        CHECK(worst <= channels.distance_error * (1 + 1e-9));
        CHECK(worst > channels.distance_error / 2);
        check_round_trip(taken);
    }
}

TEST_CASE("masks and bool grids: what is on is a solid, or a surface")
{
    std::mt19937 random(11);
    const double h = 0.01;
    for (int trial = 0; trial < 6; ++trial) {
        CAPTURE(trial);
        const Cell shift{trial * 3 - 7, 0, trial == 4 ? -100 : 8};
        const foreign::Frame frame{h,
                                   {h * (static_cast<double>(shift[0]) + 0.5),
                                    h * (static_cast<double>(shift[1]) + 0.5),
                                    h * (static_cast<double>(shift[2]) + 0.5)}};
        std::map<Cell, bool> on;
        const Cell low{-5, -20, 3}, high{21, 9, 30};
        each(low, high, [&](const Cell &at) {
            on[at] = random() % 40 != 0;
        }); // full of holes, one brick and more between them
        const auto is_on = [&](const Cell &at) {
            const auto found = on.find(at);
            return found != on.end() && found->second;
        };
        if (trial % 2)
            foreign::save_mask(folder / "on.vdb", low, high, is_on, frame);
        else
            foreign::save_bools(folder / "on.vdb", low, high, is_on, frame);
        const VdbFile solid = take(folder / "on.vdb");
        const VdbFile surface =
            take(folder / "on.vdb", named(trial % 2 ? "mask" : "bools", false, ForeignGrid::As::surface));
        CHECK(solid.cells.closed);
        CHECK_FALSE(surface.cells.closed);
        CHECK(surface.cells.interior_cells == 0);
        std::uint64_t wrong = 0, count = 0;
        each({low[0] - 2, low[1] - 2, low[2] - 2}, {high[0] + 2, high[1] + 2, high[2] + 2},
             [&](const Cell &at) {
                 bool all = true;
                 each({at[0] - 1, at[1] - 1, at[2] - 1}, {at[0] + 1, at[1] + 1, at[2] + 1},
                      [&](const Cell &n) { all = all && is_on(n); });
                 const Cell cell{at[0] + shift[0], at[1] + shift[1], at[2] + shift[2]};
                 wrong += cell_state(solid.cells, cell) != (!is_on(at) ? VXS_CELL_FREE
                                                            : all      ? VXS_CELL_INTERIOR
                                                                       : VXS_CELL_SURFACE);
                 wrong += cell_state(surface.cells, cell) != (is_on(at) ? VXS_CELL_SURFACE : VXS_CELL_FREE);
                 count += is_on(at);
             });
        CHECK(wrong == 0);
        CHECK(surface.cells.surface_cells == count);
        CHECK(solid.cells.surface_cells + solid.cells.interior_cells == count);
        check_separate(solid.cells);
        check_round_trip(solid);
        check_round_trip(surface);
    }
}

TEST_CASE("a mask that is not on the lattice is moved only when told to, and it says so")
{
    CHECK(says(refusal("mask", ExitCode::unsupported), "--snap moves it by (0.5, 0.5, 0.5) voxels"));
    foreign::save_kind("mask", folder / "mask.vdb");
    const VdbFile moved = take(folder / "mask.vdb", named("mask", true));
    CHECK(moved.foreign->moved == std::array<double, 3>{0.5, 0.5, 0.5});
    CHECK(moved.cells.min == Cell{0, 0, 0}); // indices stay
    CHECK(moved.cells.max == Cell{20, 10, 3});
    CHECK(moved.cells.interior_cells == 19 * 9 * 2);
    foreign::save_mask(folder / "mask.vdb", {0, 0, 0}, {9, 9, 9}, [](const Cell &) { return true; },
                       {2, {1.5, 0.5, -1.4}});
    const VdbFile nearest = take(folder / "mask.vdb", named("mask", true));
    CHECK(nearest.foreign->moved[0] == doctest::Approx(-0.5)); // to 1, a centre
    CHECK(nearest.foreign->moved[1] == doctest::Approx(0.5));
    CHECK(nearest.foreign->moved[2] == doctest::Approx(0.4).epsilon(1e-4)); // to -1, to within h / 65536
    CHECK(nearest.cells.min == Cell{0, 0, -1});
}

TEST_CASE("units")
{
    foreign::save_mesh(folder / "mm.vdb", solids::sphere({0, 0, 0}, 10, 48), {0.5});
    ForeignGrid wanted;
    wanted.unit = 1e-3;
    const VdbFile taken = take(folder / "mm.vdb", wanted);
    CHECK(taken.cells.voxel == doctest::Approx(0.0005));
    check_ball(taken.cells, {0, 0, 0}, 0.01, 0.05 * 0.0005);
    CHECK(take(folder / "mm.vdb").cells.voxel == 0.5);
    // A voxel of 1 um: OpenVDB cannot hold it in metres, and ours say the unit of such files.
    const VdbFile small{taken.cells, {}, {}, "{}", {}};
    Cells fine = small.cells;
    fine.voxel = 1e-6;
    const auto path = folder.write("fine.vdb", vdb_bytes(fine, {}, "{}"));
    CHECK(read_vdb(path).cells.voxel == 1e-6);
}

TEST_CASE("what cannot be taken is refused in one line that says why")
{
    const auto usage = ExitCode::usage, unsupported = ExitCode::unsupported, invalid = ExitCode::invalid,
               requirement = ExitCode::requirement;
    CHECK(
        says(refusal("two", usage), "holds 2 grids: --grid names one of `ball` (level set), `mask` (mask)"));
    CHECK(says(refusal("two", usage, named("bull")),
               "has no grid `bull`; --grid names one of `ball` (level set), `mask` (mask)"));
    CHECK(says(refusal("same-names", usage), "holds 2 grids"));
    CHECK(says(refusal("unclassed", usage), "name it with --grid"));
    CHECK(says(refusal("none", invalid), "holds no grid"));
    CHECK(says(refusal("fog", unsupported, named("ball")), "fog volume"));
    CHECK(says(refusal("double", unsupported), "grid of double"));
    CHECK(says(refusal("vector", unsupported), "grid of vec3s"));
    CHECK(says(refusal("ints", unsupported, named("field")), "grid of int32"));
    CHECK(says(refusal("nan", invalid), "holds nan at (3, 1, 0)"));
    CHECK(says(refusal("infinite", invalid), "holds inf at (3, 1, 0)"));
    CHECK(says(refusal("nothing", invalid, named("[0]")), "nothing inside"));
    CHECK(says(refusal("positive", invalid, named("tile")), "no value is < 0"));
    CHECK(says(refusal("inverted", invalid, named("[0]")), "inside everywhere"));
    CHECK(says(refusal("all-true", invalid, named("[0]", true)), "inside everywhere"));
    CHECK(says(refusal("active-false", invalid, named("[0]", true)), "no cell is true"));
    CHECK(says(refusal("tiles-far-apart", requirement, named("tile")), "cells long on axis 0"));
    CHECK(says(refusal("at-the-end", invalid, named("tile")), "limit 2147475456"));
    CHECK(says(refusal("stretched", unsupported), "turns, shears or stretches"));
    CHECK(says(refusal("turned", unsupported), "turns, shears or stretches"));
    CHECK(says(refusal("sheared", unsupported), "turns, shears or stretches"));
    CHECK(says(refusal("mirrored", unsupported), "mirrors"));
    CHECK(says(refusal("frustum", unsupported), "frustum"));
    CHECK(says(refusal("huge-voxel", requirement), "voxel of 2000 m"));
    CHECK(says(refusal("far-away", requirement), "away from the origin on axis 0"));
    CHECK(says(refusal("ball", usage, named("ball", false, ForeignGrid::As::solid)), "--as is for masks"));
    ForeignGrid inches;
    inches.unit = 1e-12;
    CHECK(says(refusal("ball", requirement, inches), "is --unit right?"));
    CHECK(says(refusal("own-name", unsupported), "--snap"));
    foreign::save_kind("ball", folder / "ball.vdb");
    CHECK_THROWS_AS(read_vdb(folder / "ball.vdb"), Failure); // not a voxmap, unless asked for
}

TEST_CASE("our own .vdb is taken as before, and its other grids by name")
{
    foreign::save_mesh(folder / "ball.vdb", solids::sphere({0, 0, 0}, 0.01, 48), {0.0005});
    const VdbFile first = take(folder / "ball.vdb", named("surface", true));
    const auto path =
        folder.write("own.vdb", vdb_bytes(first.cells, first.source_hash, "{}", first.channels));
    const VdbFile own = take(path), by_name = take(path, named("state"));
    CHECK_FALSE(own.foreign);
    CHECK_FALSE(by_name.foreign);
    CHECK(own.cells.bricks.size() == first.cells.bricks.size());
    CHECK_THROWS_AS(take(path, named("state", true)), Failure);
    // What another program makes of `distance` comes back with it: the same cells, by the rule.
    const VdbFile distance = take(path, named("distance"));
    CHECK(distance.foreign->kind == "level set");
    CHECK(distance.cells.interior_cells == first.cells.interior_cells);
    CHECK(distance.cells.surface_cells == first.cells.surface_cells);
    CHECK(distance.channels.distance == first.channels.distance);
}

TEST_CASE("a damaged file of another program is refused, whatever is broken")
{
    foreign::save_kind("two", folder / "two.vdb");
    std::ifstream file(folder / "two.vdb", std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
    const auto code_of = [&](const std::vector<std::uint8_t> &damaged, const char *grid) {
        const auto path = folder.write("damaged.vdb", damaged);
        try {
            take(path, named(grid, true));
        } catch (const Failure &failure) {
            CHECK(failure.file == path.string());
            CHECK(std::string(failure.what()).find('\n') == std::string::npos);
            return failure.code;
        }
        return ExitCode::ok;
    };
    REQUIRE(code_of(bytes, "ball") == ExitCode::ok);
    REQUIRE(code_of(bytes, "mask") == ExitCode::ok);
    for (std::size_t size = 0; size < bytes.size(); size += size < 1500 ? 53 : bytes.size() / 19) {
        CAPTURE(size);
        const ExitCode code =
            code_of({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}, "mask");
        CHECK((code == ExitCode::invalid ||
               code == ExitCode::usage)); // cut before the name, the grid is not there
    }
    std::mt19937 random(3);
    int refused = 0;
    for (int trial = 0; trial < 120; ++trial) {
        CAPTURE(trial);
        auto damaged = bytes;
        const std::size_t reach = trial % 3 ? std::min<std::size_t>(2000, bytes.size()) : bytes.size();
        for (int f = 0; f < 1 + trial % 4; ++f)
            damaged[8 + random() % (reach - 8)] ^= static_cast<std::uint8_t>(1u << random() % 8);
        const ExitCode code = code_of(damaged, trial % 2 ? "mask" : "ball");
        CHECK((code == ExitCode::ok || code == ExitCode::usage || code == ExitCode::invalid ||
               code == ExitCode::requirement || code == ExitCode::unsupported));
        refused += code != ExitCode::ok;
    }
    MESSAGE(refused, " of 120 refused");
    CHECK(refused > 0);
    std::size_t left = 0; // what the test itself wrote is all that is there
    for (const auto &entry : std::filesystem::directory_iterator(folder.path))
        left += entry.path().extension() != ".vdb" && entry.path().extension() != ".voxmap";
    CHECK(left == 0);
}
