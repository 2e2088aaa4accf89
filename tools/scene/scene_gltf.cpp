// SPDX-License-Identifier: GPL-3.0-or-later
// NAME.scene.glb and .scene.gltf: parts are nodes with a role, the rest of the scene file is the extras of
// the glTF's scene, read by the scene file's own reader.
#include "scene/scene_keys.hpp"

#include "import/gltf_stage.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>
#include <set>

namespace voxshell {
namespace {

constexpr std::string_view extras_key = "voxshell";
constexpr std::size_t most_items = std::size_t{1} << 24;
constexpr int max_depth = 64; // of a glTF

/// "any name" as a message can have it.
std::string quoted(const std::string &name)
{
    std::string out;
    for (const char c : name.substr(0, 40))
        out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '_' : c;
    return "'" + out + (name.size() > 40 ? "..." : "") + "'";
}

Quaternion quaternion_of(const GltfPose &m)
{
    // The largest of the four first: no small divisor (Shepperd 1978).
    const double squares[4] = {1 + m[0] - m[5] - m[10], 1 - m[0] + m[5] - m[10], 1 - m[0] - m[5] + m[10],
                               1 + m[0] + m[5] + m[10]}; // 4 x^2, y^2, z^2, w^2
    const double xy = m[1] + m[4], xz = m[2] + m[8], yz = m[6] + m[9];
    const double xw = m[9] - m[6], yw = m[2] - m[8], zw = m[4] - m[1]; // each four times the product
    const Quaternion rows[4] = {{squares[0], xy, xz, xw},
                                {xy, squares[1], yz, yw},
                                {xz, yz, squares[2], zw},
                                {xw, yw, zw, squares[3]}};
    Quaternion q = rows[std::max_element(squares, squares + 4) - squares];
    double square = 0;
    for (const double x : q) square += x * x;
    for (double &x : q) x = x / std::sqrt(square) + 0.0; // never -0
    return q;
}

/// Where a node with a role goes, in the scene, and when.
struct Way {
    std::vector<double> times; ///< [s]; empty: it stands
    std::vector<Pose> poses;
};

class GltfScene {
  public:
    explicit GltfScene(const std::filesystem::path &path)
        : stage_(read_gltf_stage(path)), document_(path, stage_.json, "", max_depth),
          root_(JsonObject::any(document_.root()))
    {
        scene_.path = path;
        scene_.source_hash = stage_.source_hash;
    }

    SceneFile run()
    {
        read_scene_extras();
        find_roles();
        check_animations();
        for (const Role &role : roles_) role.moves ? read_dynamic(role) : read_static(role);
        const JsonPlace nodes = root_.get("nodes");
        const auto dynamics = std::ranges::count(roles_, true, &Role::moves);
        if (!dynamics) nodes.refuse("none has the role dynamic: \"extras\": {\"voxshell\": \"dynamic\"}");
        if (scene_.statics.empty())
            nodes.refuse("none has the role static: \"extras\": {\"voxshell\": \"static\"}");
        ask_for_motion(nodes, scene_);
        return std::move(scene_);
    }

  private:
    struct Role {
        std::size_t node;
        bool moves;
        double density;
        std::string place; ///< "/nodes/3 'Cup'"
    };

    std::string place_of(std::size_t node) const
    {
        return fmt::format("/nodes/{} {}", node, quoted(stage_.nodes[node].name));
    }

    void read_scene_extras()
    {
        if (!stage_.scene) document_.root().refuse("lacks \"scenes\"");
        const JsonPlace scene = root_.get("scenes").items(1, most_items)[*stage_.scene];
        const auto extras = JsonObject::any(scene).find("extras");
        const auto own =
            extras && extras->is_object() ? JsonObject::any(*extras).find(extras_key) : std::nullopt;
        if (!own)
            scene.refuse("lacks \"extras\": {\"voxshell\": {...}}: what a scene file says besides static and "
                         "dynamic (voxshell convert --example-scene)");
        std::optional<JsonDocument> text; // an editor of properties, as Blender's, may hold text only
        if (own->is_string()) text.emplace(scene_.path, own->string(""), own->pointer());
        const JsonPlace said = text ? text->root() : *own;
        const JsonObject any = JsonObject::any(said);
        for (const std::string_view list : {"static", "dynamic"})
            if (const auto found = any.find(list))
                found->refuse(
                    fmt::format("in a glTF nodes say it: \"extras\": {{\"voxshell\": \"{}\"}}", list));
        const JsonObject object(said, scene_keys);
        read_keys(object, scene_);
        if (const auto hand = object.find("hand")) hand_place_ = hand->pointer();
    }

    void find_roles()
    {
        const std::vector<JsonPlace> nodes = root_.get("nodes").items(1, most_items);
        std::map<std::string, std::size_t> names;
        for (const GltfStage::Node &node : stage_.nodes)
            if (node.is_in_scene) ++names[node.name];
        for (std::size_t n = 0; n < nodes.size(); ++n) {
            if (!stage_.nodes[n].is_in_scene) continue;
            const auto extras = JsonObject::any(nodes[n]).find("extras");
            if (!extras || !extras->is_object()) continue;
            const auto own = JsonObject::any(*extras).find(extras_key);
            if (!own) continue;
            const Role role = read_role(n, own->called(place_of(n) + "/extras/voxshell"));
            const JsonPlace at = nodes[n].called(role.place);
            const std::string &name = stage_.nodes[n].name;
            if (name.empty()) at.refuse("has a role and no name: give it one");
            if (names[name] > 1)
                at.refuse("has a role, and another node of the scene has its name: rename one");
            const auto other = std::ranges::find(roles_, true, &Role::moves);
            if (role.moves && other != roles_.end())
                at.refuse(
                    fmt::format("is dynamic, as {} is: exactly one moves with the device", other->place));
            roles_.push_back(role);
            role_of_[n] = roles_.size() - 1;
        }
        for (const Role &role : roles_)
            if (const Role *above = role_above(role.node))
                nodes[role.node]
                    .called(role.place)
                    .refuse(fmt::format("has a role inside {}, which has one already", above->place));
    }

    Role read_role(std::size_t node, const JsonPlace &own) const
    {
        std::optional<JsonDocument> text;
        const bool is_text = own.is_string() && own.string("").starts_with('{');
        if (is_text) text.emplace(scene_.path, own.string(""), own.pointer());
        const JsonPlace said = text ? text->root() : own;
        const auto moves = [](const JsonPlace &at) { return at.choice({"static", "dynamic"}) == 1; };
        if (said.is_string()) return {node, moves(said), 0, place_of(node)};
        const JsonObject any(said, {"role", "density"});
        Role role{node, moves(any.get("role")), 0, place_of(node)};
        if (const auto density = any.find("density")) {
            if (!role.moves) density->refuse("only of what is dynamic: what stands weighs nothing");
            role.density = read_density(*density);
        }
        return role;
    }

    /// The role nearest above a node, or none.
    const Role *role_above(std::size_t node) const
    {
        for (auto at = stage_.nodes[node].parent; at; at = stage_.nodes[*at].parent)
            if (const auto found = role_of_.find(*at); found != role_of_.end()) return &roles_[found->second];
        return nullptr;
    }

    /// An animation moves a node with a role as a whole, straight from key to key, or nothing of the scene.
    void check_animations()
    {
        std::set<std::size_t> carriers; // what is above a role
        for (const Role &role : roles_)
            for (auto at = stage_.nodes[role.node].parent; at; at = stage_.nodes[*at].parent)
                carriers.insert(*at);
        std::map<std::pair<std::size_t, std::string>, std::size_t> by;
        for (const GltfStage::Channel &channel : stage_.channels) {
            const bool own = role_of_.contains(channel.node);
            const auto refuse = [&](const std::string &why) {
                document_.root()
                    .called(fmt::format("/animations/{}/channels/{}", channel.animation, channel.channel))
                    .refuse(fmt::format("{} {}", place_of(channel.node), why));
            };
            if (carriers.contains(channel.node))
                refuse("carries a part: animate the node with the role itself");
            if (!own && role_above(channel.node))
                refuse("is inside a part, which moves as a whole: animate the node with the role");
            if (!own) continue;
            if (channel.path != "translation" && channel.path != "rotation")
                refuse("may be moved and turned, not have its " + channel.path.substr(0, 40) + " animated");
            if (channel.interpolation != "LINEAR")
                refuse("is animated by " + channel.interpolation.substr(0, 40) +
                       ": only LINEAR goes straight from key to key");
            if (stage_.nodes[channel.node].has_matrix) refuse("is animated and has a matrix");
            if (!by.emplace(std::pair(channel.node, channel.path), channel.animation).second)
                refuse("has its " + channel.path + " animated twice");
        }
    }

    Pose pose_in_scene(const Role &role, const GltfPose &own) const
    {
        const auto parent = stage_.nodes[role.node].parent;
        const auto rigid = rigid_of(parent ? compose(stage_.pose_in_scene(*parent), own) : own);
        if (!rigid)
            document_.root()
                .called(role.place)
                .refuse("is scaled unevenly, sheared or mirrored: apply its scale to its mesh");
        const GltfPose &m = rigid->pose;
        return {{m[3], m[7], m[11]}, quaternion_of(m)};
    }

    /// Keys of both channels together; between keys of one the other is where its own line has it.
    Way way_of(const Role &role) const
    {
        const GltfStage::Node &node = stage_.nodes[role.node];
        const GltfStage::Channel *moves = nullptr, *turns = nullptr;
        for (const GltfStage::Channel &channel : stage_.channels)
            if (channel.node == role.node) (channel.path == "rotation" ? turns : moves) = &channel;
        Way way;
        for (const GltfStage::Channel *channel : {moves, turns})
            if (channel) way.times.insert(way.times.end(), channel->times.begin(), channel->times.end());
        std::ranges::sort(way.times);
        way.times.erase(std::unique(way.times.begin(), way.times.end()), way.times.end());
        for (const double t : way.times) {
            std::array<double, 4> at{}, turn{};
            std::copy_n(node.translation, 3, at.begin());
            std::copy_n(node.rotation, 4, turn.begin());
            if (moves) at = value_at(*moves, 3, t);
            if (turns) turn = value_at(*turns, 4, t);
            if (std::ranges::all_of(turn, [](double x) { return x == 0; }))
                document_.root().called(role.place).refuse("has a rotation of zeros in its animation");
            way.poses.push_back(pose_in_scene(role, from_trs(at.data(), turn.data(), node.scale)));
        }
        return way;
    }

    static std::array<double, 4> value_at(const GltfStage::Channel &channel, std::size_t size, double t)
    {
        const auto next = std::ranges::upper_bound(channel.times, t);
        const auto to = static_cast<std::size_t>(next - channel.times.begin());
        const double *values = channel.values.data();
        std::array<double, 4> out{};
        if (to == 0 || to == channel.times.size() || channel.times[to - 1] == t) {
            std::copy_n(values + size * (to == 0 ? 0 : to - 1), size, out.begin());
            return out;
        }
        const double share = (t - channel.times[to - 1]) / (channel.times[to] - channel.times[to - 1]);
        const double *a = values + size * (to - 1), *b = values + size * to;
        double from = 1 - share, onto = share;
        if (size == 4) { // along the sphere, the short way round (glTF 2.0, C.4)
            const double dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
            const double angle = std::acos(std::min(1.0, std::abs(dot)));
            if (angle > 1e-6) {
                from = std::sin((1 - share) * angle) / std::sin(angle);
                onto = std::sin(share * angle) / std::sin(angle);
            }
            if (dot < 0) onto = -onto;
        }
        for (std::size_t n = 0; n < size; ++n) out[n] = from * a[n] + onto * b[n];
        return out;
    }

    ScenePart part_of(const Role &role) const
    {
        ScenePart part;
        part.file = scene_.path;
        part.import.node = stage_.nodes[role.node].name;
        pose_in_scene(role, stage_.nodes[role.node].pose); // refuses what is none
        return part;
    }

    void check_count(const Role &role, std::size_t count, std::size_t most) const
    {
        if (count > most)
            document_.root()
                .called(role.place)
                .refuse(fmt::format("has {} keys in its animation, at most {} may be", count, most));
    }

    void read_static(const Role &role)
    {
        ScenePart part = part_of(role);
        const Way way = way_of(role);
        check_count(role, way.times.size(), 1 << 14);
        for (std::size_t n = 0; n < way.times.size(); ++n)
            part.path.push_back({way.times[n] + 0.0, way.poses[n]});
        part.stands_as_stored = part.path.empty();
        scene_.statics.push_back(std::move(part));
    }

    /// What moves is where the device is; where its node stands or goes is where the hand does.
    void read_dynamic(const Role &role)
    {
        scene_.dynamic = part_of(role);
        scene_.dynamic.density = role.density;
        const Way way = way_of(role);
        if (!hand_place_.empty()) {
            if (!way.times.empty())
                document_.root()
                    .called(role.place)
                    .refuse("is animated, and " + hand_place_ + " says where the hand goes: leave out one");
            return;
        }
        check_count(role, way.times.size(), 1 << 16);
        for (std::size_t n = 0; n < way.times.size(); ++n)
            scene_.hand.keyframes.push_back({way.times[n] + 0.0, way.poses[n], {}});
        if (way.times.empty())
            scene_.hand.keyframes.push_back({0, pose_in_scene(role, stage_.nodes[role.node].pose), {}});
    }

    const GltfStage stage_;
    const JsonDocument document_;
    const JsonObject root_;
    SceneFile scene_;
    std::string hand_place_; ///< where the extras say it; empty: they do not
    std::vector<Role> roles_;
    std::map<std::size_t, std::size_t> role_of_; ///< node to its place in roles_
};

} // namespace

SceneFile read_gltf_scene(const std::filesystem::path &path)
{
    return GltfScene(path).run();
}

} // namespace voxshell
