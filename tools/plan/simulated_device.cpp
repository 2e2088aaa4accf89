// SPDX-License-Identifier: GPL-3.0-or-later
#include "plan/simulated_device.hpp"

#include "cli/failure.hpp"
#include "scene/quantity.hpp"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <set>
#include <string_view>

namespace voxshell {
namespace {

constexpr std::string_view options =
    "noise=LENGTH, delay=SAMPLES (1 to 64), loss=SHARE (0% to 90%), loss-time=TIME (0s to 10s), seed=NUMBER";

std::optional<std::uint64_t> whole(std::string_view text)
{
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::optional<double> share(std::string_view text)
{
    double value = 0;
    if (!text.ends_with('%')) return std::nullopt;
    text.remove_suffix(1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc{} && end == text.data() + text.size() ? std::optional(value / 100)
                                                                    : std::nullopt;
}

std::optional<double> within(std::optional<double> value, double least, double most)
{
    return value && *value >= least && *value <= most ? value : std::nullopt;
}

/// Whether the option is one, and its value in range.
bool take(std::string_view key, std::string_view text, vxs_simulated_config &config)
{
    const auto put = [](std::optional<double> value, double &to) {
        to = value.value_or(to);
        return value.has_value();
    };
    if (key == "noise") return put(within(parse_quantity(text, Dimension::length), 0, 1), config.noise);
    if (key == "loss") return put(within(share(text), 0, 0.9), config.loss);
    if (key == "loss-time")
        return put(within(parse_quantity(text, Dimension::time), 0, 10), config.loss_time);
    const std::optional<std::uint64_t> number = whole(text);
    if (key == "seed" && number) config.seed = *number;
    if (key == "delay" && number && *number >= 1 && *number <= 64)
        config.delay_samples = static_cast<std::uint32_t>(*number);
    else if (key != "seed")
        return false;
    return number.has_value();
}

std::string names()
{
    std::string known;
    for (std::uint32_t n = 0; const auto *each = vxs_simulated_profile_at(n); ++n)
        known += (n ? ", sim:" : "sim:") + std::string(each->name);
    return known;
}

} // namespace

vxs_simulated_config simulated_device(const std::string &name, double rate)
{
    std::string_view rest = name;
    const std::string profile_name(rest.substr(0, rest.find(',')));
    rest.remove_prefix(profile_name.size());
    const vxs_simulated_profile *profile =
        profile_name.starts_with("sim:") ? vxs_simulated_profile_named(profile_name.c_str() + 4) : nullptr;
    if (!profile)
        throw Failure(ExitCode::usage, "", "no device '" + profile_name + "'; there are " + names());
    vxs_simulated_config config;
    vxs_simulated_config_default(&config, profile);
    config.sample_time = rate > 0 ? 1 / rate : config.sample_time;
    std::set<std::string_view> seen;
    while (!rest.empty()) {
        rest.remove_prefix(1);
        const std::string_view option = rest.substr(0, rest.find(','));
        rest.remove_prefix(option.size());
        const std::size_t equals = std::min(option.find('='), option.size());
        const std::string_view key = option.substr(0, equals);
        if (!seen.insert(key).second || equals == option.size() ||
            !take(key, option.substr(equals + 1), config))
            throw Failure(ExitCode::usage, "",
                          fmt::format("device '{}': '{}'; after the name may stand, once each, {}", name,
                                      option, options));
    }
    return config;
}

} // namespace voxshell
