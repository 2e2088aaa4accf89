// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "mesh/mass.hpp"

#include "cli/failure.hpp"
#include "solids.hpp"

#include <doctest/doctest.h>

#include <functional>
#include <string>

using namespace voxshell;

namespace {

constexpr double pi = std::numbers::pi, steel = 7850;

using Tensor = std::array<double, 6>;

/// The largest difference, of the largest entry.
double off(const MassProperties &m, double mass, const Point &com, const Tensor &inertia, double size)
{
    double worst = std::abs(m.mass / mass - 1), most = 0;
    for (std::size_t i = 0; i < 3; ++i) worst = std::max(worst, std::abs(m.com[i] - com[i]) / size);
    for (const double value : inertia) most = std::max(most, std::abs(value));
    for (std::size_t n = 0; n < 6; ++n) worst = std::max(worst, std::abs(m.inertia[n] - inertia[n]) / most);
    return worst;
}

Tensor box_inertia(double mass, double a, double b, double c)
{
    return {mass * (b * b + c * c) / 12, mass * (a * a + c * c) / 12, mass * (a * a + b * b) / 12, 0, 0, 0};
}

/// A grid of quads that closes in both directions (or ends in the axis), outward if u x v is.
Mesh closed(int us, int vs, const std::function<Point(double, double)> &at)
{
    Mesh m;
    for (int i = 0; i < us; ++i)
        for (int j = 0; j < vs; ++j) m.vertices.push_back(at(2 * pi * i / us, 2 * pi * j / vs));
    const auto index = [&](int i, int j) { return static_cast<std::uint32_t>((i % us) * vs + j % vs); };
    for (int i = 0; i < us; ++i)
        for (int j = 0; j < vs; ++j) {
            m.triangles.push_back({index(i, j), index(i + 1, j), index(i + 1, j + 1)});
            m.triangles.push_back({index(i, j), index(i + 1, j + 1), index(i, j + 1)});
        }
    return m;
}

Mesh torus(double ring, double tube, int n)
{
    return closed(2 * n, n, [=](double u, double v) {
        const double r = ring + tube * std::cos(v);
        return Point{r * std::cos(u), r * std::sin(u), tube * std::sin(v)};
    });
}

/// About z, from -height/2 to height/2.
Mesh cylinder(double radius, double height, int n)
{
    Mesh m;
    const auto count = static_cast<std::uint32_t>(n);
    m.vertices = {{0, 0, -height / 2}, {0, 0, height / 2}};
    for (std::uint32_t i = 0; i < count; ++i)
        for (const double z : {-height / 2, height / 2})
            m.vertices.push_back({radius * std::cos(2 * pi * i / n), radius * std::sin(2 * pi * i / n), z});
    for (std::uint32_t i = 0; i < count; ++i) {
        const std::uint32_t a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % count);
        for (const Triangle &t :
             {Triangle{0, b, a}, Triangle{1, a + 1, b + 1}, Triangle{a, b, b + 1}, Triangle{a, b + 1, a + 1}})
            m.triangles.push_back(t);
    }
    return m;
}

/// Errors of a shape at n and 2n: a quarter of them, since a circle's polygon lacks the square of its edge.
void check_convergence(const std::function<Mesh(int)> &shape, double mass, const Tensor &inertia, double size)
{
    const double coarse = off(mass_properties(shape(32), steel), mass, {0, 0, 0}, inertia, size),
                 fine = off(mass_properties(shape(64), steel), mass, {0, 0, 0}, inertia, size),
                 finest = off(mass_properties(shape(256), steel), mass, {0, 0, 0}, inertia, size);
    CHECK(coarse / fine == doctest::Approx(4).epsilon(0.03));
    CHECK(finest < 1e-3);
    CHECK(finest < fine / 12);
}

Mesh placed(Mesh m, const std::array<double, 9> &r, const Point &by)
{
    for (Point &p : m.vertices) {
        const Point q = p;
        for (std::size_t i = 0; i < 3; ++i)
            p[i] = r[3 * i] * q[0] + r[3 * i + 1] * q[1] + r[3 * i + 2] * q[2] + by[i];
    }
    return m;
}

/// r t r^T
Tensor turned(const Tensor &t, const std::array<double, 9> &r)
{
    const double full[3][3] = {{t[0], t[3], t[4]}, {t[3], t[1], t[5]}, {t[4], t[5], t[2]}};
    const auto entry = [&](std::size_t a, std::size_t b) {
        double sum = 0;
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) sum += r[3 * a + i] * full[i][j] * r[3 * b + j];
        return sum;
    };
    return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)};
}

const std::array<double, 9> turn = [] {
    const double w = 0.8, x = 0.2, y = -0.4, z = 0.4; // of length 1
    return std::array<double, 9>{1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
                                 2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                                 2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}();

std::string refusal(const Mesh &mesh, double density, ExitCode code)
{
    try {
        mass_properties(mesh, density);
    } catch (const Failure &failure) {
        CHECK(failure.code == code);
        return failure.what();
    }
    FAIL("not refused");
    return {};
}

} // namespace

TEST_CASE("a box is exact, wherever it is and however it is turned")
{
    const double a = 0.03, b = 0.02, c = 0.07, mass = steel * a * b * c;
    const Mesh box = solids::box({-a / 2, -b / 2, -c / 2}, {a / 2, b / 2, c / 2});
    const Tensor inertia = box_inertia(mass, a, b, c);
    const MassProperties m = mass_properties(box, steel);
    CHECK(m.volume == doctest::Approx(a * b * c).epsilon(1e-14));
    CHECK(off(m, mass, {0, 0, 0}, inertia, c) < 1e-14);
    CHECK(off(mass_properties(solids::soup(box), steel), mass, {0, 0, 0}, inertia, c) < 1e-14);
    CHECK(off(mass_properties(placed(box, turn, {0.4, -0.1, 0.2}), steel), mass, {0.4, -0.1, 0.2},
              turned(inertia, turn), c) < 1e-13);
    // 10 km away a coordinate has lost 12 digits of 16 already
    CHECK(off(mass_properties(placed(box, turn, {1e4, 1e4, -1e4}), steel), mass, {1e4, 1e4, -1e4},
              turned(inertia, turn), c) < 1e-9);
    for (const double s : {1e-6, 1e3}) {
        Mesh other = box;
        for (Point &p : other.vertices) p = {s * p[0], s * p[1], s * p[2]};
        CHECK(off(mass_properties(other, steel), mass * s * s * s, {0, 0, 0},
                  box_inertia(mass * s * s * s, s * a, s * b, s * c), s * c) < 1e-13);
    }
}

TEST_CASE("an inside-out mesh is the solid itself")
{
    const Mesh box = placed(solids::box({0, 0, 0}, {1, 2, 3}), turn, {1, 2, 3});
    Mesh inverted = box;
    solids::invert(inverted);
    const MassProperties m = mass_properties(box, steel), n = mass_properties(inverted, steel);
    CHECK(m.mass > 0);
    CHECK(off(n, m.mass, m.com, m.inertia, 1) < 1e-14);
}

TEST_CASE("round bodies are met with the square of their edges")
{
    const double r = 0.02, h = 0.05, ring = 0.03, tube = 0.01;
    const double ball = steel * 4 / 3 * pi * r * r * r;
    check_convergence([&](int n) { return solids::ball(r, n); }, ball,
                      {0.4 * ball * r * r, 0.4 * ball * r * r, 0.4 * ball * r * r, 0, 0, 0}, r);
    const double rod = steel * pi * r * r * h, across = rod * (3 * r * r + h * h) / 12;
    check_convergence([&](int n) { return cylinder(r, h, n); }, rod,
                      {across, across, rod * r * r / 2, 0, 0, 0}, h);
    const double hoop = steel * 2 * pi * pi * ring * tube * tube,
                 flat = hoop * (4 * ring * ring + 5 * tube * tube) / 8;
    check_convergence([&](int n) { return torus(ring, tube, n); }, hoop,
                      {flat, flat, hoop * (ring * ring + 0.75 * tube * tube), 0, 0, 0}, ring);
}

TEST_CASE("parts add up about the common centre, and a cavity takes away")
{
    // two cubes of 1 kg/m^3 at x = 0 and x = 4: Steiner's part is 2 x 1 x 2^2 about y and z
    Mesh two = solids::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});
    solids::append(two, solids::box({3.5, -0.5, -0.5}, {4.5, 0.5, 0.5}));
    CHECK(off(mass_properties(two, 1), 2, {2, 0, 0}, {2.0 / 6, 2.0 / 6 + 8, 2.0 / 6 + 8, 0, 0, 0}, 1) <
          1e-14);
    Mesh cavity = solids::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}),
         hollow = solids::box({-1, -1, -1}, {1, 1, 1});
    solids::invert(cavity);
    solids::append(hollow, cavity);
    const double inertia = 8 * 8.0 / 12 - 1 * 2.0 / 12;
    CHECK(off(mass_properties(hollow, 1), 7, {0, 0, 0}, {inertia, inertia, inertia, 0, 0, 0}, 1) < 1e-14);
    // an L: the products have a sign, xy = -sum m x y
    Mesh slant = solids::box({0, 0, 0}, {1, 1, 1});
    solids::append(slant, solids::box({1, 1, 0}, {2, 2, 1}));
    CHECK(mass_properties(slant, 1).inertia[3] == doctest::Approx(-0.5).epsilon(1e-14)); // 2 x (1/2 x 1/2)
}

TEST_CASE("what encloses nothing is refused by name, with a way out")
{
    Mesh open = solids::box({0, 0, 0}, {1, 1, 1});
    open.name = "lid";
    open.triangles.pop_back();
    CHECK(refusal(open, steel, ExitCode::requirement) ==
          "mesh \"lid\" has 3 open edges, and what is open has no volume: close it, or say mass, com and "
          "inertia");
    Mesh mixed = solids::box({0, 0, 0}, {1, 1, 1});
    std::swap(mixed.triangles[0][1], mixed.triangles[0][2]);
    CHECK(refusal(mixed, steel, ExitCode::requirement) ==
          "the mesh has 3 edges where triangles face opposite ways: orient it, or say mass, com and inertia");
    CHECK(refusal(Mesh{}, steel, ExitCode::requirement).find("no triangles") != std::string::npos);
    Mesh both = solids::box({0, 0, 0}, {1, 1, 1}), inside = both; // a solid and its own inverse
    solids::invert(inside);
    solids::append(both, inside);
    CHECK(refusal(both, steel, ExitCode::requirement).find("no volume") != std::string::npos);
    CHECK(refusal(solids::box({0, 0, 0}, {1, 1, 0}), steel, ExitCode::requirement).size() > 20);
    for (const double density : {0.0, -1.0, std::nan(""), HUGE_VAL})
        CHECK(refusal(solids::box({0, 0, 0}, {1, 1, 1}), density, ExitCode::invalid).find("density") !=
              std::string::npos);
}
