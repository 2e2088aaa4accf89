// SPDX-License-Identifier: GPL-3.0-or-later
// The report of convert and batch: voxshell-report/1 (formats/schema/report.json).
#pragma once

#include "cli/failure.hpp"
#include "container/container.hpp"
#include "pipeline/convert_part.hpp"
#include "pipeline/output.hpp"

#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace voxshell {

class RunReport {
  public:
    /// `reproducible`: no cost, and file names without their folders.
    explicit RunReport(bool reproducible);
    void options(nlohmann::ordered_json effective);
    void input(const std::filesystem::path &path, const Sha256 &hash);
    void part(const Part &part, double voxel);
    void output(const std::filesystem::path &path, std::span<const std::uint8_t> bytes);
    void warning(const Warning &warning);
    void failed(const std::filesystem::path &path, const Failure &failure);
    /// With the cost up to now, unless reproducible.
    std::string text() const;

  private:
    std::string shown(const std::filesystem::path &path) const;
    bool reproducible_;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
    nlohmann::ordered_json json_;
};

/// A member of `parts`.
nlohmann::ordered_json part_json(const Part &part, double voxel);

/// Writes the report: an older report of that name is replaced, any other file only with `force`. `write`
/// hands its text to the sink piece by piece.
void write_report(const std::filesystem::path &path, bool force,
                  const std::function<void(const Outputs::Sink &)> &write);

/// JSON text, indented; bytes of a path that are not UTF-8 become U+FFFD.
std::string json_text(const nlohmann::ordered_json &json);

} // namespace voxshell
