// SPDX-License-Identifier: GPL-3.0-or-later
#include "import/gltf_stage.hpp"

#include "import/gltf.hpp"
#include "import/gltf_json.hpp"

#include <fmt/core.h>

namespace voxshell {
namespace {

class StageReader {
  public:
    StageReader(const Source &source, const GltfParts &parts)
        : source_(source), json_(parse_json(source, parts.json)),
          document_(read_gltf_document(source, json_, parts.bin)), buffers_(source, document_, warnings_)
    {
    }

    GltfStage run()
    {
        nodes();
        const GltfObject root(source_, json_.json, "");
        std::size_t number = 0;
        for (const GltfObject &animation : root.objects("animations")) {
            const std::vector<GltfObject> samplers = animation.objects("samplers");
            std::size_t count = 0;
            for (const GltfObject &channel : animation.objects("channels"))
                add(number, count++, channel, samplers);
            ++number;
        }
        stage_.json = std::move(json_.text);
        return std::move(stage_);
    }

  private:
    void nodes()
    {
        const tinygltf::Model &model = document_.model;
        stage_.nodes.resize(model.nodes.size());
        for (std::size_t n = 0; n < model.nodes.size(); ++n) {
            const tinygltf::Node &from = model.nodes[n];
            GltfStage::Node &node = stage_.nodes[n];
            node.name = from.name;
            node.pose = pose_of(from);
            node.has_matrix = !from.matrix.empty();
            std::copy(from.translation.begin(), from.translation.end(), node.translation);
            std::copy(from.rotation.begin(), from.rotation.end(), node.rotation);
            std::copy(from.scale.begin(), from.scale.end(), node.scale);
            for (const int child : from.children) stage_.nodes[static_cast<std::size_t>(child)].parent = n;
        }
        if (document_.declares_scene)
            stage_.scene = static_cast<std::size_t>(model.defaultScene);
        else if (!model.scenes.empty())
            stage_.scene = 0;
        if (!stage_.scene) return;
        std::vector<int> stack = model.scenes[*stage_.scene].nodes;
        while (!stack.empty()) {
            const auto n = static_cast<std::size_t>(stack.back());
            stack.pop_back();
            stage_.nodes[n].is_in_scene = true;
            stack.insert(stack.end(), model.nodes[n].children.begin(), model.nodes[n].children.end());
        }
    }

    void add(std::size_t animation, std::size_t number, const GltfObject &channel,
             const std::vector<GltfObject> &samplers)
    {
        const GltfObject target = channel.required_object("target");
        const auto node = target.reference("node", stage_.nodes.size());
        if (!node) return; // of an extension: moves no node
        GltfStage::Channel out{animation, number, *node, target.text("path").value_or(""), {}, {}, {}};
        const GltfObject &sampler = samplers[channel.required_reference("sampler", samplers.size())];
        out.interpolation = sampler.text("interpolation").value_or("LINEAR");
        const bool turns = out.path == "rotation";
        if (out.interpolation == "LINEAR" && (turns || out.path == "translation")) {
            const std::size_t count = document_.model.accessors.size();
            out.times =
                numbers(sampler, "input", sampler.required_reference("input", count), TINYGLTF_TYPE_SCALAR);
            out.values = numbers(sampler, "output", sampler.required_reference("output", count),
                                 turns ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3);
            if (out.values.size() != out.times.size() * (turns ? 4 : 3))
                sampler.fail("output", "not one for each time");
            for (std::size_t n = 0; n < out.times.size(); ++n)
                if (!(out.times[n] >= 0) || (n && !(out.times[n] > out.times[n - 1])))
                    sampler.fail("input", "times do not ascend from 0");
        }
        stage_.channels.push_back(std::move(out));
    }

    std::vector<double> numbers(const GltfObject &sampler, const char *key, std::size_t accessor, int type)
    {
        const tinygltf::Accessor &a = document_.model.accessors[accessor];
        const bool is_small = type == TINYGLTF_TYPE_VEC4 && a.normalized;
        if (a.type != type || (a.componentType != 5126 && !is_small))
            sampler.fail(key, "an accessor of a componentType or type that is not allowed");
        std::vector<double> out = buffers_.numbers(accessor);
        for (const double x : out)
            if (!std::isfinite(x)) sampler.fail(key, "not finite");
        return out;
    }

    const Source &source_;
    std::vector<Warning> warnings_; ///< of buffers: import_scene() says them again
    GltfJson json_;
    GltfDocument document_;
    GltfBuffers buffers_;
    GltfStage stage_;
};

} // namespace

GltfPose GltfStage::pose_in_scene(std::size_t node) const
{
    GltfPose pose = nodes[node].pose;
    for (auto parent = nodes[node].parent; parent; parent = nodes[*parent].parent)
        pose = compose(nodes[*parent].pose, pose);
    return pose;
}

GltfStage read_gltf_stage(const std::filesystem::path &path)
{
    const std::string name = path.string();
    Bytes bytes = read_whole_file(path, name);
    const auto file_hash = sha256(bytes);
    Sha256Stream hash;                        // of what buffers take in besides: import_scene() tells that
    std::vector<std::filesystem::path> files; // as it does these
    const Source source{path, name, bytes, hash, files};
    const std::string ending = path.extension().string();
    GltfStage stage = StageReader(source, gltf_parts(source, ending == ".glb" || ending == ".GLB")).run();
    stage.source_hash = file_hash;
    return stage;
}

} // namespace voxshell
