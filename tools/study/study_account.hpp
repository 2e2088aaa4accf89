// SPDX-License-Identifier: GPL-3.0-or-later
// A claim that grows number by number, each from a cell of a table; its verdict is decided by the numbers,
// never written down.
#pragma once

#include "study/study_report.hpp"

#include <limits>
#include <map>

namespace voxshell {

using Words = std::map<std::string, std::string>; ///< column of words -> what stands there

/// Rows with all of these words, in their order.
std::vector<std::size_t> rows_of(const StudyTable &table, const Words &words);

class Account {
  public:
    Account(const Study &study, const char *id, const char *text, const char *why);
    void say(const std::string &text) { claim.measured += text; }
    /// Text with "@" for the number; returns it.
    double say(const std::string &text, const StudyTable &table, std::size_t row, const std::string &column,
               const std::string &format = "{:.3g}");
    /// Of the first row with these words and this `level` (any_level: whichever). Throws Failure(bug) if
    /// there is none.
    double say(const std::string &text, const std::string &table, const Words &words, double level,
               const std::string &column, const std::string &format = "{:.3g}");
    StudyClaim judged(Verdict verdict);
    StudyClaim claim;

  private:
    const Study &study_;
};

inline constexpr double any_level = std::numeric_limits<double>::quiet_NaN();

Verdict verdict_of(bool holds, bool partly);

} // namespace voxshell
