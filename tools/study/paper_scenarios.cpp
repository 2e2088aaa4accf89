// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/paper_scenarios.hpp"

#include "cli/failure.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>

namespace voxshell {
namespace {

constexpr double mm = 1e-3;
constexpr auto exact = ShellKind::exact, naive = ShellKind::naive;
constexpr std::uint32_t original = VXS_CONTACT_ORIGINAL, average = VXS_CONTACT_AVERAGE,
                        patch = VXS_CONTACT_PATCH, gradient = VXS_CONTACT_GRADIENT;
constexpr std::uint32_t surface = VXS_CONTACT_SURFACE, layers = VXS_CONTACT_LAYERS,
                        distance = VXS_CONTACT_DISTANCE;
constexpr std::uint32_t count = VXS_CONTACT_COUNT, capped = VXS_CONTACT_COUNT_CAPPED, area = VXS_CONTACT_AREA;

std::vector<Variant> every_method()
{
    std::vector<Variant> all;
    for (const ShellKind shell : {naive, exact}) {
        for (const std::uint32_t field : {surface, layers, distance}) {
            for (const std::uint32_t law : {original, average, patch})
                all.push_back({{shell, law, field, count}, {}});
        }
        all.push_back({{shell, gradient, distance, count}, {}});
    }
    for (const std::uint32_t law : {original, average}) {
        for (const std::uint32_t weighting : {capped, area})
            all.push_back({{exact, law, surface, weighting}, {}});
    }
    return all;
}

/// What the paper compares: both shells, both laws.
std::vector<Variant> papers()
{
    return {{{naive, original, surface, count}, {}},
            {{naive, average, surface, count}, {}},
            {{exact, original, surface, count}, {}},
            {{exact, average, surface, count}, {}}};
}

std::vector<Variant> couplings()
{
    const Method paper{exact, average, surface, count};
    return {{paper, {Coupled::none}},      {paper, {Coupled::spring_damper}},
            {paper, {Coupled::pt2, 5}},    {paper, {Coupled::pt2, 50}},
            {paper, {Coupled::automatic}}, {{exact, patch, distance, count}, {Coupled::automatic}}};
}

/// The paper's, the paper's with a deeper field, the paper's with as much stiffness as its filter carries,
/// and ours.
std::vector<Variant> loops()
{
    const Coupled five{Coupled::pt2, 5}, bounded{Coupled::pt2, 5, true};
    return {{{exact, average, surface, count}, five},
            {{exact, average, layers, count}, five},
            {{exact, average, distance, count}, five},
            {{exact, average, surface, count}, bounded},
            {{exact, average, distance, count}, bounded},
            {{exact, patch, distance, count}, {Coupled::automatic}}};
}

std::vector<Variant> only(ShellKind shell, std::uint32_t law)
{
    return {{{shell, law, surface, count}, {}}};
}

const std::vector<Scenario> &table()
{
    const std::vector<double> depths{0.25, 0.5, 1};
    const std::vector<Variant> fit{
        {{exact, original, surface, count}, {}}, {{exact, average, surface, count}, {}},
        {{exact, patch, surface, count}, {}},    {{exact, average, distance, count}, {}},
        {{exact, patch, distance, count}, {}},   {{exact, gradient, distance, count}, {}}};
    const char *premium = "sim:phantom-premium-1.5", *lwr = "sim:dlr-lwr";
    // A row a line:
    // clang-format off
    // id, group, stands, moves, e, radius, motion, turned, levels, level, speeds, device, variants
    static const std::vector<Scenario> rows{
        {"fig8a", "fig8", Stands::plane, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", only(exact, original)},
        {"fig8b", "fig8", Stands::plane, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", only(exact, average)},
        {"fig8c", "fig8", Stands::tilted_plane, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", only(exact, original)},
        {"fig8d", "fig8", Stands::tilted_plane, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", only(exact, average)},
        {"fig9a", "fig9", Stands::cylinder, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", only(exact, original)},
        {"fig9b", "fig9", Stands::cylinder, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", only(exact, average)},
        {"degenerate-a", "degenerate", Stands::middle_plane, Moves::ball, mm, 20 * mm, Motion::circle, false, depths, "depth_e", {}, "", only(exact, original)},
        {"degenerate-b", "degenerate", Stands::middle_plane, Moves::ball, mm, 20 * mm, Motion::circle, false, depths, "depth_e", {}, "", only(exact, average)},
        {"control8", "control", Stands::tilted_plane, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", every_method()},
        {"control9", "control", Stands::cylinder, Moves::ball, mm, 20 * mm, Motion::circle, true, depths, "depth_e", {}, "", every_method()},
        {"control9-turned", "control", Stands::tilted_cylinder, Moves::ball, mm, 20 * mm, Motion::circle, true, {0.5}, "depth_e", {}, "", papers()},
        {"wedge", "wedge", Stands::groove, Moves::ball, mm, 20 * mm, Motion::press, true, {1, 0.5}, "other_wall", {}, "", fit},
        {"peg", "peg", Stands::hole, Moves::peg, mm, 10 * mm, Motion::insert, true, {19.6, 20, 20.2}, "peg_mm", {}, "", fit},
        {"fig11", "fig11", Stands::cylinder, Moves::ball, 2 * mm, 15 * mm, Motion::coupled, true, {0.5}, "depth_e", {}, premium, couplings()},
        {"fig12a", "fig12", Stands::cup, Moves::ball, 2 * mm, 15 * mm, Motion::push, true, {0}, "", {0.1}, premium, loops()},
        {"fig12b", "fig12", Stands::cup, Moves::ball, 2 * mm, 15 * mm, Motion::slide, true, {0}, "", {0.05}, premium, loops()},
        {"fig12c", "fig12", Stands::cup, Moves::ball, 2 * mm, 15 * mm, Motion::push, true, {0}, "", {0.2}, lwr, loops()},
        {"fig12d", "fig12", Stands::cup, Moves::ball, 2 * mm, 15 * mm, Motion::slide, true, {0}, "", {0.1}, lwr, loops()},
        {"wall", "wall", Stands::plate, Moves::ball, 2 * mm, 15 * mm, Motion::push, true, {1, 2, 3, 5}, "plate_e", {0.05, 0.1, 0.2, 0.5}, premium, loops()},
    };
    // clang-format on
    return rows;
}

} // namespace

std::span<const Scenario> paper_scenarios()
{
    return table();
}

const Scenario &paper_scenario(const std::string &id)
{
    for (const Scenario &scenario : table()) {
        if (id == scenario.id) return scenario;
    }
    throw Failure(ExitCode::bug, "", "no scenario " + id);
}

bool is_loop(const Scenario &scenario)
{
    return scenario.motion == Motion::push || scenario.motion == Motion::slide;
}

std::string law_name(std::uint32_t law)
{
    return law == original ? "original" : law == average ? "average" : law == patch ? "patch" : "gradient";
}

std::string field_name(std::uint32_t field)
{
    return field == surface ? "surface" : field == layers ? "layers" : "distance";
}

std::string weighting_name(std::uint32_t weighting)
{
    return weighting == count ? "count" : weighting == capped ? "count-capped" : "area";
}

std::string shell_name(ShellKind kind)
{
    return kind == exact ? "exact" : "naive";
}

std::string method_text(const Method &m)
{
    return shell_name(m.shell) + ", " + law_name(m.law) + ", " + field_name(m.field) +
           (m.weighting == count ? "" : ", " + weighting_name(m.weighting));
}

std::string coupled_text(const Coupled &coupled)
{
    switch (coupled.kind) {
    case Coupled::none:
        return "none";
    case Coupled::spring_damper:
        return "spring-damper";
    case Coupled::pt2:
        return fmt::format("PT2 {:g} Hz{}", coupled.hertz, coupled.bounded ? " bounded" : "");
    case Coupled::automatic:
        return "automatic";
    }
    return "";
}

Draw draw(unsigned seed)
{
    std::mt19937_64 dice(seed);
    const auto uniform = [&] { return static_cast<double>(dice() >> 11) * 0x1p-53; };
    const double u = uniform(), v = 2 * std::numbers::pi * uniform(), w = 2 * std::numbers::pi * uniform();
    Draw d{{std::sqrt(1 - u) * std::sin(v), std::sqrt(1 - u) * std::cos(v), std::sqrt(u) * std::sin(w),
            std::sqrt(u) * std::cos(w)},
           {}};
    for (double &x : d.offset) x = uniform();
    return d;
}

} // namespace voxshell
