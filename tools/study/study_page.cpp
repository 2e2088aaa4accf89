// SPDX-License-Identifier: GPL-3.0-or-later
// A study as one page that opens from disk: pictures inside, no other file, each number with the row it comes
// from.
#include "study/study_page.hpp"

#include <fmt/format.h>

#include <cmath>

namespace voxshell {
namespace {

constexpr const char *style = R"(
body{font:16px/1.5 sans-serif;max-width:64rem;margin:0 auto;padding:1rem;color:#202020;background:#fff}
h1{line-height:1.2}h2{margin-top:2.5rem;border-top:2px solid #d8d8d8;padding-top:1rem}
figure{margin:1rem 0}figure img{width:100%;max-width:60rem;border:1px solid #d8d8d8}
figcaption,.note,footer{color:#505050}
.wide{overflow-x:auto}
table{border-collapse:collapse;font-size:.85rem;margin:.5rem 0}
th,td{border-bottom:1px solid #d8d8d8;padding:.2rem .5rem;text-align:left;vertical-align:top}
td.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
table.sortable th{cursor:pointer;user-select:none}
table.sortable th[aria-sort=ascending]::after{content:" \2191"}
table.sortable th[aria-sort=descending]::after{content:" \2193"}
code{background:#f2f2f2;padding:.1rem .3rem;overflow-wrap:anywhere}
.verdict{font-weight:bold;white-space:nowrap}
@media screen and (max-width:40rem){table.claims,table.claims tbody,table.claims tr,table.claims td{display:block}}
@media print{body{max-width:none}figure,tr{break-inside:avoid}}
)";

constexpr const char *sorting = R"(
for (const table of document.querySelectorAll('table.sortable')) {
  const body = table.tBodies[0];
  table.querySelectorAll('th').forEach((head, column) => head.addEventListener('click', () => {
    const down = head.getAttribute('aria-sort') === 'ascending';
    table.querySelectorAll('th').forEach(each => each.removeAttribute('aria-sort'));
    head.setAttribute('aria-sort', down ? 'descending' : 'ascending');
    const key = row => { const text = row.cells[column].textContent; return text === '' ? NaN : Number(text); };
    const rows = [...body.rows].sort((a, b) => {
      const x = key(a), y = key(b);
      if (!Number.isNaN(x) && !Number.isNaN(y)) return x - y;
      return a.cells[column].textContent.localeCompare(b.cells[column].textContent);
    });
    body.append(...(down ? rows.reverse() : rows));
  }));
}
)";

std::string source(const std::string &table, std::size_t row, const std::string &column)
{
    return fmt::format("data-csv=\"{}.csv:{}:{}\"", table, row + 1, column);
}

/// The sentence with each number traced to its cell.
std::string measured(const StudyClaim &claim)
{
    std::string out;
    std::size_t next = 0;
    for (const char c : page_text(claim.measured)) {
        if (c != '@' || next >= claim.numbers.size()) {
            out += c;
            continue;
        }
        const StudyNumber &n = claim.numbers[next++];
        out += fmt::format("<span {}>{}</span>", source(n.table, n.row, n.column),
                           std::isfinite(n.value) ? fmt::format(fmt::runtime(n.format), n.value) : "none");
    }
    return out;
}

std::string fails(const Study &study)
{
    std::string out = "<h2 id=\"fails\">What does not hold</h2>\n<ul>\n";
    for (const Verdict verdict : {Verdict::fails, Verdict::partly}) {
        for (const StudyClaim &claim : study.claims) {
            if (claim.verdict != verdict) continue;
            out +=
                fmt::format("<li><a href=\"#claim-{}\">{}</a> <span class=\"verdict\">{}</span>: {}</li>\n",
                            claim.id, page_text(claim.claim), verdict_text(verdict), measured(claim));
        }
    }
    return out + "</ul>\n";
}

std::string answers(const Study &study)
{
    std::string out;
    for (const StudyClaim &answer : study.answers) {
        out += fmt::format("<h2 id=\"answer-{}\">{}</h2>\n<p>{}</p>\n", answer.id, page_text(answer.claim),
                           measured(answer));
        if (!answer.why.empty()) out += fmt::format("<p class=\"note\">{}</p>\n", page_text(answer.why));
    }
    return out;
}

std::string claims(const Study &study)
{
    std::string out = "<h2 id=\"claims\">Claim by claim</h2>\n<div class=\"wide\"><table "
                      "class=\"sortable claims\"><thead><tr><th>claim</th><th>verdict</th><th>what we "
                      "measure</th><th>why</th></tr></thead>\n<tbody>\n";
    for (const StudyClaim &claim : study.claims) {
        out += fmt::format(
            "<tr id=\"claim-{}\"><td>{}</td><td class=\"verdict\">{}</td><td>{}</td><td>{}</td></tr>\n",
            claim.id, page_text(claim.claim), verdict_text(claim.verdict), measured(claim),
            page_text(claim.why));
    }
    return out + "</tbody></table></div>\n";
}

std::string table_text(const StudyTable &table)
{
    std::string out =
        fmt::format("<h3 id=\"table-{0}\">{1}</h3>\n<p class=\"note\">{2} All columns: "
                    "<code>{4}.csv</code>{3}</p>\n<div class=\"wide\"><table class=\"sortable\"><thead><tr>",
                    table.id, page_text(table.title), page_text(table.note),
                    table.timing_csv().empty() || table.columns[0].timed
                        ? ""
                        : fmt::format("; times: <code>{}_timing.csv</code>", table.id),
                    table.file_of(table.columns[0].name));
    for (const StudyColumn &column : table.columns) {
        if (!column.label.empty()) out += "<th>" + page_text(column.label) + "</th>";
    }
    out += "</tr></thead>\n<tbody>\n";
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        out += "<tr>";
        for (std::size_t n = 0; n < table.columns.size(); ++n) {
            if (table.columns[n].label.empty()) continue;
            const auto &value = table.rows[row][n];
            if (const auto *text = std::get_if<std::string>(&value)) {
                out += "<td>" + page_text(*text) + "</td>";
            } else {
                const double number = std::get<double>(value);
                out += fmt::format("<td class=\"n\" {}>{}</td>",
                                   source(table.file_of(table.columns[n].name), row, table.columns[n].name),
                                   std::isfinite(number) ? fmt::format("{:.3g}", number) : "");
            }
        }
        out += "</tr>\n";
    }
    return out + "</tbody></table></div>\n";
}

} // namespace

std::string page_text(const std::string &text)
{
    std::string out;
    for (const char c : text) {
        out += c == '&'   ? "&amp;"
               : c == '<' ? "&lt;"
               : c == '>' ? "&gt;"
               : c == '"' ? "&quot;"
                          : std::string(1, c);
    }
    return out;
}

std::string page_base64(const std::string &bytes)
{
    constexpr const char *digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t n = 0; n < bytes.size(); n += 3) {
        std::uint32_t three = 0;
        for (std::size_t i = 0; i < 3; ++i)
            three = three << 8 | (n + i < bytes.size() ? static_cast<std::uint8_t>(bytes[n + i]) : 0u);
        for (std::size_t i = 0; i < 4; ++i)
            out += n + i > bytes.size() ? '=' : digits[three >> (18 - 6 * i) & 63];
    }
    return out;
}

std::string page_head(const std::string &title)
{
    return fmt::format(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta "
        "name=\"viewport\" content=\"width=device-width\">\n<title>{}</title>\n<link rel=\"icon\" "
        "href=\"data:,\">\n<style>{}</style></head>\n<body>\n",
        page_text(title), style);
}

std::string study_page(const Study &study, const std::vector<std::string> &svg)
{
    std::string out =
        page_head(study.title) +
        fmt::format("<h1>{0}</h1>\n<p>{1}</p>\n<p>Made by <code>{2}</code>. Click on a table's head to sort "
                    "it.</p>\n",
                    page_text(study.title), page_text(study.lead), page_text(study.command));
    out += "<nav><a href=\"#fails\">What does not hold</a> | <a href=\"#claims\">Claim by claim</a>";
    for (const StudyFigure &figure : study.figures) {
        out += fmt::format(" | <a href=\"#figure-{}\">{}</a>", figure.id,
                           page_text(figure.title.substr(0, figure.title.find(':'))));
    }
    out += "</nav>\n" + fails(study) + answers(study) + claims(study);
    for (std::size_t n = 0; n < study.figures.size(); ++n) {
        const StudyFigure &figure = study.figures[n];
        out += fmt::format("<h2 id=\"figure-{}\">{}</h2>\n", figure.id, page_text(figure.title));
        if (figure.absent.empty())
            out += fmt::format("<figure><img alt=\"{1}\" src=\"data:image/svg+xml;base64,{2}\">\n"
                               "<figcaption>{3} Numbers: <code>{0}.csv</code>. Made by "
                               "<code>{4}</code></figcaption></figure>\n",
                               figure.id, page_text(figure.title), page_base64(svg[n]),
                               page_text(figure.caption), page_text(study.command));
        else
            out += fmt::format("<p class=\"absent\">No picture: {}</p>\n", page_text(figure.absent));
        for (const StudyTable &table : study.tables) {
            if (table.figure == figure.id) out += table_text(table);
        }
    }
    return out + fmt::format("<footer><p>voxshell {}</p></footer>\n<script>{}</script>\n</body></html>\n",
                             tool_version(), sorting);
}

} // namespace voxshell
