// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch has done, for people and for programs.
#pragma once

#include "batch/batch.hpp"
#include "pipeline/output.hpp"

#include <nlohmann/json.hpp>

#include <span>
#include <string>

namespace voxshell {

/// "3 built, 97 up to date, 0 failed"
std::string tally(const BatchResult &result);

/// voxshell-report/1 of many parts, an item a line, never as a whole in memory.
struct BatchReport {
    const std::vector<BatchInput> &inputs;
    const BatchResult &result;
    const std::filesystem::path &folder; ///< of the results
    const nlohmann::ordered_json &options;
    bool reproducible;
    double seconds;

    void write(const Outputs::Sink &sink) const;
};

/// What a dry run has found: voxshell-estimate/1, or lines. `threads`: that would work.
void tell_dry_run(const BatchResult &result, unsigned threads, bool as_json);

} // namespace voxshell
