// SPDX-License-Identifier: GPL-3.0-or-later
// What a study hands over: tables (each one CSV), figures (each CSV, SVG and PNG), and claims with the
// numbers that decide them; as files, as summary.json (voxshell-study/1) and as one page.
#pragma once

#include "cli/progress.hpp"
#include "pipeline/convert_part.hpp"
#include "pipeline/output.hpp"

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

namespace voxshell {

struct StudyColumn {
    std::string name;   ///< of the CSV, with its unit: "across_peak_pct"
    std::string label;  ///< of the page: "tangential peak [%]"; empty: not shown there
    bool timed = false; ///< not the same on every run: in ID_timing.csv, beside the first column; the first
                        ///< one: all are
};

struct StudyTable {
    std::string id; ///< the CSV is ID.csv
    std::string title, note;
    std::vector<StudyColumn> columns;
    std::vector<std::vector<std::variant<std::string, double>>> rows; ///< NaN: nothing to tell
    std::string figure;                                               ///< under which it stands
    std::string csv() const;                                          ///< without timed columns
    std::string timing_csv() const;                                   ///< empty without timed columns
    std::string file_of(const std::string &column) const; ///< of the CSV that has it, without ".csv"
    double number(std::size_t row, const std::string &column) const; ///< throws Failure(bug) if there is none
    const std::string &word(std::size_t row, const std::string &column) const; ///< so as well
};

struct StudyFigure {
    std::string id;    ///< ID.csv, ID.svg, ID.png
    std::string title; ///< "Figure 8: ..."
    std::string caption;
    std::string csv;    ///< what is drawn
    std::string script; ///< of gnuplot, without sheet and command
    int width, height;
    bool timed = false;   ///< draws what is not the same on every run
    std::string absent{}; ///< why there is nothing to draw, a sentence: then there is no picture
};

/// A cell of a table, for a sentence.
struct StudyNumber {
    std::string table; ///< the CSV's name: StudyTable::file_of()
    std::size_t row;
    std::string column;
    double value;
    std::string format; ///< "{:.2f}"
};

enum class Verdict { holds, partly, fails };

struct StudyClaim {
    std::string id, claim;
    std::string measured; ///< each "@" is the next of numbers
    std::string why;
    Verdict verdict;
    std::vector<StudyNumber> numbers;
};

struct Study {
    std::string name; ///< "paper", "stability"
    std::string title, lead;
    std::string command; ///< what makes it again
    std::vector<std::pair<std::string, std::string>> options;
    std::vector<StudyClaim> claims;
    std::vector<StudyClaim> answers; ///< to the user's question: each one's `measured`, under its `claim`
    std::vector<StudyFigure> figures;
    std::vector<StudyTable> tables;
    std::vector<StudyTable> timings; ///< files of their own: not the same on every run
    const StudyTable &table(const std::string &id) const;
};

/// A number of one column of one row, to be named in a claim.
StudyNumber study_number(const StudyTable &table, std::size_t row, const std::string &column,
                         const std::string &format = "{:.3g}");

/// index.html, summary.json, all CSV and pictures. Throws Failure(system) without gnuplot.
void write_study(const Study &study, const std::filesystem::path &folder, Outputs &outputs,
                 Progress &progress);

std::string study_json(const Study &study);

/// The page; svg: of each figure, in their order.
std::string study_page(const Study &study, const std::vector<std::string> &svg);

std::string verdict_text(Verdict verdict); ///< "holds", "holds in part", "does not hold"

} // namespace voxshell
