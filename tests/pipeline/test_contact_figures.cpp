// SPDX-License-Identifier: GPL-3.0-or-later
// The set-ups of the paper's figures 8 and 9: a sphere that circles on a plane and round a cylinder, its
// shell voxelised in its own frame and turned at random. And the force of a sphere as cells get finer.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "solids.hpp"

#include "pipeline/convert_part.hpp"

#include "voxshell/contact.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <vector>

using namespace voxshell;

namespace {

constexpr double e = 0.001, pi = std::numbers::pi; // [m]

/// A part as the pipeline makes it, opened by the runtime.
class Opened {
  public:
    Opened(const Mesh &mesh, double voxel, ChannelRequest channels)
    {
        Scene scene;
        scene.name = "part";
        scene.meshes = {mesh};
        scene.instances = {{"/part", 0}};
        PartOptions options;
        options.voxel = voxel;
        options.channels = channels;
        Progress silent;
        const Part part = convert_part(scene, options, silent);
        open(part.voxmap, map_bytes_, map_file_);
        open(part.pointshell, shell_bytes_, shell_file_);
        REQUIRE(vxs_voxmap_open(&map_file_, &map) == VXS_OK);
        REQUIRE(vxs_pointshell_open(&shell_file_, &shell) == VXS_OK);
    }
    Opened(const Opened &) = delete;
    Opened &operator=(const Opened &) = delete;
    vxs_voxmap map{};
    vxs_pointshell shell{};

  private:
    struct alignas(64) Block {
        std::uint8_t bytes[64];
    };
    static void open(const std::vector<std::uint8_t> &from, std::vector<Block> &to, vxs_asset &asset)
    {
        to.resize(from.size() / sizeof(Block) + 1);
        std::memcpy(to.data(), from.data(), from.size());
        REQUIRE(vxs_asset_from_memory(to.data(), from.size(), nullptr, &asset, nullptr) == VXS_OK);
    }
    std::vector<Block> map_bytes_, shell_bytes_;
    vxs_asset map_file_{}, shell_file_{};
};

class Contact {
  public:
    explicit Contact(const Opened &moving)
        : memory_(vxs_contact_memory(&moving.shell, 1) / sizeof(std::max_align_t) + 1)
    {
        REQUIRE(vxs_contact_init(memory_.data(), memory_.size() * sizeof(std::max_align_t), &moving.shell, 1,
                                 &contact_) == VXS_OK);
    }
    vxs_contact_result at(const vxs_voxmap &map, const vxs_pose &pose, const vxs_contact_config &config)
    {
        vxs_contact_result result;
        const vxs_contact_static statics = {&map, nullptr};
        vxs_contact_evaluate(contact_, &statics, 1, &pose, &config, &result);
        REQUIRE((result.flags & (VXS_CONTACT_INVALID | VXS_CONTACT_OUT_OF_MAP)) == 0);
        return result;
    }

  private:
    std::vector<std::max_align_t> memory_;
    vxs_contact *contact_ = nullptr;
};

vxs_contact_config config_of(std::uint32_t law, std::uint32_t field, std::uint32_t weighting,
                             double stiffness)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = law;
    config.field = field;
    config.weighting = weighting;
    config.stiffness = stiffness;
    return config;
}

double dot(const Point &a, const Point &b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Ry(30 degrees) Rx(20 degrees).
Point tilted(const Point &p)
{
    const double c = std::cos(20 * pi / 180), s = std::sin(20 * pi / 180), d = std::cos(30 * pi / 180),
                 t = std::sin(30 * pi / 180);
    const Point x{p[0], c * p[1] - s * p[2], s * p[1] + c * p[2]};
    return {d * x[0] + t * x[2], x[1], -t * x[0] + d * x[2]};
}

/// A closed cylinder about the z axis.
Mesh cylinder(double radius, double half, int count)
{
    Mesh m;
    for (int n = 0; n < count; ++n) {
        const double a = 2 * pi * n / count;
        m.vertices.push_back({radius * std::cos(a), radius * std::sin(a), -half});
        m.vertices.push_back({radius * std::cos(a), radius * std::sin(a), half});
    }
    const auto low = static_cast<std::uint32_t>(m.vertices.size()), high = low + 1;
    m.vertices.push_back({0, 0, -half});
    m.vertices.push_back({0, 0, half});
    for (int n = 0; n < count; ++n) {
        const auto a = static_cast<std::uint32_t>(2 * n),
                   b = static_cast<std::uint32_t>(2 * ((n + 1) % count));
        m.triangles.push_back({a, b, b + 1});
        m.triangles.push_back({a, b + 1, a + 1});
        m.triangles.push_back({low, b, a});
        m.triangles.push_back({high, a + 1, b + 1});
    }
    return m;
}

struct Told {
    double normal = 0, ripple = 0, tangential = 0; ///< mean; shares of it
};

/// Five seeds: the shell turned at random, the path begun anywhere; one turn each.
Told circle(const Opened &fixed, Contact &contact, bool is_round, double depth,
            const vxs_contact_config &config)
{
    constexpr int seeds = 5, samples = 600;
    std::mt19937_64 dice(8);
    const auto uniform = [&] { return static_cast<double>(dice() >> 11) * 0x1p-53; };
    Told told;
    for (int seed = 0; seed < seeds; ++seed) {
        vxs_pose pose{};
        for (double &x : pose.orientation) x = 2 * uniform() - 1;
        const double offset[3] = {uniform(), uniform(), uniform()};
        double sum = 0, square = 0, side = 0;
        for (int n = 0; n < samples; ++n) {
            const double angle = 2 * pi * (n + offset[0]) / samples;
            const Point outwards = is_round ? Point{std::cos(angle), std::sin(angle), 0} : tilted({0, 0, 1});
            const double r = 30 * e + 20 * e - depth;
            const Point at = is_round ? Point{r * std::cos(angle), r * std::sin(angle), e * offset[1]}
                                      : tilted({15 * e * std::cos(angle) + e * offset[1],
                                                15 * e * std::sin(angle) + e * offset[2], 20 * e - depth});
            for (int i = 0; i < 3; ++i) pose.position[i] = at[static_cast<std::size_t>(i)];
            const vxs_contact_result touch = contact.at(fixed.map, pose, config);
            const Point f{touch.wrench.force[0], touch.wrench.force[1], touch.wrench.force[2]};
            const double normal = dot(f, outwards);
            sum += normal;
            square += normal * normal;
            side += std::max(0.0, dot(f, f) - normal * normal);
        }
        const double mean = sum / samples;
        told.normal += mean / seeds;
        told.ripple += std::sqrt(std::max(0.0, square / samples - mean * mean)) / mean / seeds;
        told.tangential += std::sqrt(side / samples) / mean / seeds;
    }
    return told;
}

} // namespace

TEST_CASE("figures 8 and 9: distance and gradient are smooth, along the normal and linear in depth")
{
    const Opened ball(solids::sphere({0, 0, 0}, 20 * e, 128), e, {});
    Mesh slab = solids::box({-60 * e, -60 * e, -12 * e}, {60 * e, 60 * e, 0});
    for (Point &p : slab.vertices) p = tilted(p);
    Contact contact(ball);
    const struct {
        const char *name;
        std::uint32_t law, field;
    } modes[] = {{"gradient distance", VXS_CONTACT_GRADIENT, VXS_CONTACT_DISTANCE},
                 {"patch distance", VXS_CONTACT_PATCH, VXS_CONTACT_DISTANCE},
                 {"average distance", VXS_CONTACT_AVERAGE, VXS_CONTACT_DISTANCE},
                 {"patch layers", VXS_CONTACT_PATCH, VXS_CONTACT_LAYERS},
                 {"average layers", VXS_CONTACT_AVERAGE, VXS_CONTACT_LAYERS},
                 {"patch surface", VXS_CONTACT_PATCH, VXS_CONTACT_SURFACE},
                 {"average surface", VXS_CONTACT_AVERAGE, VXS_CONTACT_SURFACE},
                 {"original surface", VXS_CONTACT_ORIGINAL, VXS_CONTACT_SURFACE}};
    for (const bool is_round : {false, true}) {
        const Opened fixed(is_round ? cylinder(30 * e, 30 * e, 720) : slab, e, {3, 3});
        for (const auto &mode : modes) {
            // McNeely's weighting: a mean depth, so linear in it.
            const vxs_contact_config config =
                config_of(mode.law, mode.field, VXS_CONTACT_COUNT_CAPPED, 1 / e);
            std::string line;
            double first = 0;
            for (const double depth : {0.25, 0.5, 1.0}) {
                const Told told = circle(fixed, contact, is_round, depth * e, config);
                if (first == 0) first = told.normal / depth;
                line += "  " + std::to_string(depth).substr(0, 4) +
                        " e: " + std::to_string(told.normal).substr(0, 5) + " N, ripple " +
                        std::to_string(100 * told.ripple).substr(0, 4) + " %, tangential " +
                        std::to_string(100 * told.tangential).substr(0, 5) + " %;";
                if (mode.law != VXS_CONTACT_GRADIENT) continue;
                CHECK(told.tangential <= 0.005);
                CHECK(told.ripple <= 0.05);
                CHECK(told.normal / depth == doctest::Approx(first).epsilon(0.1));
            }
            MESSAGE("figure ", is_round ? 9 : 8, ", ", std::string(mode.name), ":", line);
        }
    }
}

TEST_CASE("weighted by area, a force does not grow with finer cells")
{
    // A cap's pressure: the volume that the sphere sinks in, pi R d^2 less a little, times k. One cell deep
    // is 8 cells after three halvings: a band of 7 is too narrow there, and the tick says so; one of 10 is
    // not.
    constexpr double radius = 10e-3, coarse = 0.8e-3, k = 1e9;
    const std::uint32_t laws[] = {VXS_CONTACT_GRADIENT, VXS_CONTACT_PATCH, VXS_CONTACT_AVERAGE,
                                  VXS_CONTACT_ORIGINAL};
    std::vector<double> first(2 * std::size(laws));
    for (int halvings = 0; halvings <= 3; ++halvings) {
        const double h = std::ldexp(coarse, -halvings);
        const Opened ball(solids::sphere({0, 0, 0}, radius, 128), h, {});
        const Opened floor(solids::box({-8e-3, -4e-3, -8e-3}, {8e-3, 0.07e-3, 8e-3}), h, {0, 10});
        Contact contact(ball);
        for (int deep = 0; deep < 2; ++deep) {
            const double depth = (deep ? 1.0 : 0.7) * coarse,
                         exact = k * pi * depth * depth * (radius - depth / 3);
            const vxs_pose pose{{0.11e-3, 0.07e-3 + radius - depth, -0.23e-3}, {0.9, 0.3, -0.2, 0.1}};
            for (std::size_t n = 0; n < std::size(laws); ++n) {
                const vxs_contact_result r = contact.at(
                    floor.map, pose, config_of(laws[n], VXS_CONTACT_DISTANCE, VXS_CONTACT_AREA, k));
                const double force = r.wrench.force[1];
                double &start = first[2 * n + static_cast<std::size_t>(deep)];
                if (halvings == 0) start = force;
                MESSAGE("sunk in by ", 1e3 * depth, " mm, cells of ", 1e3 * h, " mm, law ", laws[n], ": ",
                        force, " N of ", exact, ", ", r.points, " points, ", r.deep_points, " deep");
                CHECK(force == doctest::Approx(start).epsilon(0.02));
                CHECK((r.flags & VXS_CONTACT_DEEP) == 0);
            }
        }
        if (halvings < 3) continue;
        const Opened narrow(solids::box({-8e-3, -4e-3, -8e-3}, {8e-3, 0.07e-3, 8e-3}), h, {0, 7});
        const vxs_pose pose{{0.11e-3, 0.07e-3 + radius - coarse, -0.23e-3}, {0.9, 0.3, -0.2, 0.1}};
        const vxs_contact_result r = contact.at(
            narrow.map, pose, config_of(VXS_CONTACT_AVERAGE, VXS_CONTACT_DISTANCE, VXS_CONTACT_AREA, k));
        CHECK((r.flags & VXS_CONTACT_DEEP) != 0);
    }
}
