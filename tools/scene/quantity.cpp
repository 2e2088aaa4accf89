// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/quantity.hpp"

#include <charconv>
#include <cmath>
#include <numbers>

namespace voxshell {
namespace {

struct Unit {
    Dimension dimension;
    std::string_view name;
    int power;         ///< of ten
    double factor = 1; ///< of what is no power of ten
};

constexpr Unit units[] = {
    {Dimension::length, "m", 0},
    {Dimension::length, "cm", -2},
    {Dimension::length, "mm", -3},
    {Dimension::length, "um", -6},
    {Dimension::length, "in", 0, 0.0254},
    {Dimension::time, "s", 0},
    {Dimension::time, "ms", -3},
    {Dimension::time, "us", -6},
    {Dimension::frequency, "Hz", 0},
    {Dimension::frequency, "kHz", 3},
    {Dimension::angle, "rad", 0},
    {Dimension::angle, "deg", 0, std::numbers::pi / 180},
    {Dimension::stiffness, "N/m", 0},
    {Dimension::stiffness, "N/mm", 3},
    {Dimension::foundation, "N/m^3", 0},
    {Dimension::foundation, "N/mm^3", 9},
    {Dimension::mass, "kg", 0},
    {Dimension::mass, "g", -3},
    {Dimension::speed, "m/s", 0},
    {Dimension::speed, "mm/s", -3},
    {Dimension::damping, "Ns/m", 0},
    {Dimension::damping, "Ns/mm", 3},
    {Dimension::force_rate, "N/s", 0},
    {Dimension::force_rate, "N/ms", 3},
    {Dimension::torque_rate, "Nm/s", 0},
    {Dimension::torque_rate, "Nm/ms", 3},
    {Dimension::force, "N", 0},
    {Dimension::force, "mN", -3},
    {Dimension::torque, "Nm", 0},
    {Dimension::torque, "mNm", -3},
    {Dimension::acceleration, "m/s^2", 0},
    {Dimension::angular_speed, "rad/s", 0},
    {Dimension::angular_speed, "deg/s", 0, std::numbers::pi / 180},
    {Dimension::angular_damping, "Nms/rad", 0},
    {Dimension::angular_damping, "mNms/rad", -3},
    {Dimension::angular_stiffness, "Nm/rad", 0},
    {Dimension::angular_stiffness, "mNm/rad", -3},
    {Dimension::inertia, "kgm^2", 0},
    {Dimension::inertia, "gcm^2", -7},
    {Dimension::density, "kg/m^3", 0},
    {Dimension::density, "g/cm^3", 3},
    {Dimension::energy, "J", 0},
    {Dimension::energy, "mJ", -3},
    {Dimension::per_speed, "s/m", 0},
    {Dimension::per_speed, "s/mm", 3},
};

/// All of `text` as a number.
template<class Number>
bool parse(std::string_view text, Number &number)
{
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc{} && end == text.data() + text.size();
}

/// number * 10^power, rounded once: "0.3mm" is the double nearest to 0.0003, as it is elsewhere.
std::optional<double> scaled(std::string_view number, int power)
{
    const std::size_t e = number.find_first_of("eE");
    int exponent = 0;
    if (e != std::string_view::npos) {
        std::string_view digits = number.substr(e + 1);
        if (digits.starts_with('+')) {
            digits.remove_prefix(1);
        }
        if (!parse(digits, exponent) || std::abs(exponent) > 1000) {
            return std::nullopt;
        }
    }
    double value = 0;
    const bool ok = parse(std::string(number.substr(0, e)) + "e" + std::to_string(exponent + power), value);
    return ok && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

} // namespace

std::optional<double> parse_quantity(std::string_view text, Dimension dimension)
{
    double unscaled = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), unscaled);
    if (error != std::errc{} || !std::isfinite(unscaled)) {
        return std::nullopt;
    }
    const std::size_t length = static_cast<std::size_t>(end - text.data());
    const std::string_view number = text.substr(0, length);
    text.remove_prefix(length);
    if (text.starts_with(' ')) {
        text.remove_prefix(1);
    }
    for (const Unit &unit : units) {
        if (unit.dimension == dimension && unit.name == text) {
            const auto value = scaled(number, unit.power);
            return value && std::isfinite(*value * unit.factor) ? std::optional(*value * unit.factor)
                                                                : std::nullopt;
        }
    }
    return std::nullopt;
}

std::optional<Dimension> dimension_of(std::string_view si_unit)
{
    for (const Unit &unit : units) {
        if (unit.name == si_unit && unit.power == 0 && unit.factor == 1) {
            return unit.dimension;
        }
    }
    return std::nullopt;
}

std::string units_of(Dimension dimension)
{
    std::string text;
    std::string_view pending;
    for (const Unit &unit : units) {
        if (unit.dimension == dimension) {
            if (!pending.empty()) {
                text += (text.empty() ? "" : ", ") + std::string(pending);
            }
            pending = unit.name;
        }
    }
    return (text.empty() ? "" : text + " or ") + std::string(pending);
}

} // namespace voxshell
