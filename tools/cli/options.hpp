// SPDX-License-Identifier: GPL-3.0-or-later
// Options that mean the same in every verb: their values, their texts, how their values are written.
#pragma once

#include "cli/progress.hpp"

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

namespace CLI {
class App;
class Option;
} // namespace CLI

namespace voxshell {

/// Values of the shared options; a verb keeps one and offers those that it needs with add_shared().
struct SharedOptions {
    unsigned jobs = 0;                       ///< -j: 0 = all cores
    std::optional<std::uint64_t> max_memory; ///< --max-memory [bytes]
    std::string unit;                        ///< --unit: mm, cm, m, in; empty: not given
    bool dry_run = false;
    bool strict = false;
    bool force = false;
    bool quiet = false;
    bool reproducible = false;
    bool json = false;  ///< --format json
    std::string report; ///< --report FILE.json; empty: none
    ProgressMode progress = ProgressMode::automatic;
};

enum class Shared {
    jobs,
    max_memory,
    unit,
    dry_run,
    strict,
    force,
    quiet,
    reproducible,
    format,
    report,
    progress
};

void add_shared(CLI::App &verb, SharedOptions &options, std::initializer_list<Shared> which);

/// An option whose value is a length with its unit ("0.5mm"), stored in metres; `zero`: may be 0.
CLI::Option *add_length(CLI::App &verb, const std::string &name, double &metres, const std::string &text,
                        bool zero = false);

/// "0.5mm", "2e-4m", "300um", "2cm", "1in" to metres, correctly rounded: "0.3mm" and "3e-4m" are the same
/// number. Throws Failure(usage) for anything else, a number without unit, and lengths outside 1e-12 m .. 1e9
/// m; 0 is accepted only where `zero` says so.
double parse_length(std::string_view text, bool zero = false);

/// "4G", "512M", "1048576" (K, M, G, T are powers of 1024) to bytes. Throws Failure(usage).
std::uint64_t parse_size(std::string_view text);

/// Metres per unit of "mm", "cm", "m", "in". Throws Failure(usage).
double parse_unit(std::string_view text);

std::string format_length(double metres);      ///< "0.5 mm", "1.2 m", "3 um": four digits, unit that suits
std::string format_size(std::uint64_t bytes);  ///< "684 B", "12.3 MiB"
std::string format_count(std::uint64_t count); ///< "1 234 567"

/// Limits oneTBB to `jobs` threads (0: all cores) for as long as it lives.
class JobLimit {
  public:
    explicit JobLimit(unsigned jobs);
    ~JobLimit();
    JobLimit(const JobLimit &) = delete;
    JobLimit &operator=(const JobLimit &) = delete;

  private:
    void *control_;
};

} // namespace voxshell
