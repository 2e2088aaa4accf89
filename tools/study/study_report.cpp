// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/study_report.hpp"

#include "study/gnuplot.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;
using Value = std::variant<std::string, double>;

std::string quoted(const std::string &text)
{
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
    return out + '"';
}

std::size_t column_of(const StudyTable &table, const std::string &name)
{
    const auto found = std::find_if(table.columns.begin(), table.columns.end(),
                                    [&](const StudyColumn &c) { return c.name == name; });
    if (found == table.columns.end()) throw Failure(ExitCode::bug, table.id, "no column " + name);
    return static_cast<std::size_t>(found - table.columns.begin());
}

json as_json(const Value &value)
{
    if (const auto *text = std::get_if<std::string>(&value)) return *text;
    const double number = std::get<double>(value);
    return std::isfinite(number) ? json(number) : json(nullptr);
}

json as_json(const std::vector<StudyNumber> &numbers)
{
    json out = json::array();
    for (const StudyNumber &n : numbers) {
        out.push_back({{"value", as_json(Value(n.value))},
                       {"csv", n.table + ".csv"},
                       {"row", n.row + 1},
                       {"column", n.column}});
    }
    return out;
}

json as_json(const StudyTable &table)
{
    json columns = json::array(), rows = json::array();
    for (const StudyColumn &column : table.columns) {
        columns.push_back({{"name", column.name}, {"label", column.label}});
        if (column.timed) columns.back()["csv"] = table.file_of(column.name) + ".csv";
    }
    for (const auto &row : table.rows) {
        json line = json::array();
        for (const Value &value : row) line.push_back(as_json(value));
        rows.push_back(line);
    }
    return {{"id", table.id},
            {"title", table.title},
            {"csv", table.file_of(table.columns[0].name) + ".csv"},
            {"columns", columns},
            {"rows", rows}};
}

} // namespace

namespace {

std::string csv_of(const StudyTable &table, bool timed)
{
    const auto is_in = [&](std::size_t n) { return table.columns[n].timed == timed || (timed && n == 0); };
    std::string text;
    for (std::size_t n = 0; n < table.columns.size(); ++n) {
        if (is_in(n)) text += (text.empty() ? "" : ",") + table.columns[n].name;
    }
    text += '\n';
    for (const auto &row : table.rows) {
        std::string line;
        for (std::size_t n = 0; n < row.size(); ++n) {
            if (!is_in(n)) continue;
            if (n) line += ',';
            if (const auto *word = std::get_if<std::string>(&row[n])) {
                line += quoted(*word);
            } else if (const double number = std::get<double>(row[n]); std::isfinite(number)) {
                line += fmt::format("{}", number);
            }
        }
        text += line + '\n';
    }
    return text;
}

} // namespace

std::string StudyTable::csv() const
{
    return csv_of(*this, false);
}

std::string StudyTable::timing_csv() const
{
    return std::any_of(columns.begin(), columns.end(), [](const StudyColumn &c) { return c.timed; })
               ? csv_of(*this, true)
               : std::string();
}

std::string StudyTable::file_of(const std::string &column) const
{
    return columns[column_of(*this, column)].timed ? id + "_timing" : id;
}

double StudyTable::number(std::size_t row, const std::string &column) const
{
    const auto *value =
        row < rows.size() ? std::get_if<double>(&rows[row][column_of(*this, column)]) : nullptr;
    if (!value) throw Failure(ExitCode::bug, id, "no number in " + column);
    return *value;
}

const std::string &StudyTable::word(std::size_t row, const std::string &column) const
{
    const auto *value =
        row < rows.size() ? std::get_if<std::string>(&rows[row][column_of(*this, column)]) : nullptr;
    if (!value) throw Failure(ExitCode::bug, id, "no word in " + column);
    return *value;
}

const StudyTable &Study::table(const std::string &id) const
{
    for (const StudyTable &each : tables) {
        if (each.id == id) return each;
    }
    throw Failure(ExitCode::bug, "", "no table " + id);
}

StudyNumber study_number(const StudyTable &table, std::size_t row, const std::string &column,
                         const std::string &format)
{
    return {table.file_of(column), row, column, table.number(row, column), format};
}

std::string verdict_text(Verdict verdict)
{
    return verdict == Verdict::holds    ? "holds"
           : verdict == Verdict::partly ? "holds in part"
                                        : "does not hold";
}

std::string study_json(const Study &study)
{
    json options = json::object(), claims = json::array(), figures = json::array(), tables = json::array();
    for (const auto &[name, value] : study.options) options[name] = value;
    for (const StudyClaim &claim : study.claims) {
        const json numbers = as_json(claim.numbers);
        claims.push_back({{"id", claim.id},
                          {"claim", claim.claim},
                          {"verdict", verdict_text(claim.verdict)},
                          {"measured", claim.measured},
                          {"why", claim.why},
                          {"numbers", numbers}});
    }
    for (const StudyFigure &figure : study.figures) {
        figures.push_back({{"id", figure.id}, {"title", figure.title}, {"csv", figure.id + ".csv"}});
        if (figure.absent.empty()) {
            figures.back()["svg"] = figure.id + ".svg";
            figures.back()["png"] = figure.id + ".png";
        } else {
            figures.back()["absent"] = figure.absent;
        }
        if (figure.timed) figures.back()["timed"] = true;
    }
    for (const StudyTable &table : study.tables) tables.push_back(as_json(table));
    json out = {{"schema", "voxshell-study/1"}, {"version", tool_version()}, {"study", study.name},
                {"command", study.command},     {"options", options},        {"claims", claims},
                {"figures", figures},           {"tables", tables}};
    for (const StudyClaim &answer : study.answers)
        out["answers"].push_back({{"id", answer.id},
                                  {"question", answer.claim},
                                  {"answer", answer.measured},
                                  {"numbers", as_json(answer.numbers)}});
    return out.dump(1) + "\n";
}

void write_study(const Study &study, const std::filesystem::path &folder, Outputs &outputs,
                 Progress &progress)
{
    struct Drawn {
        std::vector<std::uint8_t> svg, png;
    };
    std::vector<Drawn> drawn(study.figures.size());
    progress.stage("pictures", drawn.size());
    tbb::parallel_for(std::size_t{0}, drawn.size(), [&](std::size_t n) {
        progress.check();
        const StudyFigure &figure = study.figures[n];
        const auto draw = [&](Picture picture) {
            return gnuplot(gnuplot_sheet(picture, figure.width, figure.height) + "$data << END\n" +
                           figure.csv.substr(figure.csv.find('\n') + 1) +
                           "END\nset datafile separator ','\n" +
                           gnuplot_command(study.command, figure.height) + figure.script);
        };
        if (figure.absent.empty()) drawn[n] = {draw(Picture::svg), draw(Picture::png)};
        progress.advance(1);
    });
    std::vector<std::string> svg;
    for (std::size_t n = 0; n < drawn.size(); ++n) {
        const StudyFigure &figure = study.figures[n];
        svg.emplace_back(drawn[n].svg.begin(), drawn[n].svg.end());
        if (!figure.absent.empty()) {
            outputs.add(folder / (figure.id + ".csv"), "absent\n" + quoted(figure.absent) + "\n");
            continue;
        }
        outputs.add(folder / (figure.id + ".csv"), figure.csv);
        outputs.add(folder / (figure.id + ".svg"), svg.back());
        outputs.add(folder / (figure.id + ".png"), std::move(drawn[n].png));
    }
    for (const auto *tables : {&study.tables, &study.timings}) {
        for (const StudyTable &table : *tables) {
            if (!table.columns[0].timed) outputs.add(folder / (table.id + ".csv"), table.csv());
            if (const std::string timing = table.timing_csv(); !timing.empty())
                outputs.add(folder / (table.id + "_timing.csv"), timing);
        }
    }
    outputs.add(folder / "summary.json", study_json(study));
    outputs.add(folder / "index.html", study_page(study, svg));
}

} // namespace voxshell
