// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/options.hpp"

#include "cli/failure.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <charconv>
#include <cmath>
#include <thread>

namespace voxshell {
namespace {

[[noreturn]] void refuse(const std::string &what)
{
    throw Failure(ExitCode::usage, "", what);
}

/// Splits "2e-4m" into its number "2e-4" and the rest "m"; false if it does not begin with a number.
bool split_number(std::string_view text, std::string_view &number, std::string_view &rest)
{
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc::invalid_argument || text.empty() || text[0] == 'i' || text[0] == 'n')
        return false;
    number = text.substr(0, static_cast<std::size_t>(end - text.data()));
    rest = text.substr(number.size());
    return true;
}

/// number * 10^shift, rounded once: the shift goes into the text's exponent.
double scaled(std::string_view number, int shift)
{
    const std::size_t e = number.find_first_of("eE");
    int exponent = 0;
    if (e != std::string_view::npos) {
        std::string_view digits = number.substr(e + 1);
        if (!digits.empty() && digits[0] == '+') digits.remove_prefix(1);
        const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
        if (error != std::errc() || std::abs(exponent) > 10000) return std::nan("");
    }
    const std::string text = fmt::format("{}e{}", number.substr(0, e), exponent + shift);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() ? value : std::nan("");
}

struct SharedText {
    Shared which;
    const char *name, *metavar, *text;
};

constexpr SharedText shared_texts[] = {
    {Shared::unit, "--unit", "UNIT",
     "unit of an STL file, which has none: mm, cm, m or in; required for STL, glTF is in metres"},
    {Shared::jobs, "-j,--jobs", "N",
     "threads (default 0 = all cores; 0 to 1024); the results do not depend on it"},
    {Shared::max_memory, "--max-memory", "SIZE",
     "refuse work that needs more (default: the machine's memory; 16M or more, as 512M, 4G)"},
    {Shared::dry_run, "--dry-run", "", "check and estimate cells, bytes and seconds; write nothing"},
    {Shared::strict, "--strict", "",
     "refuse where a guess would be needed: open, leaking or inside-out parts"},
    {Shared::force, "--force", "", "overwrite files that have other content"},
    {Shared::format, "--format", "FORMAT", "of the results on stdout: text or json (default text)"},
    {Shared::report, "--report", "FILE", "write the report as JSON"},
    {Shared::reproducible, "--reproducible", "", "leave times, memory and folders out of the report"},
    {Shared::progress, "--progress", "WHEN",
     "progress on stderr: auto, always, never or json (default auto = on a terminal)"},
    {Shared::quiet, "-q,--quiet", "", "results and errors only: no progress, no warnings on stderr"},
};

} // namespace

void add_shared(CLI::App &verb, SharedOptions &o, std::initializer_list<Shared> which)
{
    for (const SharedText &row : shared_texts) {
        if (std::find(which.begin(), which.end(), row.which) == which.end()) continue;
        const std::string name = row.name, text = row.text;
        CLI::Option *option = nullptr;
        switch (row.which) {
        case Shared::jobs:
            option = verb.add_option(name, o.jobs, text)->check(CLI::Range(0, 1024));
            break;
        case Shared::max_memory:
            option = verb.add_option_function<std::string>(
                name,
                [&o](const std::string &value) {
                    o.max_memory = parse_size(value);
                    if (*o.max_memory < (16u << 20)) refuse("--max-memory: " + value + " is less than 16M");
                },
                text);
            break;
        case Shared::unit:
            option = verb.add_option(name, o.unit, text)->check(CLI::IsMember({"mm", "cm", "m", "in"}));
            break;
        case Shared::dry_run:
            verb.add_flag(name, o.dry_run, text);
            break;
        case Shared::strict:
            verb.add_flag(name, o.strict, text);
            break;
        case Shared::force:
            verb.add_flag(name, o.force, text);
            break;
        case Shared::quiet:
            verb.add_flag(name, o.quiet, text);
            break;
        case Shared::reproducible:
            verb.add_flag(name, o.reproducible, text);
            break;
        case Shared::format:
            option = verb.add_option_function<std::string>(
                name, [&o](const std::string &value) { o.json = value == "json"; }, text);
            option->check(CLI::IsMember({"text", "json"}));
            break;
        case Shared::report:
            option = verb.add_option(name, o.report, text);
            break;
        case Shared::progress:
            option = verb.add_option_function<std::string>(
                name,
                [&o](const std::string &value) {
                    o.progress = value == "always"  ? ProgressMode::always
                                 : value == "never" ? ProgressMode::never
                                 : value == "json"  ? ProgressMode::json
                                                    : ProgressMode::automatic;
                },
                text);
            option->check(CLI::IsMember({"auto", "always", "never", "json"}));
            break;
        }
        if (option) option->type_name(row.metavar);
    }
}

CLI::Option *add_length(CLI::App &verb, const std::string &name, double &metres, const std::string &text,
                        bool zero)
{
    return verb
        .add_option_function<std::string>(
            name,
            [&metres, name, zero](const std::string &value) {
                try {
                    metres = parse_length(value, zero);
                } catch (const Failure &failure) {
                    refuse(name + ": " + failure.what());
                }
            },
            text)
        ->type_name("LEN");
}

double parse_length(std::string_view text, bool zero)
{
    std::string_view number, unit;
    if (!split_number(text, number, unit)) refuse(fmt::format("'{}' is not a length; write 0.5mm", text));
    if (unit.empty()) refuse(fmt::format("'{}' has no unit; write {}mm (um, mm, cm, m, in)", text, text));
    double metres = 0;
    if (unit == "m")
        metres = scaled(number, 0);
    else if (unit == "cm")
        metres = scaled(number, -2);
    else if (unit == "mm")
        metres = scaled(number, -3);
    else if (unit == "um")
        metres = scaled(number, -6);
    else if (unit == "in")
        metres = scaled(number, -4) * 254;
    else
        refuse(fmt::format("'{}' has the unknown unit '{}'; use um, mm, cm, m or in", text, unit));
    if (zero && metres == 0) return 0;
    if (!(metres >= 1e-12 && metres <= 1e9))
        refuse(fmt::format("'{}' is out of range (1e-12m to 1e9m)", text));
    return metres;
}

std::uint64_t parse_size(std::string_view text)
{
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    std::string_view rest = text.substr(static_cast<std::size_t>(end - text.data()));
    if (error == std::errc()) {
        for (std::string_view tail : {"iB", "B"})
            if (rest.size() > 1 && rest.ends_with(tail)) rest.remove_suffix(tail.size());
        const std::size_t power = rest.empty() ? 0 : std::string_view("KMGT").find(rest) + 1;
        if (rest.size() <= 1 && power <= 4 && value <= (UINT64_MAX >> (10 * power)) >> 1)
            return value << (10 * power);
    }
    refuse(fmt::format("'{}' is not a memory size; write 512M or 4G", text));
}

double parse_unit(std::string_view text)
{
    if (text == "mm") return 1e-3;
    if (text == "cm") return 1e-2;
    if (text == "m") return 1;
    if (text == "in") return 0.0254;
    refuse(fmt::format("unknown unit '{}'; use mm, cm, m or in", text));
}

std::string format_length(double metres)
{
    const double size = std::abs(metres);
    if (size == 0) return "0 m";
    if (size < 1e-6) return fmt::format("{:.4g} nm", metres * 1e9);
    if (size < 1e-4) return fmt::format("{:.4g} um", metres * 1e6);
    if (size < 1) return fmt::format("{:.4g} mm", metres * 1e3);
    return fmt::format("{:.4g} m", metres);
}

std::string format_size(std::uint64_t bytes)
{
    if (bytes < 1024) return fmt::format("{} B", bytes);
    double value = static_cast<double>(bytes);
    const char *unit = "B";
    for (const char *next : {"KiB", "MiB", "GiB", "TiB", "PiB"}) {
        if (value < 1024) break;
        value /= 1024;
        unit = next;
    }
    return fmt::format("{:.1f} {}", value, unit);
}

std::string format_count(std::uint64_t count)
{
    std::string digits = std::to_string(count);
    for (std::ptrdiff_t at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
        digits.insert(static_cast<std::size_t>(at), 1, ' ');
    return digits;
}

JobLimit::JobLimit(unsigned jobs)
    : control_(new tbb::global_control(tbb::global_control::max_allowed_parallelism,
                                       jobs ? jobs : std::max(1u, std::thread::hardware_concurrency())))
{
}

JobLimit::~JobLimit()
{
    delete static_cast<tbb::global_control *>(control_);
}

} // namespace voxshell
