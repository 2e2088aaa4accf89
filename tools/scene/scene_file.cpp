// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene_file.hpp"

#include "scene/effect_reader.hpp"
#include "scene/scene_keys.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace voxshell {
namespace {

constexpr double micrometre = 1e-6;

double positive(const JsonPlace &at, Dimension dimension)
{
    const double value = at.quantity(dimension);
    if (!(value > 0)) {
        at.refuse("must be above zero");
    }
    return value;
}

Point lengths(const JsonPlace &at)
{
    const auto items = at.items(3, 3);
    return {items[0].quantity(Dimension::length), items[1].quantity(Dimension::length),
            items[2].quantity(Dimension::length)};
}

/// N numbers as a unit vector.
template<std::size_t N>
std::array<double, N> direction(const JsonPlace &at)
{
    const auto items = at.items(N, N);
    std::array<double, N> v;
    double largest = 0;
    for (std::size_t n = 0; n < N; ++n) {
        v[n] = items[n].number();
        largest = std::max(largest, std::abs(v[n]));
    }
    if (!(largest > 0)) {
        at.refuse("has no direction: all zero");
    }
    double square = 0;
    for (double &x : v) {
        x /= largest; // no overflow of the square
        square += x * x;
    }
    for (double &x : v) {
        x /= std::sqrt(square);
    }
    return v;
}

Quaternion rotation(const JsonObject &object)
{
    const auto found = object.find("rotation");
    return found ? direction<4>(*found) : Quaternion{0, 0, 0, 1};
}

/// In any case of letters.
bool has_ending(const std::filesystem::path &name, std::string_view ending)
{
    std::string own = name.extension().string();
    for (char &c : own) {
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    }
    return own == ending;
}

ScenePart part(const JsonPlace &at, const std::filesystem::path &folder, bool moves)
{
    std::vector<std::string_view> keys{"file", "node", "unit", "up", "pose"};
    keys.push_back(moves ? "density" : "path");
    const JsonObject object(at, keys);
    ScenePart result;
    const JsonPlace file = object.get("file");
    const std::filesystem::path name = file.string("a file name");
    // What a scene may open is its own folder: it can be passed on, and it cannot read what it should not.
    if (name.empty() || name.is_absolute() || name.native().find('\0') != std::string::npos ||
        std::any_of(name.begin(), name.end(), [](const auto &step) { return step == ".."; })) {
        file.refuse("must be a relative path inside the scene's folder");
    }
    result.file = folder / name;
    std::error_code error; // what is not there is told by who opens it
    const auto home = std::filesystem::canonical(folder.empty() ? "." : folder, error);
    const auto found = error ? home : std::filesystem::canonical(result.file, error);
    if (!error && std::mismatch(home.begin(), home.end(), found.begin(), found.end()).first != home.end())
        file.refuse("is a link that leads out of the scene's folder");
    if (const auto unit = object.find("unit")) {
        const auto metres =
            parse_quantity(fmt::format("1{}", unit->string("mm, cm, m or in")), Dimension::length);
        if (!metres) {
            unit->refuse("must be one of " + units_of(Dimension::length));
        }
        result.import.unit = *metres;
    }
    const FileFormat *format = format_of(name);
    const bool lacks_unit = format && !format->has_unit;
    if (object.find("unit") && !lacks_unit) {
        object.get("unit").refuse("only for STL, glTF is in metres");
    }
    if (lacks_unit && !result.import.unit) {
        at.refuse("lacks \"unit\": an STL file has none; say \"unit\": \"mm\"");
    }
    if (const auto node = object.find("node")) {
        if (format && !format->has_nodes) node->refuse("only of glTF: an STL file has no nodes");
        if (const auto up = object.find("up")) up->refuse("not with a node: its file says how it stands");
        result.import.node = node->string("the name of a node");
        if (result.import.node.empty()) node->refuse("must be the name of a node");
    }
    if (const auto path = object.find("path")) {
        if (object.find("pose")) path->refuse("says itself where the part is: leave out pose or path");
        for (const JsonPlace &item : path->items(1, 1 << 14)) {
            const JsonObject fields(item, {"t", "position", "rotation"});
            const JsonPlace time = fields.get("t");
            const double t = time.quantity(Dimension::time);
            if (t < 0 || (!result.path.empty() && t <= result.path.back().t)) {
                time.refuse("must be later than the one before it, and not before 0s");
            }
            result.path.push_back({t + 0.0, {lengths(fields.get("position")), rotation(fields)}});
        }
    }
    if (const auto density = object.find("density")) {
        result.density = positive(*density, Dimension::density);
    }
    if (const auto up = object.find("up")) {
        result.import.z_up = up->choice({"y", "z"}) == 1;
    }
    if (const auto placed = object.find("pose")) {
        const JsonObject fields(*placed, {"position", "rotation"});
        if (const auto position = fields.find("position")) {
            result.pose.position = lengths(*position);
        }
        result.pose.rotation = rotation(fields);
    } else if (!moves && result.path.empty()) {
        result.stands_as_stored = !result.import.node.empty();
    }
    return result;
}

void contact(const JsonPlace &at, SceneFile &scene)
{
    const JsonObject object(at, {"law", "field", "weighting", "stiffness", "most_stiffness", "budget"});
    if (const auto law = object.find("law")) {
        scene.law = static_cast<ContactLaw>(law->choice({"original", "average", "patch", "gradient"}));
        if (scene.law == ContactLaw::gradient) {
            scene.field = ContactField::distance;
        }
    }
    if (const auto field = object.find("field")) {
        scene.field = static_cast<ContactField>(field->choice({"surface", "layers", "distance"}));
        if (scene.law == ContactLaw::gradient && scene.field != ContactField::distance) {
            field->refuse("law gradient takes its direction from field distance; original, average and patch "
                          "work with any field");
        }
    }
    if (const auto weighting = object.find("weighting")) {
        scene.weighting = static_cast<Weighting>(weighting->choice({"count", "count-capped", "area"}));
    }
    scene.stiffness =
        positive(object.get("stiffness"),
                 scene.weighting == Weighting::area ? Dimension::foundation : Dimension::stiffness);
    if (const auto most = object.find("most_stiffness")) {
        scene.most_stiffness = positive(*most, Dimension::stiffness);
    }
    if (const auto budget = object.find("budget")) {
        if (scene.weighting != Weighting::area) {
            budget->refuse("fewer points weigh the same only with weighting area");
        }
        scene.budget = positive(*budget, Dimension::time);
    }
}

/// The ratio of a coupling's damping.
double ratio(const JsonPlace &at)
{
    const double value = at.number();
    if (!(value > 0)) {
        at.refuse("must be above zero");
    }
    return value;
}

void designed(const JsonObject &object, SceneFile &scene)
{
    object.get("design").choice({"auto"});
    scene.design = true;
    if (const auto assume = object.find("assume")) {
        constexpr const char *arms[] = {"free", "pen", "hand", "arm"};
        scene.assume = arms[assume->choice({"free", "pen", "hand", "arm"})];
    }
}

/// Of a body that is not the device.
void solver(const JsonObject &any, SceneFile &scene)
{
    if (const auto found = any.find("radius")) {
        scene.radius = positive(*found, Dimension::length);
    }
    if (const auto found = any.find("evaluations")) {
        const double count = found->number();
        if (count != 1 && count != 2 && count != 3) {
            found->refuse("must be 1, 2 or 3");
        }
        scene.evaluations = static_cast<unsigned>(count);
    }
}

void pt2(const JsonPlace &at, const JsonObject &any, SceneFile &scene)
{
    if (any.find("design")) {
        designed(JsonObject(at, {"kind", "design", "assume", "prewarp"}), scene);
    } else if (any.find("mass") || any.find("viscosity") || any.find("stiffness")) {
        const JsonObject object(at, {"kind", "stiffness", "viscosity", "mass", "gain", "prewarp"});
        scene.by_impedance = true;
        scene.spring_stiffness = positive(object.get("stiffness"), Dimension::stiffness);
        scene.viscosity = positive(object.get("viscosity"), Dimension::damping);
        scene.mass = positive(object.get("mass"), Dimension::mass);
        const auto gain = object.find("gain");
        scene.physical_gain = gain && gain->choice({"unity", "physical"}) == 1;
    } else {
        const JsonObject object(at, {"kind", "frequency", "damping", "prewarp"});
        scene.frequency = positive(object.get("frequency"), Dimension::frequency);
        scene.damping = ratio(object.get("damping"));
    }
    const auto prewarp = any.find("prewarp");
    scene.prewarp = prewarp && prewarp->boolean();
}

void quasi_static(const JsonPlace &at, const JsonObject &any, SceneFile &scene)
{
    if (any.find("design")) {
        designed(JsonObject(at, {"kind", "design", "assume", "radius", "evaluations"}), scene);
    } else {
        const JsonObject object(at, {"kind", "stiffness", "radius", "evaluations"});
        scene.spring_stiffness = positive(object.get("stiffness"), Dimension::stiffness);
    }
    solver(any, scene);
}

void coupling(const JsonPlace &at, SceneFile &scene)
{
    const JsonObject any(at, {"kind", "design", "assume", "frequency", "damping", "prewarp", "gain",
                              "stiffness", "viscosity", "mass", "radius", "evaluations"});
    const auto kind = any.find("kind");
    if (!kind && any.find("design")) {
        scene.coupling = CouplingKind::designed;
        designed(JsonObject(at, {"design", "assume", "prewarp", "radius", "evaluations"}), scene);
        const auto prewarp = any.find("prewarp");
        scene.prewarp = prewarp && prewarp->boolean();
        solver(any, scene);
        return;
    }
    scene.coupling =
        static_cast<CouplingKind>(any.get("kind").choice({"none", "pt2", "spring-damper", "quasi-static"}));
    switch (scene.coupling) {
    case CouplingKind::none:
        JsonObject(at, {"kind"});
        return;
    case CouplingKind::pt2:
        pt2(at, any, scene);
        return;
    case CouplingKind::designed:
        break; // no choice gives it
    case CouplingKind::quasi_static:
        quasi_static(at, any, scene);
        return;
    case CouplingKind::spring_damper: {
        const JsonObject object(at, {"kind", "stiffness", "mass", "damping", "radius"});
        scene.spring_stiffness = positive(object.get("stiffness"), Dimension::stiffness);
        scene.mass = positive(object.get("mass"), Dimension::mass);
        scene.damping = ratio(object.get("damping"));
        solver(any, scene);
    }
    }
}

Point turned(const HandPath::Keyframe::Turn &turn, const Point &from, double share)
{
    const double half = turn.angle * share / 2;
    const double s = std::sin(half);
    const Quaternion q{turn.axis[0] * s, turn.axis[1] * s, turn.axis[2] * s, std::cos(half)};
    const Point arm = rotate(q, {from[0] - turn.about[0], from[1] - turn.about[1], from[2] - turn.about[2]});
    return {turn.about[0] + arm[0], turn.about[1] + arm[1], turn.about[2] + arm[2]};
}

HandPath hand(const JsonPlace &at)
{
    const JsonObject object(at, {"path"});
    HandPath path;
    for (const JsonPlace &item : object.get("path").items(1, 1 << 16)) {
        const JsonObject fields(item, {"t", "position", "rotation", "turn"});
        HandPath::Keyframe keyframe{};
        const JsonPlace time = fields.get("t");
        keyframe.t = time.quantity(Dimension::time);
        if (keyframe.t < 0 || (!path.keyframes.empty() && keyframe.t <= path.keyframes.back().t)) {
            time.refuse("must be later than the keyframe before it, and not before 0s");
        }
        if (const auto turn = fields.find("turn")) {
            if (path.keyframes.empty()) {
                turn->refuse("the first keyframe has nowhere to turn from: give it a position");
            }
            const JsonObject arc(*turn, {"about", "axis", "angle"});
            keyframe.turn = HandPath::Keyframe::Turn{lengths(arc.get("about")), direction<3>(arc.get("axis")),
                                                     arc.get("angle").quantity(Dimension::angle)};
            if (const auto position = fields.find("position")) {
                position->refuse("a turn says itself where it ends: leave out position or turn");
            }
            keyframe.pose.position = turned(*keyframe.turn, path.keyframes.back().pose.position, 1);
        } else {
            keyframe.pose.position = lengths(fields.get("position"));
        }
        keyframe.pose.rotation = rotation(fields);
        path.keyframes.push_back(keyframe);
    }
    return path;
}

} // namespace

Point rotate(const Quaternion &q, const Point &v)
{
    // v + 2 w (u x v) + 2 u x (u x v), u = (x, y, z)
    const auto cross = [](const Point &a, const Point &b) -> Point {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    const Point u{q[0], q[1], q[2]};
    const Point t = cross(u, v);
    const Point s = cross(u, t);
    return {v[0] + 2 * (q[3] * t[0] + s[0]), v[1] + 2 * (q[3] * t[1] + s[1]),
            v[2] + 2 * (q[3] * t[2] + s[2])};
}

Pose HandPath::at(double t) const
{
    const auto next =
        std::upper_bound(keyframes.begin(), keyframes.end(), t,
                         [](double time, const Keyframe &keyframe) { return time < keyframe.t; });
    if (next == keyframes.begin()) {
        return keyframes.front().pose;
    }
    if (next == keyframes.end()) {
        return keyframes.back().pose;
    }
    const Keyframe &from = *(next - 1);
    const double share = (t - from.t) / (next->t - from.t);
    Pose result;
    if (next->turn) {
        result.position = turned(*next->turn, from.pose.position, share);
    } else {
        for (std::size_t n = 0; n < 3; ++n) {
            result.position[n] =
                from.pose.position[n] + share * (next->pose.position[n] - from.pose.position[n]);
        }
    }
    // Normalised linear interpolation the short way round: keyframes of a hand are near each other.
    const Quaternion &a = from.pose.rotation, &b = next->pose.rotation;
    const double sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
    double square = 0;
    for (std::size_t n = 0; n < 4; ++n) {
        result.rotation[n] = a[n] + share * (sign * b[n] - a[n]);
        square += result.rotation[n] * result.rotation[n];
    }
    for (double &x : result.rotation) {
        x /= std::sqrt(square); // at least 1/2: the angle between a and sign * b is at most a right one
    }
    return result;
}

void read_keys(const JsonObject &object, SceneFile &scene)
{
    const JsonPlace version = object.get("scene");
    if (const std::string text = version.string("voxshell-scene/1"); text != "voxshell-scene/1") {
        version.refuse("\"" + text + "\" is not a version that this voxshell reads: voxshell-scene/1");
    }
    const JsonPlace voxel = object.get("voxel");
    scene.voxel = positive(voxel, Dimension::length);
    if (scene.voxel < micrometre / 1000 || scene.voxel > 1000) {
        voxel.refuse("must be between 0.001um and 1000m");
    }
    if (const auto found = object.find("contact")) {
        contact(*found, scene);
    }
    if (const auto found = object.find("coupling")) {
        coupling(*found, scene);
    }
    scene.effects = read_effects(object.find("guards"), object.find("effects"));
    if (const auto found = object.find("device")) {
        scene.device = found->string("a device, as sim:phantom-premium-1.5");
    }
    if (const auto found = object.find("arm")) {
        constexpr const char *arms[] = {"free", "pen", "hand", "arm"};
        scene.arm = arms[found->choice({"free", "pen", "hand", "arm"})];
    }
    if (const auto found = object.find("rate")) {
        scene.rate = positive(*found, Dimension::frequency);
        if (scene.rate < 10 || scene.rate > 1e5) {
            found->refuse("must be between 10Hz and 100kHz");
        }
    }
    if (const auto found = object.find("hand")) scene.hand = hand(*found);
}

double read_density(const JsonPlace &at)
{
    return positive(at, Dimension::density);
}

void ask_for_motion(const JsonPlace &statics, SceneFile &scene)
{
    const auto goes = [](const ScenePart &part) { return !part.path.empty(); };
    const auto asked = std::ranges::find(scene.effects, std::uint32_t{VXS_EFFECT_MOTION},
                                         [](const SceneEffect &e) { return e.effect.kind; });
    if (std::ranges::none_of(scene.statics, goes)) {
        if (asked != scene.effects.end())
            statics.refuse(asked->place +
                           " asks for motion, and no part says where it goes: give one a \"path\"" +
                           (is_gltf_scene(scene.path) ? " (animate its node)" : ""));
        return;
    }
    if (std::ranges::all_of(scene.statics, goes))
        statics.refuse("at least one part must stand: one without a \"path\"");
    if (asked == scene.effects.end()) {
        SceneEffect motion;
        motion.place = statics.pointer();
        vxs_effect_default(VXS_EFFECT_MOTION, &motion.effect);
        scene.effects.push_back(motion);
    }
}

bool is_gltf_scene(const std::filesystem::path &path)
{
    return has_ending(path, ".gltf") || has_ending(path, ".glb");
}

bool is_scene(const std::filesystem::path &path)
{
    const std::filesystem::path stem = path.stem();
    return (has_ending(path, ".json") || is_gltf_scene(path)) && stem.extension() == ".scene" &&
           !stem.stem().empty();
}

std::string meant_scene(const std::filesystem::path &path)
{
    std::error_code ignored;
    for (const char *ending : {".scene.json", ".json", ".scene.gltf", ".gltf", ".scene.glb", ".glb"}) {
        const std::filesystem::path whole = path.string() + ending;
        if (is_scene(whole) && std::filesystem::exists(whole, ignored))
            return "; did you mean " + whole.string() + "?";
    }
    return "";
}

std::string scene_name(const std::filesystem::path &path)
{
    return path.stem().stem().string();
}

SceneFile read_scene(const std::filesystem::path &path)
{
    if (is_gltf_scene(path)) return read_gltf_scene(path);
    const JsonDocument document(path);
    std::vector<std::string_view> keys{"static", "dynamic"};
    keys.insert(keys.begin(), std::begin(scene_keys), std::end(scene_keys));
    const JsonObject object(document.root(), keys);
    SceneFile scene;
    scene.path = path;
    scene.source_hash = document.source_hash();
    read_keys(object, scene);
    const std::filesystem::path folder = path.parent_path();
    for (const JsonPlace &item : object.get("static").items(1, 1 << 16)) {
        scene.statics.push_back(part(item, folder, false));
    }
    scene.dynamic = part(object.get("dynamic").items(1, 1)[0], folder, true);
    ask_for_motion(object.get("static"), scene);
    object.get("hand");
    return scene;
}

} // namespace voxshell
