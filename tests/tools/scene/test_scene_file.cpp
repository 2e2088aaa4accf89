// SPDX-License-Identifier: GPL-3.0-or-later
// The scene file: what it means, and that every refusal names the place.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "scene/quantity.hpp"
#include "scene/scene_file.hpp"

#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <fstream>
#include <numbers>
#include <unistd.h>

using namespace voxshell;

namespace {

const std::string smallest = R"({"scene": "voxshell-scene/1", "voxel": "2mm", "static": [{"file": "cup.glb"}],
    "dynamic": [{"file": "sphere.glb"}], "hand": {"path": [{"t": "0s", "position": ["75mm", "40mm", "0mm"]}]}})";

/// `text` as a file in a folder of its own.
class Written {
  public:
    explicit Written(const std::string &text)
    {
        char name[] = "/tmp/voxshell-scene-XXXXXX";
        folder_ = mkdtemp(name);
        path = folder_ / "test.scene.json";
        std::ofstream(path) << text;
    }
    ~Written() { std::filesystem::remove_all(folder_); }
    std::filesystem::path path;

  private:
    std::filesystem::path folder_;
};

SceneFile read(const std::string &text)
{
    return read_scene(Written(text).path);
}

std::string refusal(const std::string &text)
{
    try {
        read(text);
    } catch (const Failure &failure) {
        CHECK(failure.code == ExitCode::invalid);
        return failure.what();
    }
    return "accepted";
}

/// The smallest scene with `from` replaced by `to`.
std::string with(const std::string &from, const std::string &to)
{
    std::string text = smallest;
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

} // namespace

TEST_CASE("quantities are rounded once")
{
    CHECK(parse_quantity("2mm", Dimension::length) == 0.002);
    CHECK(parse_quantity("0.3mm", Dimension::length) == 0.0003);
    CHECK(parse_quantity("3e-1 mm", Dimension::length) == 0.0003);
    CHECK(parse_quantity("1E+3um", Dimension::length) == 0.001);
    CHECK(parse_quantity("1in", Dimension::length) == 0.0254);
    CHECK(parse_quantity("1kHz", Dimension::frequency) == 1000.0);
    CHECK(parse_quantity("180deg", Dimension::angle) == std::numbers::pi);
    CHECK(parse_quantity("1N/mm", Dimension::stiffness) == 1000.0);
    for (const char *bad : {"", "2", "mm", "2 m m", "2mm ", " 2mm", "2kg", "nanmm", "infm", "1e400m",
                            "1e99999999999mm", "0x10mm", "2MM", "+2mm"}) {
        CAPTURE(bad);
        CHECK_FALSE(parse_quantity(bad, Dimension::length));
    }
    CHECK_FALSE(parse_quantity("2mm", Dimension::time));
    CHECK(units_of(Dimension::length) == "m, cm, mm, um or in");
}

TEST_CASE("the smallest scene has the documented defaults")
{
    const Written file(smallest);
    const SceneFile scene = read_scene(file.path);
    CHECK(scene.voxel == 0.002);
    REQUIRE(scene.statics.size() == 1);
    CHECK(scene.statics[0].file == file.path.parent_path() / "cup.glb");
    CHECK_FALSE(scene.statics[0].import.unit);
    CHECK(scene.law == ContactLaw::average);
    CHECK(scene.weighting == Weighting::count);
    CHECK(scene.stiffness == 500);
    CHECK(scene.coupling == CouplingKind::pt2);
    CHECK(scene.frequency == 5);
    CHECK(scene.damping == 1);
    CHECK(scene.device == "sim:phantom-premium-1.5");
    CHECK(scene.arm == "hand");
    CHECK(scene.rate == 1000);
    CHECK(scene.hand.at(0).position == Point{0.075, 0.040, 0});
    CHECK(scene.hand.at(1e9).position == Point{0.075, 0.040, 0});
}

TEST_CASE("the samples are scenes")
{
    for (const char *name : {"cup_press", "cup_slide", "cup_hold", "peg_in_hole"}) {
        const SceneFile scene = read_scene(std::filesystem::path(VXS_TEST_SOURCE_DIR) / "samples/scenes" /
                                           (std::string(name) + ".scene.json"));
        CHECK(scene.hand.keyframes.size() >= 3);
    }
}

TEST_CASE("the hand goes straight, turns and rests")
{
    const SceneFile scene = read(with(R"([{"t": "0s", "position": ["75mm", "40mm", "0mm"]}])",
                                      R"([{"t": "1s", "position": ["1m", "2m", "0m"]},
            {"t": "2s", "position": ["3m", "2m", "0m"], "rotation": [0, 0, 2, 2]},
            {"t": "4s", "turn": {"about": ["0m", "2m", "0m"], "axis": [0, 5, 0], "angle": "180deg"}}])"));
    const auto near = [](const Point &a, const Point &b) {
        return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) < 1e-12;
    };
    CHECK(near(scene.hand.at(0).position, {1, 2, 0}));
    CHECK(near(scene.hand.at(1.25).position, {1.5, 2, 0}));
    CHECK(near(scene.hand.at(2).position, {3, 2, 0}));
    CHECK(near(scene.hand.at(3).position, {0, 2, -3})); // +Y from +X is -Z
    CHECK(near(scene.hand.at(4).position, {-3, 2, 0}));
    CHECK(near(scene.hand.at(9).position, {-3, 2, 0}));
    const Quaternion half = scene.hand.at(1.5).rotation; // halfway to 90 degrees about z: 45 degrees
    CHECK(half[2] == doctest::Approx(std::sin(std::numbers::pi / 8)));
    CHECK(half[3] == doctest::Approx(std::cos(std::numbers::pi / 8)));
    CHECK(near(rotate(scene.hand.at(2).rotation, {1, 0, 0}), {0, 1, 0}));
}

TEST_CASE("couplings take their own keys only")
{
    const auto coupled = [](const std::string &text) {
        return with("\"hand\"", "\"coupling\": " + text + ", \"hand\"");
    };
    CHECK(read(coupled(R"({"kind": "none"})")).coupling == CouplingKind::none);
    const SceneFile scene =
        read(coupled(R"({"kind": "spring-damper", "stiffness": "2N/mm", "mass": "50g", "damping": 0.7})"));
    CHECK(scene.spring_stiffness == 2000);
    CHECK(scene.mass == 0.05);
    CHECK(scene.damping == 0.7);
    CHECK(scene.radius == 0.02);
    const SceneFile physical = read(coupled(
        R"({"kind": "pt2", "stiffness": "500N/m", "viscosity": "10Ns/m", "mass": "50g", "gain": "physical", "prewarp": true})"));
    CHECK(physical.by_impedance);
    CHECK(physical.physical_gain);
    CHECK(physical.prewarp);
    CHECK(physical.viscosity == 10);
    const SceneFile still =
        read(coupled(R"({"kind": "quasi-static", "stiffness": "1N/mm", "radius": "3cm", "evaluations": 2})"));
    CHECK(still.coupling == CouplingKind::quasi_static);
    CHECK(still.radius == 0.03);
    CHECK(still.evaluations == 2);
    const SceneFile designed = read(coupled(R"({"kind": "pt2", "design": "auto", "assume": "hand"})"));
    CHECK(designed.design);
    CHECK(designed.assume == "hand");
    CHECK(read(coupled(R"({"kind": "quasi-static", "design": "auto"})")).assume.empty());
    const SceneFile any = read(coupled(
        R"({"design": "auto", "assume": "pen", "prewarp": true, "radius": "1cm", "evaluations": 1})"));
    CHECK(any.coupling == CouplingKind::designed);
    CHECK(any.design);
    CHECK(any.assume == "pen");
    CHECK(any.prewarp);
    CHECK(any.radius == 0.01);
    CHECK(any.evaluations == 1);
    CHECK(refusal(coupled(R"({"design": "auto", "stiffness": "1N/m"})"))
              .starts_with("/coupling/stiffness: unknown key"));
    CHECK(refusal(coupled(R"({"assume": "hand"})")) == "/coupling: lacks \"kind\"");
    CHECK(refusal(coupled(R"({"kind": "designed", "design": "auto"})"))
              .starts_with("/coupling/kind: \"designed\" is not none, pt2"));
    CHECK(refusal(coupled(R"({"kind": "pt2", "design": "auto", "frequency": "5Hz"})"))
              .starts_with("/coupling/frequency: unknown key"));
    CHECK(refusal(coupled(R"({"kind": "pt2", "design": "auto", "assume": "foot"})"))
              .starts_with("/coupling/assume: \"foot\" is not free, pen"));
    CHECK(refusal(coupled(R"({"kind": "pt2", "frequency": "5Hz", "damping": 1, "prewarp": 1})")) ==
          "/coupling/prewarp: must be true or false");
    CHECK(refusal(coupled(R"({"kind": "pt2", "mass": "1kg", "stiffness": "1N/m"})")) ==
          "/coupling: lacks \"viscosity\"");
    CHECK(refusal(coupled(R"({"kind": "quasi-static", "stiffness": "1N/m", "evaluations": 4})")) ==
          "/coupling/evaluations: must be 1, 2 or 3");
    CHECK(
        refusal(
            coupled(
                R"({"kind": "spring-damper", "stiffness": "1N/m", "mass": "1g", "damping": 1, "design": "auto"})"))
            .starts_with("/coupling/design: unknown key"));
    CHECK(
        refusal(coupled(R"({"kind": "none", "damping": 1})")).starts_with("/coupling/damping: unknown key"));
    CHECK(refusal(coupled(R"({"kind": "pt2", "damping": 1})")) == "/coupling: lacks \"frequency\"");
    CHECK(refusal(coupled(R"({"kind": "pt2", "frequency": "5Hz", "damping": 0})")) ==
          "/coupling/damping: must be above zero");
}

TEST_CASE("parts")
{
    const SceneFile scene =
        read(with(R"({"file": "cup.glb"})", R"({"file": "a/cup.stl", "unit": "mm", "up": "z",
        "pose": {"position": ["1mm", "0m", "0m"], "rotation": [1, 0, 0, 1]}})"));
    CHECK(scene.statics[0].import.unit == 0.001);
    CHECK(scene.statics[0].import.z_up);
    CHECK(scene.statics[0].pose.position[0] == 0.001);
    CHECK(scene.statics[0].pose.rotation[0] == doctest::Approx(std::sqrt(0.5)));
}

TEST_CASE("guards: safe by default, a list replaces them")
{
    const auto guarded = [](const std::string &list) {
        return with("\"hand\"", "\"guards\": " + list + ", \"hand\"");
    };
    const auto find = [](const SceneFile &scene, std::uint32_t kind) -> const SceneEffect * {
        for (const SceneEffect &effect : scene.effects) {
            if (effect.effect.kind == kind) return &effect;
        }
        return nullptr;
    };
    SceneFile scene = read(smallest);
    REQUIRE(scene.effects.size() == 2);
    CHECK(find(scene, VXS_EFFECT_START_INSIDE));
    CHECK(find(scene, VXS_EFFECT_SOFT_START)->effect.as.soft_start.time == 0.5);
    CHECK(read(guarded("[]")).effects.empty());
    scene = read(guarded(R"([{"kind": "slew"}, {"kind": "passivity"}, {"kind": "soft-start"}])"));
    CHECK(!find(scene, VXS_EFFECT_START_INSIDE));
    CHECK(find(scene, VXS_EFFECT_SOFT_START)->effect.as.soft_start.time == 0.5);
    CHECK(find(scene, VXS_EFFECT_SLEW)->effect.as.slew.force == 0);
    CHECK(find(scene, VXS_EFFECT_PASSIVITY)->said == 0);
    CHECK(find(scene, VXS_EFFECT_PASSIVITY)->effect.as.passivity.least_speed == 0.001);
    scene = read(guarded(
        R"([{"kind": "slew", "force": "2N/ms", "torque": "50Nm/s"}, {"kind": "soft-start", "time": "200ms"},
        {"kind": "passivity", "most_damping": "3Ns/m", "radius": "20mm", "delay": 2}, {"kind": "start-inside"}])"));
    CHECK(find(scene, VXS_EFFECT_START_INSIDE));
    CHECK(find(scene, VXS_EFFECT_SOFT_START)->effect.as.soft_start.time == 0.2);
    CHECK(find(scene, VXS_EFFECT_SLEW)->effect.as.slew.force == 2000);
    CHECK(find(scene, VXS_EFFECT_SLEW)->effect.as.slew.torque == 50);
    const SceneEffect &passivity = *find(scene, VXS_EFFECT_PASSIVITY);
    CHECK(passivity.effect.as.passivity.most_damping == 3);
    CHECK(passivity.effect.as.passivity.radius == 0.02);
    CHECK(passivity.effect.as.passivity.delay == 2);
    CHECK(passivity.place == "/guards/2");
    CHECK(passivity.said == 0b1101u);
    CHECK(refusal(guarded(R"([{"kind": "slow-start"}])"))
              .starts_with("/guards/0/kind: \"slow-start\" is not "));
    CHECK(refusal(guarded(R"([{}])")) == "/guards/0: lacks \"kind\"");
    CHECK(refusal(guarded(R"([{"kind": "soft-start"}, {"kind": "soft-start"}])")) ==
          "/guards/1/kind: is there already");
    CHECK(refusal(guarded(R"([{"kind": "start-inside", "time": "1s"}])"))
              .starts_with("/guards/0/time: unknown key"));
    CHECK(refusal(guarded(R"([{"kind": "slew", "force": "2N"}])")) ==
          "/guards/0/force: \"2N\" is not a number with a unit of N/s or N/ms");
    CHECK(refusal(guarded(R"([{"kind": "soft-start", "time": "-1s"}])")) ==
          "/guards/0/time: must be 0s to 3600s");
    CHECK(refusal(guarded(R"([{"kind": "passivity", "damping": "1Ns/m"}])")) ==
          "/guards/0/damping: unknown key; did you mean \"most_damping\"?");
    CHECK(refusal(guarded(R"([{"kind": "passivity", "most_damping": "0Ns/m"}])")) ==
          "/guards/0/most_damping: must be 1e-12Ns/m to 1e+12Ns/m");
    CHECK(refusal(guarded(R"({"kind": "slew"})")).starts_with("/guards: must be a list"));
    const auto effects = [](const std::string &list) {
        return with("\"hand\"", "\"effects\": " + list + ", \"hand\"");
    };
    CHECK(refusal(effects(R"([{"kind": "slew"}])")) ==
          "/effects/0/kind: is a guard: it belongs into \"guards\"");
    CHECK(refusal(effects(R"([{"kind": 7}])")).starts_with("/effects/0/kind: must be "));
}

TEST_CASE("a scene can say each constant of each kind, by default value, and not what is beyond its range")
{
    for (std::uint32_t n = 0, kind; (kind = vxs_effect_kind_at(n)) != 0; ++n) {
        const std::string list = vxs_effect_is_guard(kind) ? "guards" : "effects",
                          name = vxs_effect_kind_name(kind);
        std::uint32_t count = 0;
        const vxs_effect_constant *constants = vxs_effect_constants(kind, &count);
        for (std::uint32_t c = 0; c < count; ++c) {
            CAPTURE(name);
            CAPTURE(constants[c].name);
            const std::string unit = constants[c].unit;
            REQUIRE((unit.empty() || dimension_of(unit)));
            std::string key = constants[c].name;
            const bool is_vector = key.size() > 2 && key.ends_with("_x");
            if (key.size() > 2 && (key.ends_with("_y") || key.ends_with("_z"))) continue;
            const auto value = [&](double x, std::uint32_t at) {
                return unit.empty() ? fmt::format("{}", x) : fmt::format("\"{}{}\"", x, constants[at].unit);
            };
            const auto scene = [&](double x) {
                const std::string said = is_vector ? fmt::format("[{}, {}, {}]", value(x, c),
                                                                 value(constants[c + 1].standard, c + 1),
                                                                 value(constants[c + 2].standard, c + 2))
                                                   : value(x, c);
                std::string text =
                    with("\"hand\"", fmt::format(R"("{}": [{{"kind": "{}", "{}": {}}}], "hand")", list, name,
                                                 is_vector ? key.substr(0, key.size() - 2) : key, said));
                const std::string still = R"({"file": "cup.glb"})";
                const std::string goes =
                    R"(, {"file": "a.glb", "path": [{"t": "0s", "position": ["0m", "0m", "0m"]}]})";
                return kind == VXS_EFFECT_MOTION ? text.insert(text.find(still) + still.size(), goes) : text;
            };
            const SceneFile read_back = read(scene(constants[c].standard));
            const SceneEffect &effect = read_back.effects.back();
            CHECK(effect.effect.kind == kind);
            CHECK(effect.says(c));
            CHECK(effect.effect.as.constants[c] == constants[c].standard);
            CHECK(refusal(scene(constants[c].most * 2 + 1)).find(": must be ") != std::string::npos);
        }
    }
}

TEST_CASE("laws and fields")
{
    const auto contact = [](const std::string &text) {
        return read(with("\"hand\"", R"("contact": {"stiffness": "1N/m", )" + text + R"(}, "hand")"));
    };
    CHECK(contact(R"("law": "patch")").field == ContactField::surface);
    CHECK(contact(R"("law": "gradient")").field == ContactField::distance);
    CHECK(contact(R"("law": "gradient", "field": "distance")").law == ContactLaw::gradient);
    const SceneFile scene = contact(R"("law": "patch", "field": "layers", "most_stiffness": "5N/mm")");
    CHECK(scene.law == ContactLaw::patch);
    CHECK(scene.field == ContactField::layers);
    CHECK(scene.most_stiffness == 5000);
}

TEST_CASE("every refusal names the place and the fix")
{
    CHECK(refusal(with("\"voxel\"", "\"voxle\"")) == "/voxle: unknown key; did you mean \"voxel\"?");
    CHECK(refusal(with("\"t\": \"0s\", ", "")) == "/hand/path/0: lacks \"t\"");
    CHECK(refusal(with("\"2mm\"", "2")) ==
          "/voxel: must be a number with its unit in quotes (m, cm, mm, um or in)");
    CHECK(refusal(with("\"2mm\"", "\"2s\"")) ==
          "/voxel: \"2s\" is not a number with a unit of m, cm, mm, um or in");
    CHECK(refusal(with("\"2mm\"", "\"0mm\"")) == "/voxel: must be above zero");
    CHECK(refusal(with("\"0mm\"", "\"0Hz\"")) ==
          "/hand/path/0/position/2: \"0Hz\" is not a number with a unit of m, cm, mm, um or in");
    CHECK(refusal(with("cup.glb", "../cup.glb")) ==
          "/static/0/file: must be a relative path inside the scene's folder");
    CHECK(refusal(with("cup.glb", "/etc/passwd")) ==
          "/static/0/file: must be a relative path inside the scene's folder");
    CHECK(refusal(with("scene/1", "scene/2")) ==
          "/scene: \"voxshell-scene/2\" is not a version that this voxshell reads: voxshell-scene/1");
    CHECK(refusal(with("{\"file\": \"sphere.glb\"}", "")) == "/dynamic: must be a list of 1");
    CHECK(refusal(with("\"hand\"", R"("contact": {"law": "patches", "stiffness": "1N/m"}, "hand")")) ==
          "/contact/law: \"patches\" is not original, average, patch or gradient");
    for (const char *field : {"surface", "layers"}) {
        CHECK(refusal(with("\"hand\"", R"("contact": {"law": "gradient", "stiffness": "1N/m", "field": ")" +
                                           std::string(field) + R"("}, "hand")")) ==
              "/contact/field: law gradient takes its direction from field distance; original, average and "
              "patch work with any field");
    }
    CHECK(refusal(with("\"hand\"", R"("contact": {"weighting": "area", "stiffness": "1N/m"}, "hand")")) ==
          "/contact/stiffness: \"1N/m\" is not a number with a unit of N/m^3 or N/mm^3");
    CHECK(refusal(with("\"hand\"", R"("voxel": "1mm", "hand")")) ==
          "key \"voxel\" occurs twice in one object");
    CHECK(refusal(with("\"position\": [\"75mm\", \"40mm\", \"0mm\"]",
                       R"("turn": {"about": ["0m", "0m", "0m"], "axis": [0, 1, 0], "angle": "1deg"})"))
              .starts_with("/hand/path/0/turn: "));
}

TEST_CASE("hostile text is refused")
{
    CHECK(refusal("").starts_with("not JSON: "));
    CHECK(refusal("[]") == "/: must be an object {...}");
    CHECK(refusal("null") == "/: must be an object {...}");
    CHECK(refusal("{\"" + std::string(100000, 'x') + "\": 1}").size() < 200);
    CHECK(refusal(std::string(1000000, '[')) == "nested deeper than 16");
    CHECK(refusal(with("40mm", std::string("40\\u0000mm"))) != "accepted");
    CHECK(refusal(with("\"voxel\": \"2mm\"", "\"voxel\": 1e999")).starts_with("not JSON: "));
    for (std::size_t n = 0; n < smallest.size(); ++n) { // every prefix
        CHECK(refusal(smallest.substr(0, n)) != "accepted");
    }
    CHECK_THROWS_AS(read_scene("/nonexistent/x.scene.json"), Failure);
    CHECK_THROWS_AS(read_scene("/"), Failure);
}
