// SPDX-License-Identifier: GPL-3.0-or-later
// Checks a glTF document (glTF 2.0, chapters 3 and 5) and hands its geometry, and nothing else, to tinygltf.
#include "import/gltf.hpp"
#include "import/gltf_json.hpp"

namespace voxshell {
namespace {

constexpr std::uint64_t max_size = std::uint64_t{1} << 53;
constexpr std::uint64_t max_int = std::numeric_limits<std::int32_t>::max(); // tinygltf keeps some in an int

constexpr const char *collections[] = {"accessors", "animations", "buffers", "bufferViews", "cameras",
                                       "images",    "materials",  "meshes",  "nodes",       "samplers",
                                       "scenes",    "skins",      "textures"};

/// Extensions that change geometry and that we read.
constexpr const char *read_extensions[] = {"KHR_draco_mesh_compression", "KHR_mesh_quantization",
                                           "EXT_meshopt_compression", "KHR_meshopt_compression",
                                           "EXT_mesh_gpu_instancing"};

/// Extensions that say nothing about where a surface is: by the beginning of their name.
constexpr const char *harmless_extensions[] = {"KHR_materials_",
                                               "KHR_texture_",
                                               "KHR_lights_",
                                               "KHR_techniques_webgl",
                                               "KHR_xmp",
                                               "KHR_animation_",
                                               "KHR_audio",
                                               "KHR_physics_",
                                               "KHR_implicit_shapes",
                                               "KHR_collision",
                                               "EXT_materials_",
                                               "EXT_texture_",
                                               "EXT_lights_",
                                               "EXT_mesh_features",
                                               "EXT_instance_features",
                                               "EXT_feature_",
                                               "EXT_structural_metadata",
                                               "EXT_mesh_manifold",
                                               "EXT_schema_feature",
                                               "MSFT_texture_",
                                               "MSFT_packing_",
                                               "MSFT_physics",
                                               "MSFT_collision_",
                                               "ADOBE_materials_",
                                               "ADOBE_texture_",
                                               "FB_ngon_encoding",
                                               "AGI_articulations",
                                               "AGI_stk_metadata",
                                               "GOOGLE_texture_",
                                               "GRIFFEL_bim_data",
                                               "CESIUM_primitive_outline",
                                               "OMI_",
                                               "VRMC_materials_",
                                               "NV_materials_",
                                               "VRM"};

class Validator {
  public:
    Validator(const Source &source, const GltfJson &json, std::span<const std::uint8_t> bin)
        : source_(source), uris_(json.uris), root_(source, json.json, "")
    {
        out_.bin = bin;
    }

    GltfDocument run()
    {
        asset();
        for (const char *name : collections) {
            count_[name] = root_.array(name).size();
            if (count_[name] > max_int) root_.fail(name, "too many");
            root_.objects(name);
        }
        extensions();
        for (const char *name :
             {"animations", "cameras", "images", "materials", "samplers", "skins", "textures"})
            check_side_properties(source_, root_.array(name), name);
        for (const GltfObject &skin : root_.objects("skins")) {
            skin.references("joints", count_["nodes"]);
            skin.reference("inverseBindMatrices", count_["accessors"]);
            skin.reference("skeleton", count_["nodes"]);
        }
        out_.animations = count_["animations"];
        for (const GltfObject &material : root_.objects("materials"))
            out_.materials.push_back(material.text("name").value_or(""));

        for (const GltfObject &buffer : root_.objects("buffers")) add_buffer(buffer);
        Json reduced = {{"asset", {{"version", "2.0"}}}};
        for (const GltfObject &view : root_.objects("bufferViews"))
            reduced["bufferViews"].push_back(add_view(view));
        for (const GltfObject &accessor : root_.objects("accessors"))
            reduced["accessors"].push_back(add_accessor(accessor));
        for (const GltfObject &mesh : root_.objects("meshes")) reduced["meshes"].push_back(add_mesh(mesh));
        for (const GltfObject &node : root_.objects("nodes")) reduced["nodes"].push_back(add_node(node));
        check_tree();
        for (const GltfObject &scene : root_.objects("scenes")) reduced["scenes"].push_back(add_scene(scene));
        if (const auto scene = root_.reference("scene", count_["scenes"])) {
            reduced["scene"] = *scene;
            out_.declares_scene = true;
        }
        load(reduced);
        return std::move(out_);
    }

  private:
    void asset()
    {
        const GltfObject asset = root_.required_object("asset");
        const auto version = asset.text("version");
        if (!version) asset.fail("version", "missing");
        if (!version->starts_with("2.") || version->size() < 3 ||
            version->find_first_not_of("0123456789", 2) != version->npos) {
            source_.unsupported(fmt::format("glTF version '{}': only 2.x is read", printable(*version, 20)));
        }
        const auto least = asset.text("minVersion");
        if (least && *least != "2.0") {
            source_.unsupported(
                fmt::format("needs a reader of glTF '{}': only 2.0 is read", printable(*least, 20)));
        }
    }

    std::vector<std::string> names(const char *key) const
    {
        std::vector<std::string> out;
        for (const Json &value : root_.array(key)) {
            if (!value.is_string()) root_.fail(key, "not an array of names");
            out.push_back(value.get<std::string>());
        }
        return out;
    }

    void extensions()
    {
        const std::vector<std::string> used = names("extensionsUsed");
        out_.required = names("extensionsRequired");
        out_.quantized = std::find(used.begin(), used.end(), "KHR_mesh_quantization") != used.end();
        for (const std::string &name : out_.required) {
            if (std::find(used.begin(), used.end(), name) == used.end()) {
                source_.invalid(
                    fmt::format("extensionsRequired names '{}', extensionsUsed does not", printable(name)));
            }
            const bool known = std::any_of(std::begin(read_extensions), std::end(read_extensions),
                                           [&](const char *known_name) { return name == known_name; }) ||
                               std::any_of(std::begin(harmless_extensions), std::end(harmless_extensions),
                                           [&](const char *start) { return name.starts_with(start); });
            if (!known)
                source_.unsupported(
                    fmt::format("requires the extension '{}', which is not read", printable(name)));
        }
    }

    void add_buffer(const GltfObject &buffer)
    {
        GltfBuffer b;
        if (const Json *uri = buffer.find("uri"); uri && uri->is_binary())
            b.embedded = uris_[uri->get_binary().subtype()];
        else
            b.uri = buffer.text("uri");
        b.length = buffer.required_integer("byteLength", 1, max_size);
        for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
            if (const auto extension = buffer.extension(name)) b.fallback |= extension->flag("fallback");
        out_.buffers.push_back(std::move(b));
    }

    Json add_view(const GltfObject &view)
    {
        const std::uint64_t buffer = view.required_reference("buffer", count_["buffers"]);
        const std::uint64_t offset = view.integer("byteOffset", 0, max_size).value_or(0);
        const std::uint64_t length = view.required_integer("byteLength", 1, max_size);
        if (offset + length > out_.buffers[buffer].length) {
            source_.invalid(fmt::format("{}: bytes {} to {} do not fit buffer {} of {} bytes", view.where(),
                                        offset, offset + length, buffer, out_.buffers[buffer].length));
        }
        Json reduced = {{"buffer", buffer}, {"byteOffset", offset}, {"byteLength", length}};
        const auto stride = view.integer("byteStride", 4, 252);
        if (stride && *stride % 4 != 0)
            view.fail("byteStride", fmt::format("{} is not a multiple of 4", *stride));
        if (stride) reduced["byteStride"] = *stride;
        view.integer("target", 0, max_int);

        std::optional<GltfMeshopt> meshopt;
        for (const char *name : {"KHR_meshopt_compression", "EXT_meshopt_compression"}) {
            const auto extension = view.extension(name);
            if (!extension || meshopt) continue;
            GltfMeshopt m;
            m.extension = name;
            m.buffer = extension->required_reference("buffer", count_["buffers"]);
            m.offset = extension->integer("byteOffset", 0, max_size).value_or(0);
            m.length = extension->required_integer("byteLength", 1, max_size);
            m.stride = extension->required_integer("byteStride", 1, 256);
            m.count = extension->required_integer("count", 1, max_size / 256);
            m.mode = extension->text("mode").value_or("");
            m.filter = extension->text("filter").value_or("NONE");
            if (m.mode.empty()) extension->fail("mode", "missing");
            if (m.offset + m.length > out_.buffers[m.buffer].length) {
                extension->fail("byteLength",
                                fmt::format("bytes {} to {} do not fit buffer {} of {} bytes", m.offset,
                                            m.offset + m.length, m.buffer, out_.buffers[m.buffer].length));
            }
            if (m.count * m.stride != length) {
                extension->fail("count", fmt::format("{} x {} bytes decode to {}, the bufferView has {}",
                                                     m.count, m.stride, m.count * m.stride, length));
            }
            meshopt = std::move(m);
        }
        out_.meshopt.push_back(std::move(meshopt));
        view_length_.push_back(length);
        view_offset_.push_back(offset);
        view_stride_.push_back(stride.value_or(0));
        return reduced;
    }

    std::uint64_t component_type(const GltfObject &object, bool indices) const
    {
        const std::uint64_t type = object.required_integer("componentType", 0, max_int);
        const bool known = type == 5121 || type == 5123 || type == 5125 ||
                           (!indices && (type == 5120 || type == 5122 || type == 5126));
        if (!known) object.fail("componentType", fmt::format("{} is not allowed", type));
        return type;
    }

    /// `count` elements of `size` bytes at `offset` of a view, `stride` apart, are in it and aligned.
    void fits(const GltfObject &object, std::uint64_t view, std::uint64_t offset, std::uint64_t count,
              std::uint64_t size, std::uint64_t stride, std::uint64_t component) const
    {
        if (offset % component != 0 || (view_offset_[view] + offset) % component != 0) {
            object.fail("byteOffset", fmt::format("not aligned to components of {} bytes", component));
        }
        if (stride < size) {
            source_.invalid(
                fmt::format("{}: byteStride {} of bufferView {} is less than an element's {} bytes",
                            object.where(), stride, view, size));
        }
        const std::uint64_t length = view_length_[view];
        if (offset > length || size > length - offset || (count - 1) > (length - offset - size) / stride) {
            source_.invalid(
                fmt::format("{}: {} elements of {} bytes at offset {} do not fit bufferView {} of {} bytes",
                            object.where(), count, size, offset, view, length));
        }
    }

    Json add_accessor(const GltfObject &accessor)
    {
        const std::uint64_t component = component_type(accessor, false);
        const std::uint64_t bytes = gltf_component_size(static_cast<int>(component));
        const std::uint64_t count = accessor.required_integer("count", 1, max_size / 256);
        const auto type = accessor.text("type");
        if (!type) accessor.fail("type", "missing");
        const std::uint64_t components = *type == "SCALAR"                    ? 1
                                         : *type == "VEC2"                    ? 2
                                         : *type == "VEC3"                    ? 3
                                         : *type == "VEC4" || *type == "MAT2" ? 4
                                         : *type == "MAT3"                    ? 9
                                         : *type == "MAT4"                    ? 16
                                                                              : 0;
        if (components == 0) accessor.fail("type", fmt::format("'{}' is not allowed", printable(*type, 20)));
        // Columns of matrices begin at multiples of 4 bytes (3.6.2.4).
        const std::uint64_t rows = *type == "MAT2" ? 2 : *type == "MAT3" ? 3 : 0;
        const std::uint64_t size = rows ? rows * ((rows * bytes + 3) / 4 * 4) : components * bytes;
        const bool normalized = accessor.flag("normalized");
        if (normalized && (component == 5125 || component == 5126)) {
            accessor.fail("normalized", "only integers of 8 and 16 bits can be normalised");
        }
        const std::uint64_t offset = accessor.integer("byteOffset", 0, max_size).value_or(0);
        Json reduced = {
            {"componentType", component}, {"count", count}, {"type", *type}, {"normalized", normalized}};
        if (const auto view = accessor.reference("bufferView", count_["bufferViews"])) {
            fits(accessor, *view, offset, count, size, view_stride_[*view] ? view_stride_[*view] : size,
                 bytes);
            reduced["bufferView"] = *view;
            reduced["byteOffset"] = offset;
        } else if (accessor.has("byteOffset")) {
            accessor.fail("byteOffset", "given without a bufferView");
        }
        for (const char *bound : {"min", "max"}) accessor.numbers(bound, components);
        if (const auto sparse = accessor.object("sparse")) {
            const std::uint64_t changed = sparse->required_integer("count", 1, std::min(count, max_int));
            reduced["sparse"] = {
                {"count", changed},
                {"indices", sparse_part(sparse->required_object("indices"), changed, 0)},
                {"values", sparse_part(sparse->required_object("values"), changed, size, bytes)}};
        }
        accessors_.push_back({count, *type, static_cast<int>(component), normalized});
        return reduced;
    }

    /// sparse.indices when `size` is 0, else sparse.values of elements of `size` bytes.
    Json sparse_part(const GltfObject &part, std::uint64_t count, std::uint64_t size,
                     std::uint64_t component = 0) const
    {
        Json reduced;
        if (size == 0) {
            const std::uint64_t type = component_type(part, true);
            size = component = gltf_component_size(static_cast<int>(type));
            reduced["componentType"] = type;
        }
        const std::uint64_t view = part.required_reference("bufferView", count_.at("bufferViews"));
        const std::uint64_t offset = part.integer("byteOffset", 0, max_int).value_or(0);
        if (view_stride_[view] != 0) part.fail("bufferView", "has a byteStride, which sparse data may not");
        fits(part, view, offset, count, size, size, component);
        reduced["bufferView"] = view;
        reduced["byteOffset"] = offset;
        return reduced;
    }

    Json add_mesh(const GltfObject &mesh)
    {
        const int mesh_index = mesh_count_++;
        Json reduced = {{"primitives", Json::array()}, {"name", mesh.text("name").value_or("")}};
        if (!mesh.has("primitives")) mesh.fail("primitives", "missing");
        int index = 0;
        for (const GltfObject &primitive : mesh.objects("primitives"))
            reduced["primitives"].push_back(add_primitive(primitive, mesh_index, index++));
        if (index == 0) mesh.fail("primitives", "empty");
        return reduced;
    }

    /// Attributes of a primitive or a morph target: all refer to accessors of one count.
    Json attributes(const GltfObject &map, std::optional<std::uint64_t> &count) const
    {
        Json reduced = Json::object();
        for (const auto &[name, value] : map.json().items()) {
            const std::uint64_t accessor = map.required_reference(name.c_str(), accessors_.size());
            const std::uint64_t elements = accessors_[accessor].count;
            if (count && *count != elements) {
                map.fail(printable(name, 40).c_str(),
                         fmt::format("{} elements, another attribute has {}", elements, *count));
            }
            count = elements;
            reduced[name] = accessor;
        }
        return reduced;
    }

    Json add_primitive(const GltfObject &primitive, int mesh_index, int index)
    {
        const std::uint64_t mode = primitive.integer("mode", 0, 6).value_or(4);
        const GltfObject map = primitive.required_object("attributes");
        std::optional<std::uint64_t> count;
        Json reduced = {{"mode", mode}, {"attributes", attributes(map, count)}};
        if (const auto position = map.reference("POSITION", accessors_.size())) {
            const Accessor &a = accessors_[*position];
            const bool is_float = a.component == 5126 && !a.normalized;
            const bool is_small = a.component >= 5120 && a.component <= 5123;
            if (a.type != "VEC3" || (!is_float && !(is_small && out_.quantized))) {
                map.fail("POSITION",
                         fmt::format("{} of componentType {} is not allowed{}", a.type, a.component,
                                     is_small && a.type == "VEC3" ? " without KHR_mesh_quantization" : ""));
            }
        }
        if (const auto indices = primitive.reference("indices", accessors_.size())) {
            const Accessor &a = accessors_[*indices];
            const bool is_unsigned = a.component == 5121 || a.component == 5123 || a.component == 5125;
            if (a.type != "SCALAR" || !is_unsigned || a.normalized) {
                primitive.fail("indices",
                               fmt::format("{} of componentType {} is not allowed", a.type, a.component));
            }
            reduced["indices"] = *indices;
        }
        if (const auto material = primitive.reference("material", count_["materials"]))
            reduced["material"] = *material;
        for (const GltfObject &target : primitive.objects("targets")) {
            attributes(target, count);
            reduced["targets"].push_back(Json::object()); // that there is one is all that is needed
        }
        if (const auto draco = primitive.extension("KHR_draco_mesh_compression")) {
            GltfDraco link;
            link.view = draco->required_reference("bufferView", count_["bufferViews"]);
            const GltfObject ids = draco->required_object("attributes");
            for (const auto &[name, value] : ids.json().items()) {
                const std::uint64_t id = ids.required_integer(name.c_str(), 0, max_int);
                if (!map.has(name.c_str()))
                    ids.fail(printable(name, 40).c_str(), "not an attribute of the primitive");
                if (name == "POSITION") link.position = static_cast<std::uint32_t>(id);
            }
            out_.draco[{mesh_index, index}] = link;
        }
        return reduced;
    }

    Json add_node(const GltfObject &node)
    {
        const int index = node_count_++;
        Json reduced = {{"name", node.text("name").value_or("")}};
        for (const auto &[key, size] : {std::pair<const char *, std::size_t>{"matrix", 16},
                                        {"translation", 3},
                                        {"rotation", 4},
                                        {"scale", 3}}) {
            if (!node.has(key)) continue;
            reduced[key] = node.numbers(key, size);
            if (size != 16 && node.has("matrix")) node.fail(key, "given beside a matrix");
        }
        if (node.has("matrix")) {
            const std::vector<double> m = node.numbers("matrix", 16);
            if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1) {
                node.fail("matrix", "not affine: the last row is not 0 0 0 1");
            }
        }
        if (node.has("rotation")) {
            const std::vector<double> q = node.numbers("rotation", 4);
            const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
            if (!(std::abs(length - 1) < 0.01)) {
                node.fail("rotation", fmt::format("not a unit quaternion (its length is {:.6g})", length));
            }
        }
        if (const auto mesh = node.reference("mesh", count_["meshes"])) reduced["mesh"] = *mesh;
        node.reference("camera", count_["cameras"]);
        if (const auto skin = node.reference("skin", count_["skins"])) reduced["skin"] = *skin;
        children_.push_back(node.references("children", count_["nodes"]));
        if (!children_.back().empty()) reduced["children"] = children_.back();

        if (const auto instancing = node.extension("EXT_mesh_gpu_instancing")) {
            // Without a mesh there is nothing to repeat; such nodes carry private data.
            std::map<std::string, int> &out = out_.instancing[index];
            if (node.has("mesh")) {
                std::optional<std::uint64_t> count;
                const Json map = attributes(instancing->required_object("attributes"), count);
                for (const auto &[name, accessor] : map.items()) out[name] = accessor.get<int>();
                if (out.empty()) instancing->fail("attributes", "empty");
            }
        }
        return reduced;
    }

    /// Every node has at most one parent and none is its own ancestor.
    void check_tree()
    {
        parent_.assign(children_.size(), -1);
        for (std::size_t i = 0; i < children_.size(); ++i)
            for (const std::uint64_t child : children_[i]) {
                if (parent_[child] >= 0) {
                    source_.invalid(
                        fmt::format("nodes[{}] has two parents, {} and {}", child, parent_[child], i));
                }
                parent_[child] = static_cast<std::int64_t>(i);
            }
        // With one parent each, a walk up ends at a root, at a node known to end there, or runs in a loop.
        std::vector<std::uint32_t> walk(children_.size(), 0);
        for (std::size_t i = 0; i < children_.size(); ++i) {
            const auto mark = static_cast<std::uint32_t>(i + 1);
            for (std::int64_t n = static_cast<std::int64_t>(i); n >= 0 && walk[n] != mark; n = parent_[n]) {
                if (walk[n] != 0) break;
                walk[n] = mark;
                if (parent_[n] >= 0 && walk[parent_[n]] == mark) {
                    source_.invalid(fmt::format("nodes[{}] is its own ancestor", parent_[n]));
                }
            }
        }
    }

    Json add_scene(const GltfObject &scene) const
    {
        Json reduced = {{"nodes", Json::array()}};
        for (const std::uint64_t node : scene.references("nodes", children_.size())) {
            if (parent_[node] >= 0)
                scene.fail("nodes", fmt::format("{} is not a root: its parent is {}", node, parent_[node]));
            reduced["nodes"].push_back(node);
        }
        return reduced;
    }

    void load(Json &reduced)
    {
        // tinygltf insists that an index accessor has a bufferView; Draco's have none. Lend them one.
        std::vector<std::size_t> lent;
        if (reduced.contains("accessors")) {
            for (std::size_t i = 0; i < reduced["accessors"].size(); ++i) {
                if (reduced["accessors"][i].contains("bufferView")) continue;
                reduced["accessors"][i]["bufferView"] = view_length_.size();
                lent.push_back(i);
            }
        }
        if (!lent.empty()) reduced["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 1}});

        const std::string text = reduced.dump();
        if (text.size() > max_int) source_.unsupported("more than 2 GiB of JSON");
        tinygltf::TinyGLTF reader;
        std::string error, warning;
        if (!reader.LoadASCIIFromString(&out_.model, &error, &warning, text.data(),
                                        static_cast<unsigned>(text.size()), "")) {
            source_.invalid(printable(error, 200));
        }
        for (const std::size_t i : lent) out_.model.accessors[i].bufferView = -1;
        out_.model.bufferViews.resize(view_length_.size());
    }

    struct Accessor {
        std::uint64_t count;
        std::string type;
        int component;
        bool normalized;
    };

    const Source &source_;
    const std::vector<std::span<std::uint8_t>> &uris_;
    GltfObject root_;
    GltfDocument out_;
    std::map<std::string, std::size_t> count_;
    std::vector<std::uint64_t> view_length_, view_offset_, view_stride_;
    std::vector<Accessor> accessors_;
    std::vector<std::vector<std::uint64_t>> children_;
    std::vector<std::int64_t> parent_;
    int mesh_count_ = 0, node_count_ = 0;
};

} // namespace

std::size_t gltf_component_size(int component_type)
{
    switch (component_type) {
    case 5120:
    case 5121:
        return 1;
    case 5122:
    case 5123:
        return 2;
    default:
        return 4;
    }
}

GltfDocument read_gltf_document(const Source &source, const GltfJson &json, std::span<const std::uint8_t> bin)
{
    return Validator(source, json, bin).run();
}

} // namespace voxshell
