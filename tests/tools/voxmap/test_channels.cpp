// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "solids.hpp"
#include "voxmap/channels.hpp"
#include "voxmap/classify.hpp"

#include <random>
#include <tbb/global_control.h>

using namespace voxshell;

namespace {

struct Made {
    Cells cells;
    Channels channels;
};

Made make(const Mesh &mesh, double voxel, bool closed, const ChannelRequest &request)
{
    Progress silent;
    const LatticeMesh lattice = snap(mesh, voxel);
    const BrickTriangles binned = bin_triangles(lattice, silent);
    const WindingNumber winding(mesh);
    Made made{voxelize(lattice, binned, silent), {}};
    classify(made.cells, winding, silent);
    made.channels = make_channels(made.cells, lattice, binned, winding, closed, request, silent);
    return made;
}

const Brick *brick_of(const Cells &cells, const Cell &at, std::size_t &index, std::size_t &cell)
{
    BrickAt b;
    Cell c;
    for (int a = 0; a < 3; ++a) {
        c[a] = at[a] - cells.origin[a];
        if (c[a] < 0) return nullptr;
        b[a] = static_cast<std::int32_t>(c[a] >> 3);
    }
    const auto found = std::lower_bound(cells.bricks.begin(), cells.bricks.end(), b,
                                        [](const Brick &x, const BrickAt &at_b) { return x.at < at_b; });
    if (found == cells.bricks.end() || found->at != b) return nullptr;
    index = static_cast<std::size_t>(found - cells.bricks.begin());
    cell = static_cast<std::size_t>((c[0] & 7) << 6 | (c[1] & 7) << 3 | (c[2] & 7));
    return &*found;
}

/// Distance of a point from a triangle by an independent way: minimise over the barycentric square, then
/// polish on features.
double distance_to(const Point &p, const Point &a, const Point &b, const Point &c)
{
    const auto sub = [](const Point &x, const Point &y) {
        return Point{x[0] - y[0], x[1] - y[1], x[2] - y[2]};
    };
    const auto dot = [](const Point &x, const Point &y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
    const Point u = sub(b, a), v = sub(c, a), w = sub(p, a);
    const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), wu = dot(w, u), wv = dot(w, v),
                 det = uu * vv - uv * uv;
    double best = INFINITY;
    const auto consider = [&](double s, double t) {
        Point q;
        for (int k = 0; k < 3; ++k) q[k] = a[k] + s * u[k] + t * v[k] - p[k];
        best = std::min(best, std::sqrt(dot(q, q)));
    };
    if (det > 0) {
        const double s = (wu * vv - wv * uv) / det, t = (wv * uu - wu * uv) / det;
        if (s >= 0 && t >= 0 && s + t <= 1) consider(s, t);
    }
    if (uu > 0) consider(std::clamp(wu / uu, 0.0, 1.0), 0);
    if (vv > 0) consider(0, std::clamp(wv / vv, 0.0, 1.0));
    const Point e = sub(c, b), x = sub(p, b);
    const double ee = dot(e, e), r = ee > 0 ? std::clamp(dot(x, e) / ee, 0.0, 1.0) : 0.0;
    consider(1 - r, r);
    return best;
}

double mesh_distance(const Mesh &mesh, const Point &p)
{
    double best = INFINITY;
    for (const Triangle &t : mesh.triangles)
        best = std::min(best, distance_to(p, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
    return best;
}

/// Every cell (or each `stride`th along each axis, odd: in all places of a brick) of the box grown by
/// `margin` against brute force; `inside` says the sign.
template<class Inside>
void check_distance(const Made &made, const Mesh &mesh, const Inside &inside, int margin = 6, int stride = 1)
{
    const Channels &ch = made.channels;
    std::uint64_t wrong = 0, signs = 0, missing = 0, seen = 0;
    Cell c;
    for (c[0] = made.cells.min[0] - margin; c[0] <= made.cells.max[0] + margin; c[0] += stride)
        for (c[1] = made.cells.min[1] - margin; c[1] <= made.cells.max[1] + margin; c[1] += stride)
            for (c[2] = made.cells.min[2] - margin; c[2] <= made.cells.max[2] + margin; c[2] += stride) {
                Point p;
                for (int a = 0; a < 3; ++a) p[a] = made.cells.voxel * (static_cast<double>(c[a]) + 0.5);
                const double d = mesh_distance(mesh, p);
                std::size_t index, cell;
                if (!brick_of(made.cells, c, index, cell)) {
                    missing += d < ch.distance_band - ch.distance_error;
                    continue;
                }
                ++seen;
                const double stored = ch.distance[index][cell] * ch.distance_step;
                wrong += std::abs(std::abs(stored) - std::min(d, ch.distance_band)) > ch.distance_error;
                if (d > ch.distance_error) signs += (stored < 0) != inside(p);
            }
    CHECK(wrong == 0);
    CHECK(signs == 0);
    CHECK(missing == 0);
    CHECK(seen > 0);
}

} // namespace

TEST_CASE("distance of a box: faces, convex edges and corners, sign in surface cells too")
{
    const Point low{0.00213, 0.0031, -0.0042}, high{0.0147, 0.0119, 0.0071};
    const Mesh mesh = solids::box(low, high);
    const Made made = make(mesh, 0.001, true, {0, 4});
    check_distance(made, mesh, [&](const Point &p) {
        return p[0] > low[0] && p[0] < high[0] && p[1] > low[1] && p[1] < high[1] && p[2] > low[2] &&
               p[2] < high[2];
    });
    CHECK(made.channels.distance_error < 1e-4 * made.cells.voxel * 2);
}

TEST_CASE("a box with its faces on cell centres and on grid planes")
{
    for (const double shift : {0.0, 0.0005}) {
        const Point low{shift, shift, shift}, high{0.008 + shift, 0.006 + shift, 0.01 + shift};
        const Mesh mesh = solids::box(low, high);
        const Made made = make(mesh, 0.001, true, {0, 3});
        check_distance(made, mesh, [&](const Point &p) {
            return p[0] > low[0] && p[0] < high[0] && p[1] > low[1] && p[1] < high[1] && p[2] > low[2] &&
                   p[2] < high[2];
        });
    }
}

TEST_CASE("a hollow ball: concave walls, a cavity, either winding")
{
    const Mesh hollow = solids::join(solids::sphere({0, 0, 0}, 0.01, 10),
                                     solids::turned_inside_out(solids::sphere({0, 0, 0}, 0.005, 10)));
    const WindingNumber winding(hollow);
    for (const Mesh &mesh : {hollow, solids::turned_inside_out(hollow)}) {
        const Made made = make(mesh, 0.001, true, {0, 3});
        check_distance(made, mesh, [&](const Point &p) { return std::abs(winding.at(p)) > 0.5; });
    }
}

TEST_CASE("two solids that overlap are inside once, whatever lies between")
{
    const Mesh mesh = solids::join(solids::box({0, 0, 0}, {0.0083, 0.0083, 0.0083}),
                                   solids::box({0.0041, 0.0041, 0.0041}, {0.0127, 0.0127, 0.0127}));
    const auto in = [](const Point &p, double l, double h) {
        return p[0] > l && p[0] < h && p[1] > l && p[1] < h && p[2] > l && p[2] < h;
    };
    const Made made = make(mesh, 0.001, true, {0, 3});
    check_distance(made, mesh, [&](const Point &p) { return in(p, 0, 0.0083) || in(p, 0.0041, 0.0127); });
}

TEST_CASE("an open sheet has unsigned distance; a bowl with a small hole has the winding number's sign")
{
    Mesh sheet;
    sheet.vertices = {{0.0003, 0.0001, 0.0002}, {0.0131, 0, 0.002}, {0, 0.0117, 0.0043}};
    sheet.triangles = {{0, 1, 2}};
    const Made open = make(sheet, 0.001, false, {0, 3});
    CHECK(open.channels.unsigned_distance);
    check_distance(open, sheet, [](const Point &) { return false; });

    Mesh ball = solids::sphere({0, 0, 0}, 0.01, 24);
    ball.triangles.erase(ball.triangles.begin() + 100);
    const WindingNumber winding(ball);
    const Made made = make(ball, 0.0013, false, {0, 3});
    CHECK_FALSE(made.channels.unsigned_distance);
    check_distance(made, ball, [&](const Point &p) { return std::abs(winding.at(p)) >= 0.5; });
}

TEST_CASE("a band of many bricks, outside, inside and in a cavity; none is kept that says nothing")
{
    const auto check_kept = [](const Made &made) {
        std::uint64_t silent = 0;
        for (std::size_t b = 0; b < made.cells.bricks.size(); ++b) {
            std::uint64_t surface = 0, some = 0, all = ~std::uint64_t{0};
            for (std::size_t i = 0; i < 8; ++i) {
                surface |= made.cells.bricks[b].surface[i];
                some |= made.cells.bricks[b].interior[i], all &= made.cells.bricks[b].interior[i];
            }
            const bool told = std::any_of(made.channels.distance[b].begin(), made.channels.distance[b].end(),
                                          [](std::int16_t d) { return std::abs(d) < 32767; });
            silent += !told && !surface && (some == 0 || ~all == 0);
        }
        CHECK(silent == 0);
    };
    const Point low{0.00213, 0.0031, -0.0042}, high{0.0647, 0.0419, 0.0771};
    const Mesh box = solids::box(low, high);
    const Mesh hollow = solids::join(solids::sphere({0.001, 0, 0}, 0.03, 12),
                                     solids::turned_inside_out(solids::sphere({0, 0.002, 0}, 0.017, 10)));
    const WindingNumber winding(hollow);
    Mesh sheet;
    sheet.vertices = {{0.0003, 0.0001, 0.0002}, {0.0531, 0, 0.012}, {0, 0.0417, 0.0243}, {0.05, 0.05, 0.05}};
    sheet.triangles = {{0, 1, 2}, {1, 2, 3}};
    for (const double band : {16.0, 32.0, 64.0}) {
        CAPTURE(band);
        const int margin = static_cast<int>(band) + 10, stride = band < 20 ? 3 : band < 40 ? 5 : 7;
        const Made solid = make(box, 0.001, true, {0, band});
        check_distance(
            solid, box,
            [&](const Point &p) {
                return p[0] > low[0] && p[0] < high[0] && p[1] > low[1] && p[1] < high[1] && p[2] > low[2] &&
                       p[2] < high[2];
            },
            margin, stride);
        check_kept(solid);
        const Made shell = make(hollow, 0.0011, true, {0, band});
        check_distance(
            shell, hollow, [&](const Point &p) { return std::abs(winding.at(p)) > 0.5; }, margin, stride + 2);
        check_kept(shell);
        const Made open = make(sheet, 0.001, false, {0, band});
        CHECK(open.channels.unsigned_distance);
        check_distance(
            open, sheet, [](const Point &) { return false; }, margin, stride);
        check_kept(open);
        tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
        const Made single = make(hollow, 0.0011, true, {0, band});
        CHECK(single.channels.distance == shell.channels.distance);
    }
}

TEST_CASE("layers are Chebyshev rings around the surface, across bricks")
{
    const Mesh ball = solids::sphere({0.002, 0, 0}, 0.012, 16);
    const int count = 5;
    const Made made = make(ball, 0.001, true, {count, 0});
    REQUIRE(made.channels.layer.size() == made.cells.bricks.size());
    std::uint64_t wrong = 0, missing = 0;
    Cell c;
    for (c[0] = made.cells.min[0] - 7; c[0] <= made.cells.max[0] + 7; ++c[0])
        for (c[1] = made.cells.min[1] - 7; c[1] <= made.cells.max[1] + 7; ++c[1])
            for (c[2] = made.cells.min[2] - 7; c[2] <= made.cells.max[2] + 7; ++c[2]) {
                int ring = count + 1;
                for (int r = 0; r <= count && ring > count; ++r)
                    for (int i = -r; i <= r; ++i)
                        for (int j = -r; j <= r; ++j)
                            for (int k = -r; k <= r; ++k)
                                if (std::max({std::abs(i), std::abs(j), std::abs(k)}) == r &&
                                    cell_state(made.cells, {c[0] + i, c[1] + j, c[2] + k}) ==
                                        VXS_CELL_SURFACE)
                                    ring = r;
                if (cell_state(made.cells, c) == VXS_CELL_INTERIOR) ring = -ring;
                std::size_t index, cell;
                if (!brick_of(made.cells, c, index, cell))
                    missing += std::abs(ring) <= count;
                else
                    wrong += made.channels.layer[index][cell] != ring;
            }
    CHECK(wrong == 0);
    CHECK(missing == 0);
}

TEST_CASE("channels do not change the cells, nor depend on threads; nothing asked, nothing made")
{
    const Mesh ball = solids::sphere({0, 0, 0}, 0.03, 24);
    const Made plain = make(ball, 0.001, true, {0, 0}), rich = make(ball, 0.001, true, {3, 3});
    CHECK(plain.channels.layer.empty());
    CHECK(plain.channels.distance.empty());
    CHECK(plain.cells.surface_cells == rich.cells.surface_cells);
    CHECK(plain.cells.interior_cells == rich.cells.interior_cells);
    Cells again = rich.cells;
    recount(again);
    CHECK(again.surface_cells == plain.cells.surface_cells);
    CHECK(again.interior_cells == plain.cells.interior_cells);
    std::mt19937 random(5);
    Cell c;
    bool same = true;
    for (int n = 0; n < 20000; ++n) {
        for (int a = 0; a < 3; ++a) c[a] = static_cast<std::int64_t>(random() % 90) - 45;
        same = same && cell_state(plain.cells, c) == cell_state(rich.cells, c);
    }
    CHECK(same);
    tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const Made single = make(ball, 0.001, true, {3, 3});
    CHECK(single.channels.distance == rich.channels.distance);
    CHECK(single.channels.layer == rich.channels.layer);
}

TEST_CASE("a reach beyond the most is refused")
{
    const Mesh ball = solids::sphere({0, 0, 0}, 0.01, 8);
    CHECK_THROWS_AS(make(ball, 0.001, true, {9, 0}), Failure);
    CHECK_THROWS_AS(make(ball, 0.001, true, {0, 64.5}), Failure);
    CHECK_THROWS_AS(make(ball, 0.001, true, {0, -1}), Failure);
}
