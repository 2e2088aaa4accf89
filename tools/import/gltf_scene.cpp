// SPDX-License-Identifier: GPL-3.0-or-later
// The node graph: transforms, instances, names (glTF 2.0, 3.5; EXT_mesh_gpu_instancing).
#include "import/gltf.hpp"
#include "import/gltf_pose.hpp"

#include <fmt/core.h>

#include <cmath>
#include <functional>
#include <unordered_map>

namespace voxshell {
namespace {

using Pose = GltfPose;
constexpr std::size_t max_path =
    200; ///< [bytes] of an instance's name: a deep graph must not fill the memory

class SceneBuilder {
  public:
    SceneBuilder(const Source &source, const GltfDocument &document)
        : source_(source), document_(document), buffers_(source, document, scene_.warnings),
          meshes_(source, document, buffers_), mesh_of_(document.model.meshes.size(), not_made)
    {
    }

    /// Of the whole scene, or of one node and what is below it, in its own frame.
    Scene run(const std::string &wanted)
    {
        std::vector<Step> from;
        for (const int root : root_nodes())
            from.push_back({root, compose(gltf_identity, pose_of(node_at(root))), "", {}});
        if (!wanted.empty()) from = {stands(find(from, wanted), wanted)};
        walk(std::move(from), [&](const Step &step, const std::string &path) {
            const tinygltf::Node &node = node_at(step.node);
            const auto number = static_cast<std::uint32_t>(scene_.nodes.size());
            scene_.nodes.push_back({node.name, step.parent, step.parent ? pose_of(node) : step.pose});
            add_node(step.node, node, step.pose, path, number);
            return number;
        });
        scene_.materials = document_.materials;
        if (!wanted.empty() && scene_.instances.empty())
            source_.invalid(fmt::format("node '{}' has no triangles", printable(wanted)));
        warn();
        return std::move(scene_);
    }

  private:
    static constexpr std::int64_t not_made = -1, no_triangles = -2;

    struct Step {
        int node;
        Pose pose;                           ///< scene from node
        std::string path;                    ///< of its parent
        std::optional<std::uint32_t> parent; ///< what the visit of its parent gave
    };

    const tinygltf::Node &node_at(int index) const
    {
        return document_.model.nodes[static_cast<std::size_t>(index)];
    }

    /// Depth first with a stack of our own: a chain of nodes may be as long as the file.
    void walk(std::vector<Step> stack,
              const std::function<std::uint32_t(const Step &, const std::string &)> &visit) const
    {
        std::reverse(stack.begin(), stack.end());
        while (!stack.empty()) {
            const Step step = std::move(stack.back());
            stack.pop_back();
            const tinygltf::Node &node = node_at(step.node);
            const std::string path = path_of(step.path, node, step.node);
            const std::uint32_t number = visit(step, path);
            for (auto child = node.children.rbegin(); child != node.children.rend(); ++child)
                stack.push_back({*child, compose(step.pose, pose_of(node_at(*child))), path, number});
        }
    }

    Step find(const std::vector<Step> &from, const std::string &wanted) const
    {
        std::optional<Step> found;
        walk(from, [&](const Step &step, const std::string &) {
            if (node_at(step.node).name != wanted) return 0u;
            if (found) source_.invalid(fmt::format("two nodes are called '{}'", printable(wanted)));
            found = step;
            found->parent.reset();
            return 0u;
        });
        if (!found) source_.invalid(fmt::format("the scene has no node '{}'", printable(wanted)));
        return *found;
    }

    /// Keeps where it stands, and leaves its scale in its own frame.
    Step stands(Step step, const std::string &wanted)
    {
        const auto rigid = rigid_of(step.pose);
        if (!rigid)
            source_.invalid(
                fmt::format("node '{}' is scaled unevenly, sheared or mirrored: apply its scale to its mesh",
                            printable(wanted)));
        scene_.stand = rigid->pose;
        const double s = rigid->scale;
        step.pose = {s, 0, 0, 0, 0, s, 0, 0, 0, 0, s, 0};
        return step;
    }

    void warning(const char *code, std::string message)
    {
        scene_.warnings.push_back({code, std::move(message)});
    }

    std::vector<int> root_nodes()
    {
        const tinygltf::Model &model = document_.model;
        if (document_.declares_scene) return model.scenes[static_cast<std::size_t>(model.defaultScene)].nodes;
        if (!model.scenes.empty()) {
            warning("gltf-no-default-scene",
                    fmt::format("no default scene declared: the first of {} is taken", model.scenes.size()));
            return model.scenes[0].nodes;
        }
        std::vector<bool> is_child(model.nodes.size());
        for (const tinygltf::Node &node : model.nodes)
            for (const int child : node.children) is_child[static_cast<std::size_t>(child)] = true;
        std::vector<int> roots;
        for (std::size_t i = 0; i < is_child.size(); ++i)
            if (!is_child[i]) roots.push_back(static_cast<int>(i));
        if (!roots.empty()) warning("gltf-no-scene", "no scene declared: all root nodes are taken");
        return roots;
    }

    static std::string path_of(const std::string &parent, const tinygltf::Node &node, int index)
    {
        std::string name = node.name.empty() ? fmt::format("node{}", index) : printable(node.name);
        std::replace(name.begin(), name.end(), '/', '_');
        return parent.size() + name.size() < max_path ? parent + "/" + name : "/.../" + name;
    }

    std::string unique(const std::string &path)
    {
        std::string name = path;
        while (!names_.emplace(name, 1).second) name = fmt::format("{}#{}", path, ++names_[path]);
        return name;
    }

    /// Index into scene_.meshes, or no_triangles.
    std::int64_t mesh(int index)
    {
        std::int64_t &made = mesh_of_[static_cast<std::size_t>(index)];
        if (made == not_made) {
            Mesh mesh = meshes_.mesh(index);
            made = no_triangles;
            if (!mesh.triangles.empty()) {
                made = static_cast<std::int64_t>(scene_.meshes.size());
                scene_.meshes.push_back(std::move(mesh));
            }
        }
        return made;
    }

    void add_node(int index, const tinygltf::Node &node, const Pose &pose, const std::string &path,
                  std::uint32_t number)
    {
        const auto instancing = document_.instancing.find(index);
        if (node.mesh < 0) {
            idle_instancing_ += instancing != document_.instancing.end();
            return;
        }
        const std::int64_t made = mesh(node.mesh);
        if (node.skin >= 0 && made != no_triangles) skinned_.push_back(path);
        if (made == no_triangles) return;
        const auto mesh_index = static_cast<std::uint32_t>(made);
        if (instancing == document_.instancing.end()) {
            scene_.instances.push_back({unique(path), mesh_index, pose, number});
            return;
        }
        std::size_t count = 0;
        for (const Pose &each : instance_poses(instancing->second, path))
            scene_.instances.push_back(
                {unique(fmt::format("{}[{}]", path, count++)), mesh_index, compose(pose, each), number});
    }

    std::vector<Pose> instance_poses(const std::map<std::string, int> &attributes, const std::string &path)
    {
        const auto numbers = [&](const char *name, int type, bool may_be_small) -> std::vector<double> {
            const auto found = attributes.find(name);
            if (found == attributes.end()) return {};
            const tinygltf::Accessor &a = document_.model.accessors[static_cast<std::size_t>(found->second)];
            const bool small =
                may_be_small && a.normalized && (a.componentType == 5120 || a.componentType == 5122);
            if (a.type != type || (a.componentType != 5126 && !small)) {
                source_.invalid(fmt::format(
                    "{}: instance attribute {} has a componentType or type that is not allowed", path, name));
            }
            return buffers_.numbers(static_cast<std::size_t>(found->second));
        };
        const std::size_t count =
            document_.model.accessors[static_cast<std::size_t>(attributes.begin()->second)].count;
        std::vector<double> t = numbers("TRANSLATION", TINYGLTF_TYPE_VEC3, false);
        std::vector<double> r = numbers("ROTATION", TINYGLTF_TYPE_VEC4, true);
        std::vector<double> s = numbers("SCALE", TINYGLTF_TYPE_VEC3, false);
        buffers_.spend(16 * std::uint64_t{count}); // an instance takes about as much as 16 vertices
        std::vector<Pose> poses;
        poses.reserve(count);
        constexpr double zero[3] = {0, 0, 0}, no_turn[4] = {0, 0, 0, 1}, one[3] = {1, 1, 1};
        for (std::size_t i = 0; i < count; ++i) {
            const double *q = r.empty() ? no_turn : &r[4 * i];
            if (q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0) {
                source_.invalid(fmt::format("{}: ROTATION of instance {} is zero", path, i));
            }
            poses.push_back(from_trs(t.empty() ? zero : &t[3 * i], q, s.empty() ? one : &s[3 * i]));
        }
        return poses;
    }

    void warn()
    {
        if (meshes_.skipped_primitives() > 0) {
            warning("gltf-points-or-lines",
                    fmt::format("{} primitives of points or lines skipped: they have no surface",
                                meshes_.skipped_primitives()));
        }
        if (meshes_.saw_morph_targets())
            warning("gltf-morph-targets", "morph targets ignored: the base shape is taken");
        if (!skinned_.empty()) {
            warning("gltf-skin", fmt::format("{} skinned node(s) taken in the pose as stored, {} first",
                                             skinned_.size(), skinned_[0]));
        }
        if (document_.animations > 0) {
            warning("gltf-animations",
                    fmt::format("{} animation(s) ignored: nodes stay where they are stored",
                                document_.animations));
        }
        if (idle_instancing_ > 0) {
            warning(
                "gltf-instancing-without-mesh",
                fmt::format("{} node(s) with EXT_mesh_gpu_instancing but without a mesh: nothing to repeat",
                            idle_instancing_));
        }
    }

    const Source &source_;
    const GltfDocument &document_;
    Scene scene_;
    GltfBuffers buffers_;
    GltfMeshes meshes_;
    std::vector<std::int64_t> mesh_of_;
    std::unordered_map<std::string, std::size_t> names_;
    std::vector<std::string> skinned_;
    std::size_t idle_instancing_ = 0;
};

} // namespace

Scene import_gltf_document(const Source &source, const GltfDocument &document, const std::string &node)
{
    Scene scene = SceneBuilder(source, document).run(node);
    if (scene.instances.empty()) {
        const bool skipped = std::any_of(scene.warnings.begin(), scene.warnings.end(),
                                         [](const Warning &w) { return w.code == "gltf-points-or-lines"; });
        source.invalid(skipped ? "no triangles reachable from the scene: only points or lines"
                               : "no triangles reachable from the scene");
    }
    return scene;
}

} // namespace voxshell
