// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/study_account.hpp"

#include <algorithm>
#include <cmath>

namespace voxshell {

std::vector<std::size_t> rows_of(const StudyTable &table, const Words &words)
{
    std::vector<std::size_t> found;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        if (std::all_of(words.begin(), words.end(),
                        [&](const auto &w) { return table.word(row, w.first) == w.second; }))
            found.push_back(row);
    }
    return found;
}

Account::Account(const Study &study, const char *id, const char *text, const char *why) : study_(study)
{
    claim.id = id;
    claim.claim = text;
    claim.why = why;
}

double Account::say(const std::string &text, const StudyTable &table, std::size_t row,
                    const std::string &column, const std::string &format)
{
    claim.measured += text;
    claim.numbers.push_back(study_number(table, row, column, format));
    return claim.numbers.back().value;
}

double Account::say(const std::string &text, const std::string &table, const Words &words, double level,
                    const std::string &column, const std::string &format)
{
    const StudyTable &found = study_.table(table);
    for (const std::size_t row : rows_of(found, words)) {
        if (std::isnan(level) || found.number(row, "level") == level)
            return say(text, found, row, column, format);
    }
    throw Failure(ExitCode::bug, table, "no such row for claim " + claim.id);
}

StudyClaim Account::judged(Verdict verdict)
{
    claim.verdict = verdict;
    return claim;
}

Verdict verdict_of(bool holds, bool partly)
{
    return holds ? Verdict::holds : partly ? Verdict::partly : Verdict::fails;
}

} // namespace voxshell
