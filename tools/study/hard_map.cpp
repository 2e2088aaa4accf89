// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/hard_map.hpp"

#include "study/gnuplot.hpp"
#include "study/palette.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>

namespace voxshell {
namespace {

constexpr const char *head = "case,worst,bound,pair,value,verdict";
constexpr std::size_t fields = 6, most_lines = 10'000;
constexpr const char *verdicts[] = {"holds", "beyond", "refused", "fails"};

/// Of one line; text in quotes may have commas, and quotes twice.
std::vector<std::string> fields_of(const std::string &line)
{
    std::vector<std::string> out(1);
    bool quoted = false;
    for (std::size_t n = 0; n < line.size(); ++n) {
        if (line[n] == '"' && quoted && n + 1 < line.size() && line[n + 1] == '"') {
            out.back() += line[++n];
        } else if (line[n] == '"') {
            quoted = !quoted;
        } else if (line[n] == ',' && !quoted) {
            out.emplace_back();
        } else {
            out.back() += line[n];
        }
    }
    return out;
}

std::size_t place_of(std::vector<std::string> &names, const std::string &name)
{
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    names.push_back(name);
    return names.size() - 1;
}

StudyFigure figure_of(const StudyTable &cases, const std::vector<std::string> &names,
                      const std::vector<std::string> &pairs)
{
    StudyFigure figure{"hard_map",
                       "Hard cases: each on each law and field",
                       "The number is the case's worst; in the left margin what it is to stay within. Light: "
                       "within its bound. Orange: beyond, and this pair does not claim to keep it. Grey: "
                       "refused, the asset lacks the channel. Black: beyond though claimed.",
                       "x,y,value,verdict\n",
                       "",
                       1000,
                       static_cast<int>(180 + 34 * names.size())};
    std::string rows, columns;
    std::vector<std::string> known;
    for (std::size_t n = 0; n < cases.rows.size(); ++n) {
        const std::string name = cases.word(n, "case"), pair = cases.word(n, "pair");
        const auto y = std::find(names.begin(), names.end(), name) - names.begin() + 1;
        const auto x = std::find(pairs.begin(), pairs.end(), pair) - pairs.begin() + 1;
        figure.csv += fmt::format(
            "{},{},{},{}\n", x, y,
            std::isfinite(cases.number(n, "value")) ? fmt::format("{:.2g}", cases.number(n, "value")) : "-",
            cases.word(n, "verdict"));
        if (std::find(known.begin(), known.end(), name) == known.end()) {
            known.push_back(name);
            rows += fmt::format("{}{} {}", rows.empty() ? "" : ", ",
                                gnuplot_text(fmt::format("{}  {:.2g}", name, cases.number(n, "bound"))), y);
        }
    }
    for (std::size_t n = 0; n < pairs.size(); ++n) {
        std::string lines = pairs[n];
        if (const auto slash = lines.find('/'); slash != std::string::npos) lines.replace(slash, 1, "\\n");
        columns += fmt::format("{}\"{}\" {}", n ? ", " : "", lines, n + 1);
    }
    const auto boxes = [](const char *verdict, const char *colour) {
        return fmt::format("$data using (strcol(4) eq '{}' ? $1 : NaN):2:(0.48):(0.46) with boxxyerror fs "
                           "solid noborder lc rgb '{}' notitle, ",
                           verdict, colour);
    };
    figure.script = fmt::format(
        "set lmargin at screen 0.245\nset rmargin at screen 0.99\nset tmargin at screen {:.4f}\nset bmargin "
        "at screen {:.4f}\nunset grid\nset border 0\nset tics scale 0\nset xrange [0.5:{}.5]\nset yrange "
        "[{}.5:0.5]\nset ytics ({}) noenhanced font ',13'\nset xtics ({}) font ',13'\n",
        1 - 14.0 / figure.height, 84.0 / figure.height, pairs.size(), names.size(), rows, columns);
    figure.script += "plot " + boxes("holds", "#cfe3f1") + boxes("beyond", palette::amber) +
                     boxes("refused", palette::faint) + boxes("fails", palette::black) +
                     "$data using (strcol(4) eq 'fails' ? NaN : $1):2:(strcol(3)) with labels font ',12' "
                     "noenhanced notitle, $data using (strcol(4) eq 'fails' ? $1 : NaN):2:(strcol(3)) with "
                     "labels font ',12' textcolor rgb 'white' noenhanced notitle\n";
    return figure;
}

} // namespace

HardMap read_hard_map(const std::filesystem::path &file)
{
    std::ifstream stream(file);
    const auto invalid = [&](std::size_t line, const std::string &what) {
        return Failure(ExitCode::invalid, file.string(),
                       fmt::format("line {}: {}; hard_suite --csv writes such a map", line, what));
    };
    if (!stream) throw Failure(ExitCode::system, file.string(), "cannot be read");
    HardMap map;
    map.cases = {"hard_cases",
                 "Hard cases, one by one",
                 "The case's worst number on this pair of law and field, and the bound that it is to keep.",
                 {{"case", "case"},
                  {"worst", "what is measured"},
                  {"bound", "bound"},
                  {"pair", "law/field"},
                  {"value", "worst"},
                  {"verdict", "verdict"}},
                 {},
                 "hard_map"};
    std::vector<std::string> names, pairs;
    std::string line;
    if (!std::getline(stream, line) || line != head) throw invalid(1, fmt::format("not \"{}\"", head));
    for (std::size_t number = 2; std::getline(stream, line); ++number) {
        const std::vector<std::string> field = fields_of(line);
        if (field.size() != fields || number > most_lines)
            throw invalid(number, fmt::format("{} fields, not {}", field.size(), fields));
        const auto value = [&](const std::string &text) {
            char *end = nullptr;
            const double found = std::strtod(text.c_str(), &end);
            if (*end || text.empty()) throw invalid(number, fmt::format("'{}' is no number", text));
            return found;
        };
        if (std::find(std::begin(verdicts), std::end(verdicts), field[5]) == std::end(verdicts))
            throw invalid(number, fmt::format("verdict '{}'", field[5]));
        place_of(names, field[0]);
        place_of(pairs, field[3]);
        map.cases.rows.push_back(
            {field[0], field[1], value(field[2]), field[3],
             field[4].empty() ? std::numeric_limits<double>::quiet_NaN() : value(field[4]), field[5]});
    }
    if (names.empty()) throw invalid(2, "no case");
    map.totals = {"hard_totals",
                  "Hard cases, how many hold",
                  "",
                  {{"pair", "law/field"},
                   {"cases", "cases"},
                   {"holds", "within the bound"},
                   {"beyond", "beyond, not claimed"},
                   {"refused", "refused"},
                   {"fails", "beyond though claimed"}},
                  {},
                  "hard_map"};
    for (const std::string &pair : pairs) {
        std::vector<std::variant<std::string, double>> row{pair, 0.0};
        for (const char *verdict : verdicts) {
            double count = 0;
            for (std::size_t n = 0; n < map.cases.rows.size(); ++n)
                count += map.cases.word(n, "pair") == pair && map.cases.word(n, "verdict") == verdict;
            row.emplace_back(count);
            std::get<double>(row[1]) += count;
        }
        map.totals.rows.push_back(std::move(row));
    }
    map.figure = figure_of(map.cases, names, pairs);
    return map;
}

} // namespace voxshell
