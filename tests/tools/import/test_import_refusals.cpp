// SPDX-License-Identifier: GPL-3.0-or-later
// glTF that must be refused: each case breaks one thing of a document that converts.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "import_test.hpp"

#include <doctest/doctest.h>

#include <limits>

using namespace import_test;

namespace {

Gltf good()
{
    Gltf gltf;
    gltf.root({{"mesh", gltf.cube()}});
    return gltf;
}

std::string told(const Gltf &gltf)
{
    const Folder folder;
    return refusal(folder.write("a.glb", gltf.glb()));
}

struct Broken {
    const char *what;
    void (*break_it)(Json &);
    const char *message;
};

Json &primitive(Json &j)
{
    return j["meshes"][0]["primitives"][0];
}

const Broken broken[] = {
    {"asset", [](Json &j) { j.erase("asset"); }, "3: asset: missing"},
    {"asset version", [](Json &j) { j["asset"]["version"] = 2; }, "3: asset.version: not a string"},
    {"glTF 1.0", [](Json &j) { j["asset"]["version"] = "1.0"; }, "5: glTF version '1.0'"},
    {"min version", [](Json &j) { j["asset"]["minVersion"] = "2.1"; }, "5: needs a reader of glTF '2.1'"},
    {"nodes as object", [](Json &j) { j["nodes"] = Json::object(); }, "3: nodes: not an array"},
    {"samplers as object", [](Json &j) { j["samplers"] = Json::object(); }, "3: samplers: not an array"},
    {"node as number", [](Json &j) { j["nodes"][0] = 3; }, "3: nodes[0] is not an object"},
    {"scene", [](Json &j) { j["scene"] = 1; }, "3: scene: 1 does not exist, there are 1"},
    {"negative scene", [](Json &j) { j["scene"] = -1; }, "3: scene: -1 is out of range"},
    {"scene as text", [](Json &j) { j["scene"] = "0"; }, "3: scene: not a number"},
    {"scene's node", [](Json &j) { j["scenes"][0]["nodes"] = {7}; }, "3: scenes[0].nodes: 7 does not exist"},
    {"scene's node twice",
     [](Json &j) {
         j["scenes"][0]["nodes"] = {0, 0};
     },
     "0 is listed twice"},
    {"node's mesh", [](Json &j) { j["nodes"][0]["mesh"] = 1; }, "3: nodes[0].mesh: 1 does not exist"},
    {"fractional index", [](Json &j) { j["nodes"][0]["mesh"] = 0.5; }, "3: nodes[0].mesh: not an integer"},
    {"huge index", [](Json &j) { j["nodes"][0]["mesh"] = 4294967296; }, "out of range"},
    {"own child", [](Json &j) { j["nodes"][0]["children"] = {0}; }, "3: nodes[0] is its own ancestor"},
    {"loop",
     [](Json &j) {
         j["nodes"] = {{{"children", {1}}}, {{"children", {2}}}, {{"children", {0}}}};
     },
     "is its own ancestor"},
    {"two parents",
     [](Json &j) {
         j["nodes"] = {{{"children", {2}}}, {{"children", {2}}}, {{"mesh", 0}}};
     },
     "3: nodes[2] has two parents, 0 and 1"},
    {"scene's node is a child",
     [](Json &j) {
         j["nodes"] = {{{"mesh", 0}}, {{"children", {0}}}};
     },
     "is not a root"},
    {"matrix of 15",
     [](Json &j) {
         j["nodes"][0]["matrix"] = Json::array({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0});
     },
     "15 numbers instead of 16"},
    {"projective matrix",
     [](Json &j) { j["nodes"][0]["matrix"] = {1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}; },
     "not affine"},
    {"matrix and translation",
     [](Json &j) {
         j["nodes"][0]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
         j["nodes"][0]["translation"] = {0, 0, 1};
     },
     "given beside a matrix"},
    {"text in translation",
     [](Json &j) {
         j["nodes"][0]["translation"] = {0, "1", 0};
     },
     "not an array of numbers"},
    {"rotation of length 2",
     [](Json &j) {
         j["nodes"][0]["rotation"] = {0, 0, 0, 2};
     },
     "not a unit quaternion"},
    {"rotation zero",
     [](Json &j) {
         j["nodes"][0]["rotation"] = {0, 0, 0, 0};
     },
     "not a unit quaternion"},
    {"overflowing transforms",
     [](Json &j) {
         j["nodes"] = {{{"children", {1}}, {"scale", {1e300, 1, 1}}},
                       {{"mesh", 0}, {"scale", {1e300, 1, 1}}}};
         j["scenes"][0]["nodes"] = {0};
     },
     "3: the transform of /node0/node1 is not finite"},
    {"primitives as object", [](Json &j) { j["meshes"][0]["primitives"] = Json::object(); },
     "3: meshes[0].primitives: not an array"},
    {"no primitives", [](Json &j) { j["meshes"][0]["primitives"] = Json::array(); },
     "3: meshes[0].primitives: empty"},
    {"mode 7", [](Json &j) { primitive(j)["mode"] = 7; }, "mode: 7 is out of range"},
    {"no attributes", [](Json &j) { primitive(j).erase("attributes"); }, "attributes: missing"},
    {"no POSITION",
     [](Json &j) {
         primitive(j)["attributes"] = {{"NORMAL", 0}};
     },
     "no POSITION attribute"},
    {"POSITION reference", [](Json &j) { primitive(j)["attributes"]["POSITION"] = 9; },
     "POSITION: 9 does not exist"},
    {"indices reference", [](Json &j) { primitive(j)["indices"] = 2; }, "indices: 2 does not exist"},
    {"indices of -7", [](Json &j) { primitive(j)["indices"] = -7; }, "indices: -7 is out of range"},
    {"indices as vectors", [](Json &j) { primitive(j)["indices"] = 0; },
     "indices: VEC3 of componentType 5126"},
    {"material reference", [](Json &j) { primitive(j)["material"] = 0; }, "material: 0 does not exist"},
    {"unequal counts",
     [](Json &j) {
         j["accessors"].push_back({{"componentType", 5126}, {"count", 7}, {"type", "VEC3"}});
         primitive(j)["attributes"]["NORMAL"] = 2;
     },
     "elements, another attribute has"},
    {"unequal morph target",
     [](Json &j) {
         j["accessors"].push_back({{"componentType", 5126}, {"count", 7}, {"type", "VEC3"}});
         primitive(j)["targets"] = {{{"POSITION", 2}}};
     },
     "elements, another attribute has"},
    {"VEC4 positions",
     [](Json &j) {
         j["accessors"][0]["type"] = "VEC4";
         j["accessors"][0]["count"] = 6;
     },
     "POSITION: VEC4"},
    {"short positions without the extension", [](Json &j) { j["accessors"][0]["componentType"] = 5122; },
     "without KHR_mesh_quantization"},
    {"uint positions", [](Json &j) { j["accessors"][0]["componentType"] = 5125; },
     "POSITION: VEC3 of componentType 5125"},
    {"double positions", [](Json &j) { j["accessors"][0]["componentType"] = 5130; },
     "componentType: 5130 is not allowed"},
    {"signed indices", [](Json &j) { j["accessors"][1]["componentType"] = 5122; },
     "indices: SCALAR of componentType 5122"},
    {"normalised floats", [](Json &j) { j["accessors"][0]["normalized"] = true; }, "normalised"},
    {"unknown type", [](Json &j) { j["accessors"][0]["type"] = "VEC5"; }, "type: 'VEC5' is not allowed"},
    {"count 0", [](Json &j) { j["accessors"][0]["count"] = 0; }, "count: 0 is out of range"},
    {"count -1", [](Json &j) { j["accessors"][0]["count"] = -1; }, "count: -1 is out of range"},
    {"count 2^40", [](Json &j) { j["accessors"][0]["count"] = 1099511627776; }, "do not fit bufferView"},
    {"count 1e300", [](Json &j) { j["accessors"][0]["count"] = 1e300; }, "out of range"},
    {"count missing", [](Json &j) { j["accessors"][0].erase("count"); }, "count: missing"},
    {"one too many", [](Json &j) { j["accessors"][0]["count"] = 9; },
     "9 elements of 12 bytes at offset 0 do not fit bufferView 0 of 96 bytes"},
    {"accessor's view", [](Json &j) { j["accessors"][0]["bufferView"] = 99; },
     "bufferView: 99 does not exist"},
    {"accessor's offset", [](Json &j) { j["accessors"][0]["byteOffset"] = 4; }, "do not fit"},
    {"accessor's offset 2^53", [](Json &j) { j["accessors"][0]["byteOffset"] = 9007199254740992; },
     "do not fit"},
    {"misaligned",
     [](Json &j) {
         j["accessors"][0]["byteOffset"] = 2;
         j["accessors"][0]["count"] = 7;
     },
     "not aligned"},
    {"offset without view",
     [](Json &j) {
         j["accessors"][0].erase("bufferView");
         j["accessors"][0]["byteOffset"] = 4;
     },
     "given without a bufferView"},
    {"too many zeros",
     [](Json &j) {
         for (int i = 0; i < 2; ++i) {
             j["accessors"][i].erase("bufferView");
             j["accessors"][i]["count"] = 3000000000;
         }
     },
     "5: "},
    {"view's buffer", [](Json &j) { j["bufferViews"][0]["buffer"] = 7; }, "buffer: 7 does not exist"},
    {"view's buffer missing", [](Json &j) { j["bufferViews"][0].erase("buffer"); }, "buffer: missing"},
    {"view of 1e9", [](Json &j) { j["bufferViews"][0]["byteLength"] = 1000000000; }, "do not fit buffer 0"},
    {"view of 0", [](Json &j) { j["bufferViews"][0]["byteLength"] = 0; }, "byteLength: 0 is out of range"},
    {"view's offset", [](Json &j) { j["bufferViews"][0]["byteOffset"] = 8589934592; }, "do not fit buffer 0"},
    {"stride 6", [](Json &j) { j["bufferViews"][0]["byteStride"] = 6; }, "not a multiple of 4"},
    {"stride 8 of 12", [](Json &j) { j["bufferViews"][0]["byteStride"] = 8; },
     "is less than an element's 12 bytes"},
    {"stride 256", [](Json &j) { j["bufferViews"][0]["byteStride"] = 256; },
     "byteStride: 256 is out of range"},
    {"strided indices",
     [](Json &j) {
         j["bufferViews"][1]["byteStride"] = 4;
         j["accessors"][1]["count"] = 18;
     },
     "indices in a bufferView with a byteStride"},
    {"buffer longer than its data",
     [](Json &j) {
         j["buffers"] = {{{"byteLength", 100000}}};
     },
     "buffers[0] declares 100000 bytes, there are 168"},
    {"unfinished triangle", [](Json &j) { j["accessors"][1]["count"] = 35; },
     "35 corners do not make triangles"},
    {"strip of two",
     [](Json &j) {
         j["accessors"][1]["count"] = 2;
         primitive(j)["mode"] = 5;
     },
     "2 corners do not make a strip or fan"},
    {"sparse without values",
     [](Json &j) {
         j["accessors"][0]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", 0}, {"componentType", 5121}}}};
     },
     "values: missing"},
    {"sparse of 1e9",
     [](Json &j) {
         j["accessors"][0]["sparse"] = {{"count", 1000000000},
                                        {"indices", {{"bufferView", 0}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", 0}}}};
     },
     "sparse.count: 1000000000 is out of range"},
    {"sparse index beyond",
     [](Json &j) { // the first two index bytes are those of the positions: 0 and 0
         j["accessors"][0]["sparse"] = {{"count", 2},
                                        {"indices", {{"bufferView", 0}, {"componentType", 5121}}},
                                        {"values", {{"bufferView", 0}}}};
     },
     "sparse: index 0 is not greater than the one before"},
    {"sparse float indices",
     [](Json &j) {
         j["accessors"][0]["sparse"] = {{"count", 1},
                                        {"indices", {{"bufferView", 0}, {"componentType", 5126}}},
                                        {"values", {{"bufferView", 0}}}};
     },
     "componentType: 5126 is not allowed"},
    {"required, not used", [](Json &j) { j["extensionsRequired"] = {"KHR_materials_unlit"}; },
     "extensionsUsed does not"},
    {"required, unknown", [](Json &j) { j["extensionsUsed"] = j["extensionsRequired"] = {"ACME_nurbs"}; },
     "5: requires the extension 'ACME_nurbs'"},
    {"extensions as object", [](Json &j) { j["extensionsUsed"] = Json::object(); },
     "extensionsUsed: not an array"},
    {"text for a number in a material",
     [](Json &j) {
         j["materials"] = {{{"normalTexture", {{"scale", "much"}}}}};
     },
     "materials[0].normalTexture.scale"},
    {"no node in the scene", [](Json &j) { j["scenes"][0]["nodes"] = Json::array(); },
     "3: no triangles reachable from the scene"},
    {"instancing with unequal counts",
     [](Json &j) {
         j["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"TRANSLATION", 0},
                                                                                 {"_ID", 1}};
     },
     "elements, another attribute has"},
    {"instancing with indices as scale",
     [](Json &j) {
         j["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {{"SCALE", 1}};
     },
     "SCALE"},
    {"draco without a view",
     [](Json &j) {
         primitive(j)["extensions"]["KHR_draco_mesh_compression"] = {{"attributes", {{"POSITION", 0}}}};
     },
     "KHR_draco_mesh_compression.bufferView: missing"},
    {"draco on plain bytes",
     [](Json &j) {
         primitive(j)["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0},
                                                                     {"attributes", {{"POSITION", 0}}}};
     },
     "not a Draco payload"},
};

} // namespace

TEST_CASE("each broken document is refused for its own reason")
{
    CHECK(told(good()) == "converted");
    for (const Broken &b : broken) {
        CAPTURE(b.what);
        Gltf gltf = good();
        b.break_it(gltf.json);
        const std::string message = told(gltf);
        CHECK_MESSAGE(contains(message, b.message), message);
        CHECK(message != "converted");
    }
}

TEST_CASE("index values")
{
    const auto with = [](auto zero, std::uint32_t index, std::size_t vertices) {
        Gltf gltf;
        std::vector<decltype(zero)> indices = {0, 1, static_cast<decltype(zero)>(index)};
        const std::size_t p = gltf.positions(std::vector<Float3>(vertices)), i = gltf.indices(indices);
        gltf.root({{"mesh", gltf.mesh({{"attributes", {{"POSITION", p}}}, {"indices", i}})}});
        return told(gltf);
    };
    CHECK(with(std::uint8_t{}, 2, 3) == "converted");
    CHECK(contains(with(std::uint8_t{}, 3, 3), "index 2 is 3, there are 3 vertices"));
    CHECK(contains(with(std::uint32_t{}, 0xfffffffe, 3), "index 2 is 4294967294"));
    CHECK(contains(with(std::uint8_t{}, 255, 300), "restart value 255"));
    CHECK(with(std::uint16_t{}, 255, 300) == "converted");
    CHECK(contains(with(std::uint16_t{}, 65535, 70000), "restart value 65535"));
}

TEST_CASE("coordinates must be finite")
{
    for (const float x : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
        Gltf gltf;
        gltf.root(
            {{"mesh", gltf.mesh({{"attributes",
                                  {{"POSITION", gltf.positions({{0, 0, 0}, {1, 0, 0}, {0, x, 0}})}}}})}});
        CHECK(told(gltf) == "3: accessors[0]: number 7 is not finite");
    }
}

TEST_CASE("no file outside the folder is read")
{
    const Folder outside;
    const Gltf gltf = good();
    const auto secret = outside.write("secret.bin", gltf.bin);
    std::filesystem::create_directory(outside.path() / "in");
    std::filesystem::create_symlink(secret, outside.path() / "in/link.bin");
    std::filesystem::create_directory_symlink("..", outside.path() / "in/up");
    const auto uri = [&](const std::string &text) {
        return refusal(outside.write("in/a.gltf", gltf.text(text)));
    };
    outside.write("in/inside.bin", gltf.bin);
    CHECK(uri("inside.bin") == "converted");
    CHECK(contains(uri("../secret.bin"), "leaves the folder"));
    CHECK(contains(uri("%2e%2e/secret.bin"), "leaves the folder"));
    CHECK(contains(uri("..%2fsecret.bin"), "leaves the folder"));
    CHECK(contains(uri("sub/../../secret.bin"), "leaves the folder"));
    CHECK(contains(uri("link.bin"), "a link that leads out"));
    CHECK(contains(uri("up/secret.bin"), "a link that leads out"));
    CHECK(contains(uri(secret.string()), "an absolute path"));
    CHECK(contains(uri("file://" + secret.string()), "only files beside the document"));
    CHECK(contains(uri("http://example.com/a.bin"), "only files beside the document"));
    CHECK(contains(uri("c:secret.bin"), "only files beside the document"));
    CHECK(contains(uri("..\\secret.bin"), "not a valid URI"));
    CHECK(contains(uri("inside.bin%00.png"), "not a valid URI"));
    CHECK(contains(uri("inside%2"), "not a valid URI"));
    CHECK(contains(uri("inside%zz"), "not a valid URI"));
    CHECK(contains(uri(""), "not a valid URI"));
    CHECK(uri("none.bin").starts_with("2: "));
    CHECK(contains(uri("."), "not a regular file"));
    outside.write("in/lfs.bin", "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 3\n");
    CHECK(contains(uri("lfs.bin"), "git lfs pull"));
    outside.write("in/short.bin", Bytes(10));
    CHECK(contains(uri("short.bin"), "buffers[0] declares 168 bytes, there are 10"));
}

TEST_CASE("data URIs are read to the letter")
{
    const Folder folder;
    const Gltf gltf = good();
    const std::string whole = gltf.data_uri(), data = whole.substr(whole.find(',') + 1);
    const auto uri = [&](const std::string &text) {
        return refusal(folder.write("a.gltf", gltf.text(text)));
    };
    CHECK(uri(whole) == "converted");
    CHECK(uri("data:;base64," + data) == "converted");
    CHECK(uri("data:application/gltf-buffer;charset=x;base64," + data) == "converted");
    for (const std::string &bad : std::vector<std::string>{
             "data:application/octet-stream;;base64," + data, "data:application/octet-stream," + data,
             "data:base64," + data, "data:;base64", "data:;base64," + data.substr(1),
             "data:;base64,===" + data.substr(3), "data:;base64,!" + data.substr(1),
             "data:;base64," + data.substr(0, 8) + "====" + data.substr(12), "data:x;base64," + data,
             "data:;base64, " + data.substr(1)}) {
        CAPTURE(bad.substr(0, 50));
        CHECK(contains(uri(bad), "not a valid base64 data URI"));
    }
    CHECK(contains(uri("data:;base64,AAAA"), "declares 168 bytes, there are 3"));
}

TEST_CASE("data URIs are found where they are, and nowhere else")
{
    const Folder folder;
    const Gltf gltf = good();
    const std::string whole = gltf.data_uri();
    const auto read = [&](const std::string &text) { return refusal(folder.write("a.gltf", text)); };
    const auto with = [&](const std::string &key, const std::string &value) { // as they are in the text
        std::string text = gltf.text(whole);
        text.insert(1, "\"" + key + "\":" + value + ",");
        return read(text);
    };
    CHECK(read(gltf.text(whole)) == "converted");
    std::string escaped = gltf.text(whole);
    escaped.replace(escaped.find("octet"), 1, "\\u006f"); // "\u006f" is "o"
    CHECK(read(escaped) == "converted");
    escaped.insert(escaped.find("base64,") + 7, "!");
    CHECK(contains(read(escaped), "not a valid base64 data URI"));
    std::string named = gltf.text(whole);
    named.replace(named.find("\"uri\""), 5, "\"\\u0075ri\"");
    CHECK(read(named) == "converted");
    // Strings that look like one, before and after the buffer's.
    CHECK(with("extras", R"({"uri":"data:x","of":["uri","data:;base64,AAAA"],"data:":"uri"})") ==
          "converted");
    CHECK(with("extensionsUsed", R"(["uri","data:x","\"uri\":\"data:\""])") == "converted");
    CHECK(with("images", R"([{"uri":"data:image/png;base64,AAAA","name":"data:uri"},{"uri":"b.png"}])") ==
          "converted");
    CHECK(contains(with("images", "[{\"uri\":\"data:\n\"}]"), "not valid JSON"));
    CHECK(contains(with("images", R"([{"uri":5}])"), "images[0].uri: a value of the wrong type"));
    for (const char *broken : {"{\"uri\":\"data:", "{\"uri\":\"data:\\", "{\"uri\":\"data:\"",
                               "[\"uri\":\"data:\"]", "{\"uri\" \"data:\"}", "{\"uri\":\"data:\"}}"})
        CHECK(contains(read(broken), "not valid JSON"));
    CHECK(contains(read("{\"uri\":\"data:\"}"), "asset"));
}

TEST_CASE("GLB containers")
{
    const Folder folder;
    const Bytes whole = good().glb();
    const auto told_of = [&](const Bytes &bytes) { return refusal(folder.write("a.glb", bytes)); };
    const auto patched = [&](std::size_t at, std::uint32_t value) {
        Bytes bytes = whole;
        std::memcpy(bytes.data() + at, &value, 4);
        return told_of(bytes);
    };
    const auto length_fixed = [&](Bytes bytes) {
        const auto length = static_cast<std::uint32_t>(bytes.size());
        std::memcpy(bytes.data() + 8, &length, 4);
        return bytes;
    };
    std::uint32_t json_size = 0;
    std::memcpy(&json_size, whole.data() + 12, 4);
    CHECK(told_of(whole) == "converted");
    CHECK(contains(patched(0, 0), "does not begin with 'glTF'"));
    CHECK(patched(4, 1).starts_with("5: GLB container version 1"));
    CHECK(contains(patched(8, 40), "the GLB header says 40 bytes"));
    CHECK(contains(patched(12, 0xffffffff), "GLB chunk 0 needs 4294967295 bytes"));
    CHECK(contains(patched(12, json_size - 1), "not a multiple of 4"));
    CHECK(contains(patched(16, 0x004e4942), "the first GLB chunk is not JSON"));
    CHECK(contains(patched(12 + 8 + json_size, 0x7ffffffc), "GLB chunk 1 needs"));
    CHECK(contains(patched(12 + 8 + json_size + 4, 0x4e4f534a), "a second JSON chunk"));
    CHECK(contains(patched(12 + 8 + json_size + 4, 0x12345678), "no BIN chunk stands for it"));
    Bytes longer = whole;
    longer.resize(longer.size() + 4);
    CHECK(contains(told_of(longer), "the GLB header says"));
    CHECK(contains(told_of(length_fixed(longer)), "GLB chunk 2 has 4 bytes of an 8 byte header"));
    // A third chunk of an unknown kind is nobody's business, a second BIN is.
    for (const std::uint32_t type : {0x21212121u, 0x004e4942u}) {
        Bytes more = whole;
        append(more, std::uint32_t{4});
        append(more, type);
        append(more, std::uint32_t{0});
        CHECK((told_of(length_fixed(more)) == "converted") == (type == 0x21212121u));
    }
    CHECK(contains(refusal(folder.write("b.gltf", whole)), "give it the ending .glb"));
    CHECK(refusal(folder.write("a.glb", whole), {1e-3, false}).starts_with("1: glTF is in metres"));
}

TEST_CASE("JSON text")
{
    const Folder folder;
    const auto told_of = [&](const std::string &text) { return refusal(folder.write("a.gltf", text)); };
    CHECK(contains(told_of(""), "no JSON"));
    CHECK(contains(told_of("{]"), "not valid JSON"));
    CHECK(contains(told_of("{\"a\n\": 1}"), "not valid JSON"));
    CHECK(contains(told_of("[]"), "the JSON is not an object"));
    CHECK(contains(told_of("{\"asset\": {\"version\": \"2.0\"}} x"), "not valid JSON"));
    CHECK(contains(told_of("{\"asset\": {\"version\": \"2.0\"}, \"x\": 1e999}"), "not valid JSON"));
    CHECK(contains(told_of("{\"asset\": {\"version\": \"\xff\"}}"), "not valid JSON"));
    const std::string deep = "{\"asset\":{\"version\":\"2.0\"},\"extras\":";
    CHECK(
        contains(told_of(deep + std::string(100000, '[') + std::string(100000, ']') + "}"), "nested deeper"));
    CHECK(contains(told_of(deep + "\"" + std::string(1000, '[') + "\\\"\"}"), "no triangles"));
    CHECK(contains(told_of("version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 3\n"),
                   "git lfs pull"));
}
