// SPDX-License-Identifier: GPL-3.0-or-later
// An assembly stands where its scene stood: part, shape, turn and move put each vertex back to its place.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "batch/assembly.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <random>

using namespace voxshell;

namespace {

Mesh tetrahedron(const std::string &name, double size)
{
    return {name,
            {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, 2 * size}},
            {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

std::array<double, 9> turn(std::mt19937 &dice)
{
    std::normal_distribution<double> normal;
    double q[4], n = 0;
    for (double &x : q) {
        x = normal(dice);
        n += x * x;
    }
    for (double &x : q) x /= std::sqrt(n);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
}

/// turn * diagonal, at a place; as floats, as files have them.
std::array<double, 12> pose(const std::array<double, 9> &r, const Point &scale, const Point &at)
{
    std::array<double, 12> m;
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t k = 0; k < 3; ++k) m[4 * i + k] = static_cast<float>(r[3 * i + k] * scale[k]);
        m[4 * i + 3] = at[i];
    }
    return m;
}

/// Farthest that a vertex of the assembly is from where the scene has it [m].
double farthest(const Scene &scene, const Assembly &assembly)
{
    const Mesh flat = flatten(scene);
    double most = 0;
    std::size_t v = 0;
    for (const AssemblyInstance &instance : assembly.instances) {
        const Scene part = part_scene(scene, assembly.parts[instance.part]);
        const auto &[w, x, y, z] = instance.orientation;
        CHECK(w >= 0);
        CHECK(w * w + x * x + y * y + z * z == doctest::Approx(1).epsilon(1e-14));
        for (const Point &p : part.meshes[0].vertices) {
            const Point r{
                (1 - 2 * (y * y + z * z)) * p[0] + 2 * (x * y - w * z) * p[1] + 2 * (x * z + w * y) * p[2],
                2 * (x * y + w * z) * p[0] + (1 - 2 * (x * x + z * z)) * p[1] + 2 * (y * z - w * x) * p[2],
                2 * (x * z - w * y) * p[0] + 2 * (y * z + w * x) * p[1] + (1 - 2 * (x * x + y * y)) * p[2]};
            double off = 0;
            for (std::size_t a = 0; a < 3; ++a) {
                const double d = r[a] + instance.position[a] - flat.vertices[v][a];
                off += d * d;
            }
            most = std::max(most, std::sqrt(off));
            ++v;
        }
    }
    CHECK(v == flat.vertices.size());
    return most;
}

} // namespace

TEST_CASE("turned and moved occurrences are one part, put back to where they stood")
{
    Scene scene;
    scene.name = "robot";
    scene.meshes = {tetrahedron("jaw", 1), tetrahedron("jaw again", 1), tetrahedron("jaw", 2)};
    std::mt19937 dice(1);
    std::uniform_real_distribution<double> anywhere(-5, 5);
    for (int n = 0; n < 40; ++n)
        scene.instances.push_back(
            {"/a" + std::to_string(n), static_cast<std::uint32_t>(n % 3),
             pose(turn(dice), {1, 1, 1}, {anywhere(dice), anywhere(dice), anywhere(dice)})});
    const Assembly assembly = assemble(scene);
    REQUIRE(assembly.parts.size() == 2); // the first two meshes are the same bytes
    CHECK(assembly.parts[0].name == "jaw");
    CHECK(assembly.parts[1].name == "jaw-2");
    CHECK(assembly.parts[0].instances == 27);
    CHECK(assembly.parts[0].shape == std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1});
    const double far = farthest(scene, assembly);
    CHECK(far <= assembly.pose_error + 1e-14);
    CHECK(assembly.pose_error < 4e-6); // four metres in floats
}

TEST_CASE("scaled, stretched and mirrored occurrences are parts of their own, shared where alike")
{
    Scene scene;
    scene.name = "kit";
    scene.meshes = {tetrahedron("rib", 1)};
    std::mt19937 dice(2);
    const Point scales[] = {{0.001, 0.001, 0.001}, {1, 2, 0.5}, {-1, 1, 1}, {-25.4, -25.4, -25.4}};
    for (int n = 0; n < 20; ++n)
        scene.instances.push_back(
            {"/b" + std::to_string(n), 0, pose(turn(dice), scales[n % 4], {0.1 * n, 0, 0})});
    const Assembly assembly = assemble(scene);
    CHECK(assembly.parts.size() == 4);
    for (const AssemblyPart &part : assembly.parts) CHECK(part.instances == 5);
    CHECK(assembly.parts[0].shape[0] == 0.001);
    CHECK(assembly.parts[3].shape[0] == -25.4);
    CHECK(farthest(scene, assembly) <= assembly.pose_error + 1e-13);
    CHECK(assembly.pose_error < 1e-4); // 51 m at six digits
    // A mirrored part's outside is still outside: the flat scene says which way its triangles go.
    const Mesh flat = flatten(scene);
    const Scene mirrored = part_scene(scene, assembly.parts[2]);
    CHECK(mirrored.meshes[0].triangles[0] != scene.meshes[0].triangles[0]);
    CHECK(flat.triangles[8][1] - 8 == mirrored.meshes[0].triangles[0][1]);
}

TEST_CASE("a flat transform is refused with its node")
{
    Scene scene;
    scene.meshes = {tetrahedron("sheet", 1)};
    scene.instances.push_back({"/floor/sheet", 0, {1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0}});
    CHECK_THROWS_WITH_AS(assemble(scene), doctest::Contains("/floor/sheet"), Failure);
}

TEST_CASE("names that no file system takes become names")
{
    CHECK(file_name("a/b") == "a_b");
    CHECK(file_name("..") == "_.");
    CHECK(file_name("") == "part");
    CHECK(file_name("Schlüssel 7\n") == "Schlüssel 7_");
    CHECK(file_name(std::string(300, 'x')).size() <= 123);
    Scene scene;
    scene.meshes = {tetrahedron("Bolt", 1), tetrahedron("bolt", 2), tetrahedron("bolt-2", 3)};
    for (std::uint32_t n = 0; n < 3; ++n) scene.instances.push_back({"/n", n});
    const Assembly assembly = assemble(scene);
    CHECK(assembly.parts[0].name == "Bolt");
    CHECK(assembly.parts[1].name == "bolt-2");
    CHECK(assembly.parts[2].name == "bolt-2-2");
}

TEST_CASE("the solids of an STL are parts; together they are what the file is")
{
    Scene scene;
    scene.name = "plate";
    scene.meshes = {tetrahedron("a", 1)};
    scene.instances = {{"/plate", 0}};
    CHECK(split_solids(scene).meshes.size() == 1);
    Mesh &mesh = scene.meshes[0];
    for (const Point &p : tetrahedron("", 1).vertices) mesh.vertices.push_back({p[0] + 3, p[1], p[2]});
    for (Triangle t : tetrahedron("", 1).triangles) mesh.triangles.push_back({t[0] + 4, t[1] + 4, t[2] + 4});
    mesh.triangles.push_back({0, 5, 6}); // shares a vertex with the first
    mesh.solids = {{"a", 0}, {"", 4}};
    const Scene split = split_solids(scene);
    REQUIRE(split.meshes.size() == 2);
    CHECK(split.meshes[0].vertices.size() == 4);
    CHECK(split.meshes[1].vertices.size() == 5);
    CHECK(split.meshes[1].name == "solid 2");
    CHECK(split.instances[1].name == "/plate/solid 2");
    const Mesh before = flatten(scene), after = flatten(split);
    REQUIRE(after.triangles.size() == before.triangles.size());
    for (std::size_t t = 0; t < before.triangles.size(); ++t)
        for (std::size_t c = 0; c < 3; ++c)
            CHECK(after.vertices[after.triangles[t][c]] == before.vertices[before.triangles[t][c]]);
    CHECK(assemble(split).parts.size() == 2);
}
