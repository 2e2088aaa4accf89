// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "mesh/winding.hpp"

#include "solids.hpp"

#include <doctest/doctest.h>
#include <tbb/global_control.h>

using namespace voxshell;

namespace {

// The plain sum over all triangles, in long double and by another formula: the spherical excess from
// the dihedral angles of the tangent vectors (not the one that the tree's leaves use).
double brute(const Mesh &mesh, const Point &q)
{
    using Real = long double;
    Real sum = 0;
    for (const Triangle &t : mesh.triangles) {
        Real a[3][3], n[3];
        for (int v = 0; v < 3; ++v) {
            n[v] = 0;
            for (int i = 0; i < 3; ++i) {
                a[v][i] = static_cast<Real>(mesh.vertices[t[v]][i]) - static_cast<Real>(q[i]);
                n[v] += a[v][i] * a[v][i];
            }
            n[v] = std::sqrt(n[v]);
        }
        const auto dot = [](const Real *x, const Real *y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; };
        const Real c[3] = {a[1][1] * a[2][2] - a[1][2] * a[2][1], a[1][2] * a[2][0] - a[1][0] * a[2][2],
                           a[1][0] * a[2][1] - a[1][1] * a[2][0]};
        // L'Huilier on the sides of the spherical triangle
        Real side[3], s = 0;
        for (int v = 0; v < 3; ++v) {
            const int w = (v + 1) % 3;
            Real x[3], y[3], p = 0, m = 0;
            for (int i = 0; i < 3; ++i) {
                x[i] = a[v][i] / n[v], y[i] = a[w][i] / n[w];
                p += (x[i] + y[i]) * (x[i] + y[i]);
                m += (x[i] - y[i]) * (x[i] - y[i]);
            }
            side[v] = 2 * std::atan2(std::sqrt(m), std::sqrt(p));
            s += side[v] / 2;
        }
        const Real product = std::tan(s / 2) * std::tan((s - side[0]) / 2) * std::tan((s - side[1]) / 2) *
                             std::tan((s - side[2]) / 2);
        const Real excess = 4 * std::atan(std::sqrt(product > 0 ? product : 0));
        sum += dot(a[0], c) > 0 ? excess : -excess;
    }
    return static_cast<double>(sum / (4 * std::numbers::pi_v<Real>));
}

double worst_error(const Mesh &mesh, int points, double spread, const Point &center = {})
{
    const WindingNumber tree(mesh);
    std::mt19937 random(7);
    double worst = 0;
    for (int k = 0; k < points; ++k) {
        Point q{};
        for (int i = 0; i < 3; ++i)
            q[i] = center[i] + spread * (static_cast<double>(random()) / 2147483647.5 - 1);
        worst = std::max(worst, std::abs(tree.at(q) - brute(mesh, q)));
    }
    MESSAGE(mesh.triangles.size() << " triangles: worst error " << worst);
    return worst;
}

} // namespace

TEST_CASE("closed meshes: 1 inside, 0 outside, -1 inside an inverted one")
{
    Mesh m = solids::ball(1, 40);
    CHECK(WindingNumber(m).at({0.1, 0.2, 0.3}) == doctest::Approx(1).epsilon(1e-2));
    CHECK(std::abs(WindingNumber(m).at({1.1, 0.2, 0.3})) < 1e-2);
    solids::invert(m);
    CHECK(WindingNumber(m).at({0.1, 0.2, 0.3}) == doctest::Approx(-1).epsilon(1e-2));
    CHECK(WindingNumber(Mesh{}).at({0, 0, 0}) == 0);
}

TEST_CASE("the tree agrees with the plain sum to 0.01")
{
    CHECK(worst_error(solids::ball(1, 30), 400, 1.3) < 0.01);
    CHECK(worst_error(solids::random_soup(3000, 1, 0.05), 200, 0.7) < 0.01);
    CHECK(worst_error(solids::random_soup(1000, 2, 0.5), 200, 0.7) < 0.01);
    CHECK(worst_error(solids::random_soup(200, 3, 2), 200, 1.5) < 0.01);
    Mesh open = solids::ball(1, 40);
    open.triangles.resize(open.triangles.size() / 2);
    CHECK(worst_error(open, 200, 1.2) < 0.01);
    // a thin sheet, seen edge-on and from close by: what a quadrupole is bad at
    Mesh plate = solids::soup(solids::box({-1, -1e-3, -1}, {1, 1e-3, 1}));
    for (int k = 0; k < 4; ++k) { // four times finer
        Mesh finer;
        for (const Triangle &t : plate.triangles) {
            Point p[6];
            for (int v = 0; v < 3; ++v)
                for (int i = 0; i < 3; ++i) {
                    p[v][i] = plate.vertices[t[v]][i];
                    p[v + 3][i] = (plate.vertices[t[v]][i] + plate.vertices[t[(v + 1) % 3]][i]) / 2;
                }
            for (const auto &[x, y, z] :
                 {std::array{0, 3, 5}, std::array{3, 1, 4}, std::array{5, 4, 2}, std::array{3, 4, 5}}) {
                const auto base = static_cast<std::uint32_t>(finer.vertices.size());
                finer.vertices.insert(finer.vertices.end(), {p[x], p[y], p[z]});
                finer.triangles.push_back({base, base + 1, base + 2});
            }
        }
        plate = finer;
    }
    CHECK(worst_error(plate, 300, 1.2) < 0.01);
}

TEST_CASE("scale and place do not matter")
{
    for (const double scale : {1e-9, 1e-6, 1e3, 1e12}) {
        const Point far{1e4 * scale, -2e4 * scale, 3e4 * scale};
        const WindingNumber tree(solids::ball(scale, 30, far));
        CHECK(tree.at({far[0] + 0.5 * scale, far[1], far[2]}) == doctest::Approx(1).epsilon(1e-2));
        CHECK(std::abs(tree.at({far[0] + 1.5 * scale, far[1], far[2]})) < 1e-2);
    }
}

TEST_CASE(
    "degenerate triangles count nothing and make no NaN; points on a face, an edge and a vertex are finite")
{
    Mesh m = solids::box({0, 0, 0}, {1, 1, 1});
    m.triangles.push_back({0, 0, 0});
    m.triangles.push_back({0, 7, 0});
    for (int k = 0; k < 40; ++k) m.triangles.push_back({3, 3, 3});
    const WindingNumber tree(m);
    CHECK(tree.at({0.5, 0.5, 0.5}) == doctest::Approx(1));
    for (const Point &q : {Point{0, 0, 0}, Point{0.5, 0, 0}, Point{0.25, 0.5, 0}, Point{1, 1, 1}})
        CHECK(std::isfinite(tree.at(q)));
    CHECK(tree.at({0.25, 0.5, 0}) == doctest::Approx(0.5)); // the mean of both sides
}

TEST_CASE("the same bits for any thread count")
{
    const Mesh m = solids::random_soup(20000, 5, 0.1);
    std::vector<double> seen[2];
    for (const int threads : {1, 2}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(threads));
        const WindingNumber tree(m);
        for (int k = 0; k < 200; ++k)
            seen[threads - 1].push_back(tree.at({k * 0.005 - 0.5, 0.1, 0.01 * (k % 7)}));
    }
    CHECK(seen[0] == seen[1]);
}
