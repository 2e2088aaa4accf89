// SPDX-License-Identifier: GPL-3.0-or-later
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "import_test.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace import_test;
using voxshell::ImportOptions;

namespace {

const ImportOptions millimetres{1e-3, false};

Bytes binary_stl(const std::vector<std::array<Float3, 3>> &triangles, const std::string &header = "")
{
    Bytes out(80, 0);
    std::memcpy(out.data(), header.data(), header.size());
    append(out, static_cast<std::uint32_t>(triangles.size()));
    for (const auto &triangle : triangles) {
        append(out, Float3{0, 0, 0});
        append(out, triangle);
        append(out, std::uint16_t{0});
    }
    return out;
}

std::vector<std::array<Float3, 3>> cube()
{
    std::vector<std::array<Float3, 3>> out;
    for (std::size_t i = 0; i < cube_indices.size(); i += 3)
        out.push_back({cube_points[cube_indices[i]], cube_points[cube_indices[i + 1]],
                       cube_points[cube_indices[i + 2]]});
    return out;
}

const std::string one_facet =
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 1 0\n"
    " endloop\nendfacet\n";

} // namespace

TEST_CASE("a binary cube comes in metres with shared vertices")
{
    const Folder folder;
    const auto scene = voxshell::import_scene(folder.write("cube.stl", binary_stl(cube())), millimetres);
    REQUIRE(scene.meshes.size() == 1);
    CHECK(scene.name == "cube");
    CHECK(scene.meshes[0].vertices.size() == 8);
    CHECK(scene.meshes[0].triangles.size() == 12);
    CHECK(scene.instances.size() == 1);
    CHECK(scene.instances[0].name == "/cube");
    CHECK(scene.warnings.empty());
    CHECK(volume(voxshell::flatten(scene)) == doctest::Approx(1e-9).epsilon(1e-12));
}

TEST_CASE("size decides, not the word solid")
{
    const Folder folder;
    const auto scene =
        voxshell::import_scene(folder.write("a.STL", binary_stl(cube(), "solid cube")), millimetres);
    CHECK(scene.meshes[0].triangles.size() == 12);
}

TEST_CASE("minus zero is zero")
{
    const Folder folder;
    const auto path = folder.write("a.stl", binary_stl({{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
                                                        {{{-0.0f, 0, -0.0f}, {0, 1, 0}, {-1, 0, 0}}}}));
    CHECK(voxshell::import_scene(path, millimetres).meshes[0].vertices.size() == 4);
}

TEST_CASE("degenerate triangles stay")
{
    const Folder folder;
    const auto path = folder.write("a.stl", binary_stl({{{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}}}));
    const auto scene = voxshell::import_scene(path, millimetres);
    CHECK(scene.meshes[0].triangles.size() == 1);
    CHECK(scene.meshes[0].vertices.size() == 1);
}

TEST_CASE("a unit is required and must be a length")
{
    const Folder folder;
    const auto path = folder.write("a.stl", binary_stl(cube()));
    CHECK(refusal(path) == "1: STL has no unit: say --unit mm|cm|m|in");
    for (const double unit : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::nan("")})
        CHECK(refusal(path, {unit, false}).starts_with("1: "));
}

TEST_CASE("z up turns a part, its volume keeps its sign")
{
    const Folder folder;
    const auto path = folder.write("a.stl", binary_stl({{{{0, 0, 1}, {2, 0, 0}, {0, 3, 0}}}}));
    const auto flat = voxshell::flatten(voxshell::import_scene(path, {1.0, true}));
    CHECK(flat.vertices[0] == voxshell::Point{0, 1, 0});
    CHECK(flat.vertices[1] == voxshell::Point{2, 0, 0});
    CHECK(flat.vertices[2] == voxshell::Point{0, 0, -3});
    const auto cube_path = folder.write("b.stl", binary_stl(cube()));
    CHECK(volume(voxshell::flatten(voxshell::import_scene(cube_path, {1.0, true}))) == doctest::Approx(1));
}

TEST_CASE("broken binary files are told apart in one line")
{
    const Folder folder;
    Bytes good = binary_stl(cube());
    CHECK(good.size() == 684);
    Bytes bad = good;
    std::memset(bad.data() + 80, 0xff, 4);
    CHECK(refusal(folder.write("a.stl", bad), millimetres) ==
          "3: triangle count 4294967295 needs 214748364834 bytes, the file has 684");
    bad = good;
    bad.pop_back();
    CHECK(refusal(folder.write("a.stl", bad), millimetres) ==
          "3: triangle count 12 needs 684 bytes, the file has 683");
    CHECK(refusal(folder.write("a.stl", Bytes{}), millimetres) == "3: the file is empty");
    CHECK(contains(refusal(folder.write("a.stl", Bytes(50, 0)), millimetres), "at least 84 bytes"));
    CHECK(contains(refusal(folder.write("a.stl", binary_stl({})), millimetres), "0 triangles"));
    for (const float x : {std::numeric_limits<float>::infinity(), std::nanf("")}) {
        bad = good;
        std::memcpy(bad.data() + 84 + 50 * 3 + 12 + 16, &x, sizeof x);
        CHECK(refusal(folder.write("a.stl", bad), millimetres) ==
              "3: triangle 3: coordinate y of corner 1 is not a finite number");
    }
    CHECK(contains(refusal(folder.write("a.stl", "<html>not found</html>"), millimetres),
                   "does not begin with 'solid'"));
}

TEST_CASE("bytes after a binary file are ignored with a warning")
{
    const Folder folder;
    Bytes longer = binary_stl(cube());
    longer.resize(longer.size() + 7);
    const auto scene = voxshell::import_scene(folder.write("a.stl", longer), millimetres);
    CHECK(scene.meshes[0].triangles.size() == 12);
    CHECK(warns(scene, "stl-trailing-bytes"));
}

TEST_CASE("ASCII as programs write it")
{
    const Folder folder;
    const auto triangles = [&](const std::string &text) {
        const auto scene = voxshell::import_scene(folder.write("a.stl", text), millimetres);
        return scene.meshes[0].triangles.size();
    };
    CHECK(triangles("solid a\n" + one_facet + one_facet + "endsolid a\n") == 2);
    CHECK(triangles("solid\n" + one_facet + "endsolid") == 1);
    CHECK(triangles("\xef\xbb\xbf\n  solid a\n" + one_facet + "endsolid a\n") == 1);
    CHECK(triangles("solid a\n" + one_facet + "endsolid a\nsolid b\n" + one_facet +
                    "endsolid b\nsolid\nendsolid\n") == 2);
    CHECK(triangles("solid \xe6\x9c\x88 facet of the moon\n" + one_facet + "endsolid facet\n") == 1);
    CHECK(triangles("solid one line " + one_facet + "endsolid") == 1);
    CHECK(triangles("solid a\n" + one_facet + "endsolid a\n" + std::string(3, '\0')) == 1);
    std::string crlf, upper = "SOLID A\n", tabs = "solid a\n";
    for (const char c : "solid a\n" + one_facet + "endsolid\n")
        crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    for (const char c : one_facet + "EndSolid A\n")
        upper += static_cast<char>(c >= 'a' && c <= 'z' ? c - 32 : c);
    for (const char c : one_facet + "endsolid\n") tabs += c == ' ' ? '\t' : c;
    CHECK(triangles(crlf) == 1);
    CHECK(triangles(upper) == 1);
    CHECK(triangles(tabs) == 1);
    CHECK(triangles("solid a\nfacet\nouter loop\nvertex +1 2. .5\nvertex 1e-3 -2E+002 0\nvertex 1 1 "
                    "1e-999\nendloop\nendfacet\nendsolid") == 1);
    CHECK(triangles("solid a\nfacet normal nan nan -nan(ind)\nouter loop\nvertex 1 2 3\nvertex 2 2 3\nvertex "
                    "1 1 3\nend loop\nend facet\nend solid a") == 1);
    CHECK(triangles("solid a\nfacet normal\nouter loop\nvertex 1 2 3\nvertex 2 2 3\nvertex 1 1 "
                    "3\nendloop\nendfacet\nendsolid") == 1);

    const auto scene = voxshell::import_scene(folder.write("a.stl", "solid arm\n" + one_facet), millimetres);
    CHECK(warns(scene, "stl-no-endsolid"));
    CHECK(scene.meshes[0].name == "arm");
    CHECK(scene.meshes[0].vertices[1] == voxshell::Point{1e-3, 0, 0});
}

TEST_CASE("the decimal point does not depend on the locale")
{
    const Folder folder;
    const char *old = std::setlocale(LC_ALL, "de_DE.UTF-8"); // where it is not installed, nothing is shown
    const auto path =
        folder.write("a.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0.5 0 0\nvertex 1 0 0\n"
                              "vertex 0 1 0\nendloop\nendfacet\nendsolid");
    CHECK(voxshell::import_scene(path, {1.0, false}).meshes[0].vertices[0][0] == 0.5);
    if (old) std::setlocale(LC_ALL, "C");
}

TEST_CASE("wrong ASCII is refused with its line")
{
    const Folder folder;
    const auto told = [&](const std::string &text) {
        return refusal(folder.write("a.stl", text), millimetres);
    };
    const std::string head = "solid a\nfacet normal 0 0 1\nouter loop\n";
    CHECK(told(head + "vertex 1 blah 2\n") == "3: line 4: 'blah' is not a number");
    CHECK(told(head + "vertex 1 nan 2\n") == "3: line 4: coordinate 'nan' is not finite");
    CHECK(told(head + "vertex 1 2 -inf\n") == "3: line 4: coordinate '-inf' is not finite");
    CHECK(told(head + "vertex 1 2 1e400\n") == "3: line 4: coordinate '1e400' is not finite");
    CHECK(told(head + "vertex 1,5 2 3\n") == "3: line 4: '1,5' is not a number");
    CHECK(told(head + "vertex 1 2 0x10\n") == "3: line 4: '0x10' is not a number");
    CHECK(told(head + "vertex 1 2 + 3\n") == "3: line 4: '+' is not a number");
    CHECK(contains(told(head + "vertex 1 2\nvertex 1 2 3"), "line 5: 'vertex' is not a number"));
    CHECK(contains(told(head + "vertex 1 2 3\n"), "the file ends where 'vertex' should follow"));
    CHECK(contains(told(head + "vertex 1 2 3\nvertex 1 2 3\nvertex 1 2 3\nvertex 1 2 3\n"),
                   "more than three corners"));
    CHECK(contains(told("solid a\nendsolid a\n"), "without a facet"));
    CHECK(contains(told("solid a\n" + one_facet + "blah\n"),
                   "'facet' or 'endsolid' should stand where 'blah' does"));
    CHECK(contains(told("solid a\n" + one_facet + "endsolid a\n" + one_facet),
                   "'solid' should stand where 'facet' does"));
    CHECK(contains(told("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 3\n"),
                   "git lfs pull"));
    for (std::size_t n = 1; n < one_facet.size() - 2; ++n)
        CHECK(told("solid a\n" + one_facet.substr(0, n)) != "converted");
}

TEST_CASE("endings and files that cannot be read")
{
    const Folder folder;
    CHECK(refusal(folder.write("a.drc", "DRACO"), {}).starts_with("5: the ending '.drc'"));
    CHECK(refusal(folder.path() / "none.stl", millimetres).starts_with("2: cannot read: "));
    std::filesystem::create_directory(folder.path() / "folder.stl");
    CHECK(refusal(folder.path() / "folder.stl", millimetres) == "2: cannot read: not a regular file");
}
