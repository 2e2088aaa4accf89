// SPDX-License-Identifier: GPL-3.0-or-later
// Every prefix and every changed byte of small files: refused or converted, never worse. Meant for a build
// with sanitizers; a file is read into a vector of exactly its size.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "import_test.hpp"

#include <doctest/doctest.h>

using namespace import_test;

namespace {

/// Import, and unfold what comes out.
bool converts(const Folder &folder, const std::string &name, const Bytes &bytes)
{
    voxshell::ImportOptions options;
    if (name.ends_with("stl")) options.unit = 1e-3;
    try {
        voxshell::flatten(voxshell::import_scene(folder.write(name, bytes), options));
        return true;
    } catch (const voxshell::Failure &failure) {
        const int code = static_cast<int>(failure.code);
        CHECK((code == 3 || code == 5 || code == 2));
        return false;
    }
}

void sweep(const std::string &name, const Bytes &whole, std::size_t whole_from)
{
    const Folder folder;
    CHECK(converts(folder, name, whole));
    for (std::size_t n = 0; n < whole.size(); ++n) {
        const bool converted =
            converts(folder, name, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(n)));
        CAPTURE(n);
        CHECK((!converted || n >= whole_from));
    }
    for (std::size_t i = 0; i < whole.size(); ++i)
        for (const int value : {0, 1, 0x7f, 0xff, int{'"'}, int{'9'}, int{'-'}}) {
            Bytes changed = whole;
            changed[i] = static_cast<std::uint8_t>(value);
            converts(folder, name, changed);
        }
}

} // namespace

TEST_CASE("GLB")
{
    Gltf gltf;
    const std::size_t cube = gltf.cube();
    const std::size_t where = gltf.view(bytes_of(std::vector<std::uint8_t>{0, 7}));
    const std::size_t what = gltf.view(bytes_of(std::vector<Float3>{{0, 0, -1}, {0, 1, 2}}));
    gltf.json["accessors"][0]["sparse"] = {{"count", 2},
                                           {"indices", {{"bufferView", where}, {"componentType", 5121}}},
                                           {"values", {{"bufferView", what}}}};
    const std::size_t t = gltf.positions({{0, 0, 0}, {3, 0, 0}});
    gltf.add("nodes",
             {{"mesh", cube},
              {"rotation", {0, 0, 0, 1}},
              {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", t}}}}}}}});
    gltf.root({{"children", {0}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1}}});
    const Bytes bytes = gltf.glb();
    sweep("a.glb", bytes, bytes.size());
}

TEST_CASE("glTF with a data URI")
{
    Gltf gltf;
    gltf.root({{"mesh", gltf.mesh({{"attributes",
                                    {{"POSITION", gltf.positions({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}})}}}})}});
    const std::string text = gltf.text(gltf.data_uri());
    sweep("a.gltf", Bytes(text.begin(), text.end()), text.size());
}

TEST_CASE("binary STL")
{
    Bytes bytes(80, 's');
    append(bytes, std::uint32_t{3});
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 12; ++k) append(bytes, static_cast<float>(i * k));
        append(bytes, std::uint16_t{0});
    }
    sweep("a.stl", bytes, bytes.size());
}

TEST_CASE("ASCII STL")
{
    const std::string solid =
        "solid name\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e0 0 0\nvertex 0 1.5 0\n"
        "endloop\nendfacet\n";
    const std::string text = solid + "endsolid name\n" + solid + "endsolid";
    // After the first facet a cut file gives a warning: what is there is whole.
    sweep("a.stl", Bytes(text.begin(), text.end()), solid.size() - 1);
}
