// SPDX-License-Identifier: GPL-3.0-or-later
// From a CAD file to a newton: the cup and the sphere at 0.5 mm, against geometry.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "container/asset_file.hpp"
#include "pipeline/convert_scene.hpp"
#include "pipeline/output.hpp"
#include "plan/scene_plan.hpp"
#include "study/servo_run.hpp"
#include "study/temporary_folder.hpp"

#include "voxshell/contact.h"
#include "voxshell/servo.h"

#include <cmath>
#include <cstdlib>
#include <numbers>

using namespace voxshell;

namespace {

constexpr double wall = 0.040, radius = 0.015, voxel = 0.0005; // [m]
constexpr double degree = std::numbers::pi / 180;

SceneFile cup_scene()
{
    const char *build = std::getenv("VOXSHELL_BUILD");
    REQUIRE(build != nullptr);
    SceneFile scene = read_scene(std::filesystem::path(build) / "samples/cup_press.scene.json");
    scene.voxel = voxel;
    return scene;
}

/// The scene's assets, through files, opened by the runtime.
struct Assets {
    explicit Assets(ContactLaw law = ContactLaw::average)
    {
        Progress silent;
        SceneFile scene = cup_scene();
        scene.law = law;
        if (law == ContactLaw::gradient) {
            scene.field = ContactField::distance;
            scene.weighting = Weighting::area; // else the shell has no areas
        }
        const SceneParts parts = convert_scene(scene, read_geometry(scene), PartOptions{}, silent);
        Outputs outputs(false);
        outputs.add(folder.path / "cup.voxmap", parts.statics.voxmap);
        outputs.add(folder.path / "sphere.pointshell", parts.dynamic.pointshell);
        outputs.commit();
        map_file = std::make_unique<AssetFile>(folder.path / "cup.voxmap", VXS_ASSET_VOXMAP);
        shell_file = std::make_unique<AssetFile>(folder.path / "sphere.pointshell", VXS_ASSET_POINTSHELL);
        REQUIRE(vxs_voxmap_open(&map_file->asset(), &map) == VXS_OK);
        REQUIRE(vxs_pointshell_open(&shell_file->asset(), &shell) == VXS_OK);
        memory.resize(vxs_contact_memory(&shell, 1) / sizeof(std::max_align_t) + 1);
        REQUIRE(vxs_contact_init(memory.data(), memory.size() * sizeof(std::max_align_t), &shell, 1,
                                 &contact) == VXS_OK);
    }

    /// The sphere at `gap` from the outer wall (negative: pressed in), at this angle about the cup's axis.
    vxs_contact_result at(double angle, double height, double gap, std::uint32_t law) const
    {
        vxs_contact_config config;
        vxs_contact_config_default(&config);
        config.law = law;
        if (law == VXS_CONTACT_GRADIENT) {
            config.field = VXS_CONTACT_DISTANCE;
            config.weighting = VXS_CONTACT_AREA;
        }
        const double r = wall + radius + gap;
        const vxs_pose pose = {{r * std::cos(angle), height, r * std::sin(angle)}, {1, 0, 0, 0}};
        vxs_contact_result result;
        const vxs_contact_static statics = {&map, nullptr};
        const std::uint32_t flags = vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &result);
        REQUIRE((flags & VXS_CONTACT_INVALID) == 0);
        return result;
    }

    TemporaryFolder folder;
    std::unique_ptr<AssetFile> map_file, shell_file;
    vxs_voxmap map{};
    vxs_pointshell shell{};
    vxs_contact *contact = nullptr;
    std::vector<std::max_align_t> memory;
};

const Assets &assets()
{
    static const Assets once;
    return once;
}

double length(const double v[3])
{
    return std::hypot(v[0], v[1], v[2]);
}

/// Angle number n of 64 round the cup, where the wall lies askew in the grid: 15 to 75 degrees from an axis.
double oblique(int n)
{
    return (90 * (n % 4) + 15 + 60.0 / 15 * (n / 4)) * degree;
}

} // namespace

TEST_CASE("pressed 0.2 mm against the wall, the force is along the wall's normal within 5 degrees")
{
    double worst = 0, least = 1e9, most = 0;
    for (int n = 0; n < 64; ++n) {
        const double angle = oblique(n), height = 0.030 + 0.00037 * n;
        const vxs_contact_result result = assets().at(angle, height, -0.0002, VXS_CONTACT_AVERAGE);
        const double force = length(result.wrench.force);
        CAPTURE(n);
        REQUIRE(force > 0);
        const double along =
            (result.wrench.force[0] * std::cos(angle) + result.wrench.force[2] * std::sin(angle)) / force;
        const double off = std::acos(std::min(1.0, along)) / degree;
        CHECK(off < 5);
        CHECK((result.flags & VXS_CONTACT_INVALID) == 0);
        CHECK(length(result.wrench.torque) <
              0.2 * force * radius); // a sphere is hardly turned: short levers only
        worst = std::max(worst, off);
        least = std::min(least, force);
        most = std::max(most, force);
    }
    MESSAGE("direction off by ", worst, " degrees at most, force ", least, " to ", most, " N");
}

TEST_CASE("deeper pushes back more")
{
    double last = 0;
    for (const double depth : {0.0002, 0.0003, 0.0004}) {
        double sum = 0;
        for (int n = 0; n < 64; ++n) {
            sum += length(
                assets().at(oblique(n), 0.030 + 0.00037 * n, -depth, VXS_CONTACT_AVERAGE).wrench.force);
        }
        CHECK(sum > last);
        last = sum;
    }
}

TEST_CASE("where the wall is a grid plane, the force begins at the centre of its cells, half a voxel deep")
{
    // The method's own step (section 3: the plane through the cell's centre), not an error: at -x and -z the
    // wall's cells lie inside the wall.
    for (const double angle : {180 * degree, 270 * degree}) {
        CHECK(length(assets().at(angle, 0.040, -0.0002, VXS_CONTACT_AVERAGE).wrench.force) == 0);
        const vxs_contact_result result = assets().at(angle, 0.040, -0.0003, VXS_CONTACT_AVERAGE);
        const double force = length(result.wrench.force);
        CHECK(result.points > 0);
        REQUIRE(force > 0);
        const double along =
            (result.wrench.force[0] * std::cos(angle) + result.wrench.force[2] * std::sin(angle)) / force;
        CHECK(along > std::cos(5 * degree));
    }
}

TEST_CASE("with the law gradient the force is that of an elastic foundation")
{
    const Assets with_distance(ContactLaw::gradient);
    REQUIRE(vxs_contact_has_field(&with_distance.map, VXS_CONTACT_DISTANCE));
    // The integral of the depth over the touching surface, a sphere's against a cylinder's, is c depth^2;
    // with flat triangles the two touch later, by what the triangles lie inside the true surfaces: s, 20 um
    // here.
    const double c = 1000 * std::numbers::pi / std::sqrt((1 / radius + 1 / wall) / radius);
    double last_root = 0, last_depth = 0;
    for (const double depth : {0.0002, 0.0005, 0.0010}) {
        double root = 0, least = 1e9, most = 0, off = 0;
        for (int n = 0; n < 64; ++n) {
            const double angle = 5.625 * n * degree;
            const vxs_contact_result result =
                with_distance.at(angle, 0.030 + 0.00037 * n, -depth, VXS_CONTACT_GRADIENT);
            const double force = length(result.wrench.force), share = std::sqrt(force / c);
            const double along =
                (result.wrench.force[0] * std::cos(angle) + result.wrench.force[2] * std::sin(angle)) / force;
            root += share / 64;
            least = std::min(least, share);
            most = std::max(most, share);
            off = std::max(off, std::acos(std::min(1.0, along)) / degree);
        }
        const double sag = depth - root;
        MESSAGE("depth ", depth, " m: sqrt(F / c) ", root, " m, ", least, " to ", most, ", off by ", off,
                " degrees at most");
        CHECK(sag > 0);
        CHECK(sag < 25e-6);
        CHECK(most - least < 10e-6);
        CHECK(off < 0.5);
        if (last_depth > 0)
            CHECK((root - last_root) / (depth - last_depth) == doctest::Approx(1).epsilon(0.005));
        last_root = root;
        last_depth = depth;
    }
}

TEST_CASE("with a budget of points the force stays, and does not jump")
{
    const Assets with_distance(ContactLaw::gradient);
    std::vector<std::max_align_t> room(
        vxs_contact_levels_memory(&with_distance.shell) / sizeof(std::max_align_t) + 1);
    const auto size = room.size() * sizeof(std::max_align_t);
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = VXS_CONTACT_GRADIENT;
    config.field = VXS_CONTACT_DISTANCE;
    config.most_points = 100;
    CHECK(vxs_contact_config_check(&config) == VXS_PARAM); // counted points would weigh less
    config.weighting = VXS_CONTACT_AREA;
    CHECK(vxs_contact_config_check(&config) == VXS_OK);
    const vxs_contact_static statics = {&with_distance.map, nullptr};
    vxs_pose pose = {{wall + radius, 0.04, 0}, {1, 0, 0, 0}};
    vxs_contact_result result;
    CHECK(vxs_contact_evaluate(with_distance.contact, &statics, 1, &pose, &config, &result) ==
          VXS_CONTACT_INVALID);
    CHECK(vxs_contact_add_levels(with_distance.contact, room.data(), size - 64) == VXS_BUFFER);
    REQUIRE(vxs_contact_add_levels(with_distance.contact, room.data(), size) == VXS_OK);

    constexpr int ticks = 4000; // pressed to 1 mm and lifted again while it slides
    std::vector<double> full;
    const double limits[] = {0, 1000, 300, 100, 40};
    for (const double limit : limits) {
        config.most_points = static_cast<std::uint32_t>(limit);
        double last = 0, jump = 0, error = 0, largest = 0;
        std::uint32_t level = 0, most = 0, over = 0;
        for (int n = 0; n < ticks; ++n) {
            const double depth = 0.001 * (1 - std::abs(2.0 * n / ticks - 1)), angle = 0.3 + 0.3 * n / ticks,
                         r = wall + radius - depth;
            pose = {{r * std::cos(angle), 0.04, r * std::sin(angle)}, {1, 0, 0.2 * n / ticks, 0}};
            vxs_contact_evaluate(with_distance.contact, &statics, 1, &pose, &config, &result);
            const double force = length(result.wrench.force);
            if (limit == 0) full.push_back(force);
            jump = std::max(jump, std::abs(force - last));
            error = std::max(error, std::abs(force - full[static_cast<std::size_t>(n)]));
            largest = std::max(largest, full[static_cast<std::size_t>(n)]);
            last = force;
            level = std::max(level, result.level);
            most = std::max(most, result.probed);
            over += (result.flags & VXS_CONTACT_OVER_BUDGET) != 0;
            if (limit > 0) CHECK((result.probed <= limit) == !(result.flags & VXS_CONTACT_OVER_BUDGET));
        }
        MESSAGE("at most ", limit, " points: ", most, " looked at, level ", level, ", over budget ", over,
                " ticks, force off by ", 100 * error / largest, " % and jumps by ", 100 * jump / largest,
                " % of the largest");
        if (limit == 0) CHECK(level == 0);
        if (limit == 1000) CHECK(error < 0.03 * largest);
        if (limit == 300) CHECK(error < 0.10 * largest);
        if (limit >= 300) CHECK(jump < 0.02 * largest);
        if (limit >= 100) CHECK(over == 0);
    }
}

TEST_CASE("what a point costs is measured on this machine")
{
    const double cost = vxs_contact_point_cost(assets().contact);
    MESSAGE("a point in contact costs ", 1e9 * cost, " ns");
    CHECK(cost > 0.1e-9);
    CHECK(cost < 10e-6);
}

TEST_CASE("lifted, the force is exactly zero")
{
    for (const std::uint32_t law : {VXS_CONTACT_ORIGINAL, VXS_CONTACT_AVERAGE}) {
        for (int n = 0; n < 64; ++n) {
            // A cell that holds a point of the wall reaches at most its diagonal beyond it.
            const vxs_contact_result result = assets().at(5.625 * n * degree, 0.040, 1.8 * voxel, law);
            CHECK(result.points == 0);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                CHECK(result.wrench.force[axis] == 0);
                CHECK(result.wrench.torque[axis] == 0);
            }
        }
    }
}

TEST_CASE("60 s on the simulated Phantom: no NaN, no missed state, the same trace on every run")
{
    SceneFile scene = cup_scene();
    scene.stiffness = 20; // per point; 0.5 mm cells give some sixteen times the points of 2 mm ones
    scene.hand.keyframes.resize(1);
    scene.hand.keyframes[0].pose.position = {0.065, 0.040, 0};
    HandPath::Keyframe press{1, {{0.0548, 0.040, 0}, {0, 0, 0, 1}}, std::nullopt};
    HandPath::Keyframe slide = press;
    slide.t = 60;
    slide.turn = HandPath::Keyframe::Turn{{0, 0.040, 0}, {0, 1, 0}, 50 * std::numbers::pi};
    scene.hand.keyframes.push_back(press);
    scene.hand.keyframes.push_back(slide);

    Progress silent;
    const Assets &open = assets();
    const PlannedAsset standing[] = {{"cup.voxmap", open.map_file->content_hash()}};
    const PlanFile plan = scene_plan(scene, scene.device, standing,
                                     {"sphere.pointshell", open.shell_file->content_hash()}, {}, {});
    const vxs_asset of_plan[] = {open.map_file->asset(), open.shell_file->asset()};
    const PlannedServo planned(plan, of_plan, "cup");
    RunOptions options;
    options.seconds = 60;
    options.keep_rows = true;
    const ServoRun run = run_servo(planned, options, silent);
    CHECK(run.ticks == 60'000);
    CHECK(run.contact_ticks > 30'000);
    CHECK(run.output_peak > 0);
    const std::uint32_t bad = VXS_SERVO_FAULT | VXS_SERVO_DEVICE_LOST | VXS_SERVO_DEVICE_STALE |
                              VXS_SERVO_MISSED | VXS_CONTACT_INVALID | VXS_CONTACT_OVERFLOW;
    CHECK((run.flags & bad) == 0);
    bool finite = true;
    for (const TraceRow &row : run.rows) {
        for (const Point &point :
             {row.device, row.hand, row.collision_force, row.collision_torque, row.output_force}) {
            finite = finite && std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
        }
    }
    CHECK(finite);
    const std::string trace = trace_csv(run.rows);
    CHECK(trace.find("nan") == std::string::npos);
    CHECK(trace == trace_csv(run_servo(planned, options, silent).rows));
    MESSAGE("force at the hand ", run.output_peak, " N at most, collision ", run.collision_peak,
            " N at most, in contact ", run.contact_ticks, " ticks");
}
