// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "solids.hpp"
#include "voxmap/classify.hpp"
#include "voxmap/voxelize.hpp"

#include <deque>
#include <tbb/global_control.h>

using namespace voxshell;

namespace {

struct Made {
    Cells cells;
    Classification said;
};

Made make(const Mesh &mesh, double voxel)
{
    Progress silent;
    const LatticeMesh lattice = snap(mesh, voxel);
    Made made{voxelize(lattice, bin_triangles(lattice, silent), silent), {}};
    made.said = classify(made.cells, WindingNumber(mesh), silent);
    return made;
}

/// An interior cell is exactly one that is not surface, not reached by a flood from outside, and inside by
/// `solid`.
template<class Solid>
void check_against_flood(const Cells &cells, const Solid &solid)
{
    Cell low, size;
    for (int a = 0; a < 3; ++a) low[a] = cells.min[a] - 2, size[a] = cells.max[a] - cells.min[a] + 5;
    const auto index = [&](const Cell &c) {
        return static_cast<std::size_t>(((c[0] - low[0]) * size[1] + c[1] - low[1]) * size[2] + c[2] -
                                        low[2]);
    };
    std::vector<std::uint8_t> state(static_cast<std::size_t>(size[0] * size[1] * size[2])),
        reached(state.size());
    Cell c;
    for (c[0] = low[0]; c[0] < low[0] + size[0]; ++c[0])
        for (c[1] = low[1]; c[1] < low[1] + size[1]; ++c[1])
            for (c[2] = low[2]; c[2] < low[2] + size[2]; ++c[2])
                state[index(c)] = static_cast<std::uint8_t>(cell_state(cells, c));
    std::deque<Cell> front{low};
    reached[index(low)] = 1;
    while (!front.empty()) {
        const Cell at = front.front();
        front.pop_front();
        for (int a = 0; a < 3; ++a)
            for (const int step : {-1, 1}) {
                Cell next = at;
                next[a] += step;
                if (next[a] < low[a] || next[a] >= low[a] + size[a] || reached[index(next)] ||
                    state[index(next)] == VXS_CELL_SURFACE)
                    continue;
                reached[index(next)] = 1;
                front.push_back(next);
            }
    }
    std::uint64_t surface = 0, interior = 0, wrong = 0;
    for (c[0] = low[0]; c[0] < low[0] + size[0]; ++c[0])
        for (c[1] = low[1]; c[1] < low[1] + size[1]; ++c[1])
            for (c[2] = low[2]; c[2] < low[2] + size[2]; ++c[2]) {
                const int s = state[index(c)];
                surface += s == VXS_CELL_SURFACE;
                interior += s == VXS_CELL_INTERIOR;
                if (s == VXS_CELL_SURFACE) continue;
                const Point center{cells.voxel * (static_cast<double>(c[0]) + 0.5),
                                   cells.voxel * (static_cast<double>(c[1]) + 0.5),
                                   cells.voxel * (static_cast<double>(c[2]) + 0.5)};
                wrong += (s == VXS_CELL_INTERIOR) != (!reached[index(c)] && solid(center));
            }
    CHECK(wrong == 0);
    CHECK(surface == cells.surface_cells);
    CHECK(interior == cells.interior_cells);
}

bool in_ball(const Point &p, double radius)
{
    return std::hypot(p[0], p[1], p[2]) < radius;
}

} // namespace

TEST_CASE("a ball is solid, whichever way its triangles wind")
{
    const Mesh ball = solids::sphere({0, 0, 0}, 0.02);
    for (const Mesh &mesh : {ball, solids::turned_inside_out(ball)}) {
        const Made made = make(mesh, 0.0007);
        check_against_flood(made.cells, [](const Point &p) { return in_ball(p, 0.02); });
        CHECK(made.said.components == 1);
        CHECK(made.said.cavities == 0);
        CHECK_FALSE(made.said.leak);
        const double volume = static_cast<double>(made.cells.interior_cells) * std::pow(0.0007, 3),
                     ball_volume = 4.0 / 3 * std::numbers::pi * 8e-6;
        CHECK(volume < ball_volume);
        CHECK(volume + static_cast<double>(made.cells.surface_cells) * std::pow(0.0007, 3) > ball_volume);
    }
}

TEST_CASE("large solids leave whole bricks as runs")
{
    const Made made = make(solids::box({0.0005, 0.0005, 0.0005}, {0.0615, 0.0415, 0.0915}), 0.001);
    CHECK_FALSE(made.cells.solid.empty());
    check_against_flood(made.cells, [](const Point &) { return true; });
    CHECK(made.cells.interior_cells == 60u * 40u * 90u); // surface cells 0..61: 60 between them
}

TEST_CASE("a cavity stays free, a nested closed part is solid once, overlap is solid")
{
    const Mesh outer = solids::sphere({0, 0, 0}, 0.02), inner = solids::sphere({0, 0, 0}, 0.012);
    const Made hollow = make(solids::join(outer, solids::turned_inside_out(inner)), 0.0005);
    check_against_flood(hollow.cells, [](const Point &p) { return !in_ball(p, 0.012); });
    CHECK(hollow.said.cavities == 1);
    const Made nested = make(solids::join(outer, inner), 0.0005);
    check_against_flood(nested.cells, [](const Point &) { return true; });
    CHECK(nested.said.cavities == 0);
    const Made overlap = make(solids::join(outer, solids::sphere({0.015, 0, 0}, 0.02)), 0.0005);
    check_against_flood(overlap.cells, [](const Point &) { return true; });
}

TEST_CASE("an open sheet has no interior; a bowl is reported as leaking at a place inside it")
{
    Mesh sheet;
    sheet.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0.03}};
    sheet.triangles = {{0, 1, 2}};
    const Made open = make(sheet, 0.001);
    CHECK(open.cells.interior_cells == 0);
    CHECK_FALSE(open.said.leak);

    Mesh bowl = solids::sphere({0, 0, 0}, 0.02);
    std::erase_if(bowl.triangles, [&](const Triangle &t) {
        return bowl.vertices[t[0]][1] > 0.018 || bowl.vertices[t[1]][1] > 0.018;
    });
    const Made leaking = make(bowl, 0.001);
    CHECK(leaking.cells.interior_cells == 0);
    REQUIRE(leaking.said.leak);
    CHECK(in_ball(leaking.said.leak->at, 0.02));
}

TEST_CASE("a hole smaller than a cell does not leak")
{
    Mesh ball = solids::sphere({0.0001, 0.0002, 0.0003}, 0.02, 60);
    ball.triangles.erase(ball.triangles.begin() + 1000);
    const Made made = make(ball, 0.002);
    CHECK(made.cells.interior_cells > 0);
    CHECK_FALSE(made.said.leak);
}

TEST_CASE("closing gaps: a ball with a hole of five cells is solid again, its surface cells unchanged")
{
    const double h = 0.0005, hole = 0.0028;
    Mesh ball = solids::sphere({0, 0, 0}, 0.02, 96);
    std::erase_if(ball.triangles, [&](const Triangle &t) {
        bool near = true;
        for (const std::uint32_t v : t)
            near = near && ball.vertices[v][1] > 0 &&
                   std::hypot(ball.vertices[v][0], ball.vertices[v][2]) < hole / 2;
        return near;
    });
    const Made leaking = make(ball, h);
    CHECK(leaking.said.leak);
    CHECK(leaking.cells.interior_cells == 0);
    Progress silent;
    Cells closed = leaking.cells;
    const Classification said = classify_closing(closed, WindingNumber(ball), hole + h, silent);
    CHECK_FALSE(said.leak);
    CHECK(closed.surface_cells == leaking.cells.surface_cells);
    std::uint64_t wrong = 0, surface = 0;
    Cell c;
    for (c[0] = -44; c[0] < 44; ++c[0])
        for (c[1] = -44; c[1] < 44; ++c[1])
            for (c[2] = -44; c[2] < 44; ++c[2]) {
                const int state = cell_state(closed, c);
                const Point center{h * (static_cast<double>(c[0]) + 0.5),
                                   h * (static_cast<double>(c[1]) + 0.5),
                                   h * (static_cast<double>(c[2]) + 0.5)};
                surface += state == VXS_CELL_SURFACE;
                wrong += (state == VXS_CELL_SURFACE) != (cell_state(leaking.cells, c) == VXS_CELL_SURFACE);
                if (std::abs(std::hypot(center[0], center[1], center[2]) - 0.02) < 2 * h ||
                    state == VXS_CELL_SURFACE)
                    continue;
                wrong += (state == VXS_CELL_INTERIOR) != in_ball(center, 0.02);
            }
    CHECK(wrong == 0);
    CHECK(surface == closed.surface_cells);
    CHECK_THROWS_AS(classify_closing(closed, WindingNumber(ball), 1, silent), Failure);

    // A wide reach: several steps of eight cells, bricks far from any surface cell become uniform again.
    Cells wide = leaking.cells;
    classify_closing(wide, WindingNumber(ball), 20 * h, silent);
    CHECK(wide.interior_cells == closed.interior_cells);
}

TEST_CASE("the same cells for one thread and for two, and at every scale and place")
{
    const Mesh ball = solids::sphere({0, 0, 0}, 0.02);
    const Made two = make(ball, 0.0007);
    tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Made single = make(ball, 0.0007);
    const auto same = [](const Cells &a, const Cells &b, std::int64_t shift) {
        REQUIRE(a.bricks.size() == b.bricks.size());
        bool equal = a.solid == b.solid;
        for (std::size_t n = 0; n < a.bricks.size(); ++n)
            equal = equal && a.bricks[n].at == b.bricks[n].at && a.bricks[n].surface == b.bricks[n].surface &&
                    a.bricks[n].interior == b.bricks[n].interior;
        CHECK(equal);
        for (int axis = 0; axis < 3; ++axis) CHECK(a.origin[axis] + shift == b.origin[axis]);
    };
    same(two.cells, single.cells, 0);
    for (const double scale : {0x1p-14, 0x1p15}) { // about 1 um and 1 km across
        Mesh scaled = ball;
        for (Point &p : scaled.vertices)
            for (double &c : p) c *= scale;
        same(two.cells, make(scaled, 0.0007 * scale).cells, 0);
    }
    Mesh far = ball; // 10 km away by whole chunks of cells; the voxel is a power of two so that the shift
                     // itself is exact
    const double h = 0x1p-10;
    const Made here = make(ball, h);
    for (Point &p : far.vertices)
        for (double &c : p) c = std::round(c * 0x1p26) * 0x1p-26 + 64 * 160000 * h;
    Mesh near = ball;
    for (Point &p : near.vertices)
        for (double &c : p) c = std::round(c * 0x1p26) * 0x1p-26;
    same(make(near, h).cells, make(far, h).cells, 64 * 160000);
    CHECK(here.cells.surface_cells > 0);
}

TEST_CASE("impossible requests are refused with the smallest voxel that fits")
{
    const Mesh ball = solids::sphere({0, 0, 0}, 500); // 1 km
    try {
        snap(ball, 1e-6);
        FAIL("accepted");
    } catch (const Failure &failure) {
        CHECK(failure.code == ExitCode::requirement);
        CHECK(std::string(failure.what()).find("--voxel") != std::string::npos);
        const std::string text = failure.what();
        const double voxel = std::stod(text.substr(text.find("--voxel ") + 8));
        CHECK(voxel > 1e-6);
        CHECK_NOTHROW(snap(ball, voxel));
    }
    CHECK_THROWS_AS(snap(ball, 0), Failure);
    CHECK_THROWS_AS(snap(ball, -1), Failure);
}
