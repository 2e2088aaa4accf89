// SPDX-License-Identifier: GPL-3.0-or-later
// What glTF can say about geometry, each in the smallest document that says it.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "import_test.hpp"

#include <doctest/doctest.h>

using namespace import_test;
using voxshell::flatten;
using voxshell::Mesh;
using voxshell::Scene;

namespace {

Scene import_glb(const Gltf &gltf)
{
    const Folder folder;
    return voxshell::import_scene(folder.write("part.glb", gltf.glb()), {});
}

Mesh flat(const Gltf &gltf)
{
    return flatten(import_glb(gltf));
}

Gltf with_cube(Json node)
{
    Gltf gltf;
    node["mesh"] = gltf.cube();
    gltf.root(std::move(node));
    return gltf;
}

} // namespace

TEST_CASE("a cube in a GLB")
{
    const Scene scene = import_glb(with_cube({{"name", "box"}}));
    CHECK(scene.name == "part");
    CHECK(scene.warnings.empty());
    REQUIRE(scene.instances.size() == 1);
    CHECK(scene.instances[0].name == "/box");
    CHECK(flatten(scene).triangles.size() == 12);
    CHECK(volume(flatten(scene)) == doctest::Approx(1));
}

TEST_CASE("data URIs and files beside the document")
{
    const Folder folder;
    const Gltf gltf = with_cube({});
    const auto volume_of = [&](const std::string &uri) {
        return volume(flatten(voxshell::import_scene(folder.write("a.gltf", gltf.text(uri)), {})));
    };
    CHECK(volume_of(gltf.data_uri()) == doctest::Approx(1));
    folder.write("the box.bin", gltf.bin);
    CHECK(volume_of("the%20box.bin") == doctest::Approx(1));
    CHECK(volume_of("the box.bin") == doctest::Approx(1));
    CHECK(volume_of("./the%20box.bin") == doctest::Approx(1));
    std::filesystem::create_directory(folder.path() / "sub");
    folder.write("sub/b.bin", gltf.bin);
    CHECK(volume_of("sub/b.bin") == doctest::Approx(1));
    Bytes longer = gltf.bin;
    longer.resize(longer.size() + 100);
    folder.write("long.bin", longer);
    CHECK(volume_of("long.bin") == doctest::Approx(1));
    std::filesystem::create_symlink("long.bin", folder.path() / "link.bin");
    CHECK(volume_of("link.bin") == doctest::Approx(1));
}

TEST_CASE("the source hash covers the buffers that were read")
{
    const Folder folder;
    Gltf gltf = with_cube({});
    const auto path = folder.write("a.gltf", gltf.text("a.bin"));
    folder.write("a.bin", gltf.bin);
    const auto first = voxshell::import_scene(path, {}).source_hash;
    CHECK(voxshell::import_scene(path, {}).source_hash == first);
    gltf.bin.push_back(7); // not even used
    folder.write("a.bin", gltf.bin);
    CHECK(voxshell::import_scene(path, {}).source_hash != first);
}

TEST_CASE("matrix and TRS compose down the graph")
{
    Gltf gltf;
    const std::size_t cube = gltf.cube();
    const double s = std::sqrt(0.5);
    // 90 degrees about z: x -> y.
    gltf.add("nodes", {{"mesh", cube}, {"translation", {1, 0, 0}}, {"scale", {2, 1, 1}}, {"name", "jaw"}});
    gltf.add("nodes", {{"children", {0}}, {"rotation", {0, 0, s, s}}, {"name", "gripper"}});
    gltf.root({{"children", {1}},
               {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1}},
               {"name", "arm"}});
    const Scene scene = import_glb(gltf);
    REQUIRE(scene.instances.size() == 1);
    CHECK(scene.instances[0].name == "/arm/gripper/jaw");
    const Box b = box(flatten(scene));
    CHECK(b.low[0] == doctest::Approx(9));
    CHECK(b.high[0] == doctest::Approx(10));
    CHECK(b.low[1] == doctest::Approx(21));
    CHECK(b.high[1] == doctest::Approx(23));
    CHECK(b.low[2] == doctest::Approx(30));
    CHECK(volume(flatten(scene)) == doctest::Approx(2));
}

TEST_CASE("mirrored instances keep their outside outside")
{
    CHECK(volume(flat(with_cube({{"scale", {-1, 1, 1}}}))) == doctest::Approx(1));
    CHECK(volume(flat(with_cube({{"scale", {-1, -2, 1}}}))) == doctest::Approx(2));
    CHECK(volume(flat(with_cube({{"scale", {-1, -1, -3}}}))) == doctest::Approx(3));
    CHECK(volume(flat(with_cube({{"matrix", {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}}))) ==
          doctest::Approx(1));
    Gltf gltf; // mirrored twice
    const std::size_t cube = gltf.cube();
    gltf.add("nodes", {{"mesh", cube}, {"scale", {1, -1, 1}}});
    gltf.root({{"children", {0}}, {"scale", {1, 1, -1}}});
    CHECK(volume(flat(gltf)) == doctest::Approx(1));
    const Folder folder; // and turned upright
    const auto path = folder.write("a.glb", with_cube({{"scale", {-1, 1, 1}}}).glb());
    CHECK(volume(flatten(voxshell::import_scene(path, {{}, true}))) == doctest::Approx(1));
}

TEST_CASE("instances share meshes and have unique names")
{
    Gltf gltf;
    const std::size_t cube = gltf.cube();
    for (int i = 0; i < 3; ++i) gltf.root({{"mesh", cube}, {"name", "bolt"}, {"translation", {2 * i, 0, 0}}});
    gltf.root({{"mesh", cube}, {"name", "bolt#2"}});
    gltf.root({{"mesh", cube}, {"name", "a/b\n"}});
    const Scene scene = import_glb(gltf);
    CHECK(scene.meshes.size() == 1);
    REQUIRE(scene.instances.size() == 5);
    CHECK(scene.instances[0].name == "/bolt");
    CHECK(scene.instances[1].name == "/bolt#2");
    CHECK(scene.instances[2].name == "/bolt#3");
    CHECK(scene.instances[3].name == "/bolt#2#2");
    CHECK(scene.instances[4].name == "/a_b_");
    CHECK(flatten(scene).triangles.size() == 60);
}

TEST_CASE("which scene")
{
    Gltf gltf;
    const std::size_t cube = gltf.cube();
    gltf.root({{"mesh", cube}});
    gltf.add("nodes", {{"mesh", cube}, {"scale", {2, 2, 2}}});
    gltf.add("scenes", {{"nodes", {1}}});
    CHECK(volume(flat(gltf)) == doctest::Approx(1));
    gltf.json["scene"] = 1;
    CHECK(volume(flat(gltf)) == doctest::Approx(8));
    gltf.json.erase("scene");
    CHECK(volume(flat(gltf)) == doctest::Approx(1));
    CHECK(warns(import_glb(gltf), "gltf-no-default-scene"));
    gltf.json.erase("scenes");
    CHECK(volume(flat(gltf)) == doctest::Approx(9));
    CHECK(warns(import_glb(gltf), "gltf-no-scene"));
}

TEST_CASE("strips alternate, fans turn, indexed or not")
{
    // A unit square in four corners, seen from +z: strip 0 1 2 3 with 3 opposite 0, fan around.
    const std::vector<Float3> strip = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
    const std::vector<Float3> fan = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    for (const int mode : {5, 6})
        for (const bool indexed : {false, true}) {
            Gltf gltf;
            Json primitive = {{"attributes", {{"POSITION", gltf.positions(mode == 5 ? strip : fan)}}},
                              {"mode", mode}};
            if (indexed) primitive["indices"] = gltf.indices(std::vector<std::uint8_t>{0, 1, 2, 3});
            gltf.root({{"mesh", gltf.mesh(primitive)}});
            const Mesh mesh = flat(gltf);
            REQUIRE(mesh.triangles.size() == 2);
            double area = 0; // twice, signed along z
            for (const auto &t : mesh.triangles) {
                const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
                const double part = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
                CHECK(part > 0);
                area += part;
            }
            CHECK(area == doctest::Approx(2));
        }
}

TEST_CASE("points and lines are skipped and told, or refused alone")
{
    Gltf gltf = with_cube({});
    for (int mode = 0; mode < 4; ++mode)
        gltf.json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", mode}});
    const Scene scene = import_glb(gltf);
    CHECK(flatten(scene).triangles.size() == 12);
    CHECK(warns(scene, "gltf-points-or-lines"));
    CHECK(contains(scene.warnings[0].message, "4 primitives"));
    gltf.json["meshes"][0]["primitives"].erase(0);
    const Folder folder;
    CHECK(refusal(folder.write("a.glb", gltf.glb())) ==
          "3: no triangles reachable from the scene: only points or lines");
}

TEST_CASE("indices of every size")
{
    const auto volume_with = [](auto zero) {
        Gltf gltf;
        std::vector<decltype(zero)> indices;
        for (const auto i : cube_indices) indices.push_back(static_cast<decltype(zero)>(i));
        const std::size_t p = gltf.positions(cube_points), i = gltf.indices(indices);
        gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}})}});
        return volume(flat(gltf));
    };
    CHECK(volume_with(std::uint8_t{}) == doctest::Approx(1));
    CHECK(volume_with(std::uint16_t{}) == doctest::Approx(1));
    CHECK(volume_with(std::uint32_t{}) == doctest::Approx(1));
}

TEST_CASE("no indices: every three vertices")
{
    Gltf gltf;
    std::vector<Float3> corners;
    for (const auto i : cube_indices) corners.push_back(cube_points[i]);
    gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", gltf.positions(corners)}}}})}});
    CHECK(volume(flat(gltf)) == doctest::Approx(1));
}

TEST_CASE("interleaved vertices")
{
    Gltf gltf;
    Bytes bytes;
    for (const Float3 &p : cube_points) {
        append(bytes, Float3{9, 9, 9});
        append(bytes, p);
    }
    const std::size_t view = gltf.view(bytes), indices = gltf.indices(cube_indices);
    gltf.json["bufferViews"][view]["byteStride"] = 24;
    const std::size_t normals = gltf.accessor(view, 5126, "VEC3", 8),
                      positions = gltf.accessor(view, 5126, "VEC3", 8);
    gltf.json["accessors"][positions]["byteOffset"] = 12;
    gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                                   {"indices", indices}})}});
    CHECK(volume(flat(gltf)) == doctest::Approx(1));
}

TEST_CASE("quantised positions, normalised or not")
{
    const auto extent = [](int component, bool normalized, auto low, auto high) {
        Gltf gltf;
        Bytes bytes;
        for (const Float3 &p : cube_points) {
            for (const float x : p) append(bytes, x == 0 ? low : high);
            while (bytes.size() % 4) bytes.push_back(0);
        }
        const std::size_t view = gltf.view(bytes), indices = gltf.indices(cube_indices);
        gltf.json["bufferViews"][view]["byteStride"] = bytes.size() / 8;
        const std::size_t positions = gltf.accessor(view, component, "VEC3", 8);
        gltf.json["accessors"][positions]["normalized"] = normalized;
        gltf.use("KHR_mesh_quantization", true);
        gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
        return box(flat(gltf));
    };
    using I8 = std::int8_t;
    using U8 = std::uint8_t;
    using I16 = std::int16_t;
    using U16 = std::uint16_t;
    CHECK(extent(5120, true, I8{-127}, I8{127}).size(0) == doctest::Approx(2));
    CHECK(extent(5120, true, I8{-128}, I8{127}).low[1] == -1);
    CHECK(extent(5120, false, I8{-128}, I8{127}).low[1] == -128);
    CHECK(extent(5121, true, U8{0}, U8{255}).high[2] == 1);
    CHECK(extent(5121, false, U8{3}, U8{255}).low[2] == 3);
    CHECK(extent(5122, true, I16{-32768}, I16{32767}).size(0) == doctest::Approx(2));
    CHECK(extent(5122, false, I16{-32768}, I16{32767}).size(0) == doctest::Approx(65535));
    CHECK(extent(5123, true, U16{0}, U16{65535}).high[0] == 1);
    CHECK(extent(5123, false, U16{1}, U16{65535}).size(0) == doctest::Approx(65534));
}

TEST_CASE("sparse accessors, with and without a bufferView")
{
    Gltf gltf;
    const std::size_t positions = gltf.positions(cube_points), indices = gltf.indices(cube_indices);
    const std::size_t where = gltf.view(bytes_of(std::vector<std::uint8_t>{4, 5, 6, 7}));
    const std::size_t what =
        gltf.view(bytes_of(std::vector<Float3>{{0, 0, 3}, {1, 0, 3}, {1, 1, 3}, {0, 1, 3}}));
    const Json sparse = {{"count", 4},
                         {"indices", {{"bufferView", where}, {"componentType", 5121}}},
                         {"values", {{"bufferView", what}}}};
    gltf.json["accessors"][positions]["sparse"] = sparse;
    gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
    CHECK(volume(flat(gltf)) == doctest::Approx(3));
    gltf.json["accessors"][positions].erase("bufferView"); // then the lower four corners are at the origin
    CHECK(volume(flat(gltf)) == doctest::Approx(1));
}

TEST_CASE("an accessor without bufferView is zeros, for indices too")
{
    Gltf gltf = with_cube({});
    gltf.json["accessors"][1].erase("bufferView");
    const Mesh mesh = flat(gltf);
    CHECK(mesh.triangles.size() == 12);
    CHECK(mesh.vertices.size() == 1);
}

TEST_CASE("only the vertices that triangles use")
{
    Gltf gltf;
    std::vector<Float3> points = cube_points;
    points.push_back({1e9f, 0, 0});
    const std::size_t p = gltf.positions(points), i = gltf.indices(cube_indices);
    gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}})}});
    CHECK(box(flat(gltf)).high[0] == 1);
    // Two primitives on one accessor share its vertices.
    gltf.json["meshes"][0]["primitives"].push_back(gltf.json["meshes"][0]["primitives"][0]);
    CHECK(flat(gltf).vertices.size() == 8);
}

TEST_CASE("GPU instancing")
{
    Gltf gltf = with_cube({{"scale", {2, 2, 2}}, {"name", "bolts"}});
    const std::size_t t = gltf.positions({{0, 0, 0}, {10, 0, 0}, {20, 0, 0}});
    const std::size_t s = gltf.positions({{1, 1, 1}, {-1, 1, 1}, {3, 1, 1}});
    const std::size_t view =
        gltf.view(bytes_of(std::vector<std::int8_t>{0, 0, 0, 127, 0, 0, 127, 0, 90, 0, 0, 90}));
    const std::size_t r = gltf.accessor(view, 5120, "VEC4", 3);
    gltf.json["accessors"][r]["normalized"] = true;
    gltf.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", t}, {"ROTATION", r}, {"SCALE", s}, {"_ID", t}};
    gltf.use("EXT_mesh_gpu_instancing", true);
    const Scene scene = import_glb(gltf);
    CHECK(scene.meshes.size() == 1);
    REQUIRE(scene.instances.size() == 3);
    CHECK(scene.instances[1].name == "/bolts[1]");
    CHECK(volume(flatten(scene)) == doctest::Approx(8 * (1 + 1 + 3)));
    const Box b = box(flatten(scene));
    CHECK(b.low[0] == doctest::Approx(0));
    CHECK(b.high[0] == doctest::Approx(2 * (20 + 3)));
    // Turned by 90 degrees about x, y goes to z: the third spans z 0..2 and y -2..0.
    CHECK(b.low[1] == doctest::Approx(-2));

    gltf.json["nodes"][0].erase("mesh");
    gltf.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"_PRIVATE", 99}};
    gltf.root({{"mesh", 0}});
    CHECK(warns(import_glb(gltf), "gltf-instancing-without-mesh"));
    CHECK(import_glb(gltf).instances.size() == 1);
}

TEST_CASE("what is not geometry does not stand in the way")
{
    Gltf gltf = with_cube({{"camera", 0},
                           {"skin", 0},
                           {"extras", {{"a", {1, 2}}}},
                           {"extensions", {{"KITTYCAD_x", {{"y", 1}}}}}});
    gltf.add("cameras", {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}}}});
    gltf.add("skins", {{"joints", {0}}});
    gltf.add("images", {{"uri", "../not/there.png"}});
    gltf.add("textures", {{"source", 0}});
    gltf.add("materials", {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}});
    gltf.add("animations", {{"channels", Json::array()}, {"samplers", Json::array()}});
    gltf.json["meshes"][0]["primitives"][0]["material"] = 0;
    gltf.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", 0}}};
    gltf.json["meshes"][0]["weights"] = {0.5};
    gltf.use("KHR_texture_basisu", true);
    gltf.use("KHR_materials_unlit", true);
    gltf.use("UNKNOWN_optional", false);
    gltf.json["buffers"] = {{{"byteLength", gltf.bin.size()}},
                            {{"byteLength", 5}, {"uri", "not-needed.bin"}}};
    const Scene scene = import_glb(gltf);
    CHECK(volume(flatten(scene)) == doctest::Approx(1));
    for (const char *code : {"gltf-skin", "gltf-morph-targets", "gltf-animations"}) CHECK(warns(scene, code));
}

TEST_CASE("integers may be written as 3.0")
{
    Gltf gltf = with_cube({});
    gltf.json["nodes"][0]["mesh"] = 0.0;
    gltf.json["accessors"][0]["count"] = 8.0;
    gltf.json["accessors"][0]["componentType"] = 5126.0;
    CHECK(volume(flat(gltf)) == doctest::Approx(1));
}

TEST_CASE("a chain of 100 000 nodes")
{
    Gltf gltf;
    const std::size_t cube = gltf.cube();
    Json nodes = Json::array();
    for (int i = 0; i < 100000; ++i)
        nodes.push_back({{"children", {i + 1}}, {"mesh", cube}, {"translation", {0, 1, 0}}});
    nodes.push_back({{"mesh", cube}});
    gltf.json["nodes"] = nodes;
    gltf.json["scenes"] = {{{"nodes", {0}}}};
    const Scene scene = import_glb(gltf);
    CHECK(scene.instances.size() == 100001);
    CHECK(scene.instances.back().pose[7] == 100000);
    CHECK(scene.instances.back().name.size() < 300);
}

TEST_CASE("instances may not unfold without bound")
{
    Gltf gltf;
    std::vector<std::uint16_t> indices(30000, 0);
    const std::size_t p = gltf.positions(cube_points), i = gltf.indices(indices);
    const std::size_t mesh = gltf.mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}});
    for (int n = 0; n < 15000; ++n) gltf.root({{"mesh", mesh}});
    const Scene scene = import_glb(gltf);
    CHECK_THROWS_AS(flatten(scene), voxshell::Failure);
}
