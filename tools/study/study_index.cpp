// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/study_index.hpp"

#include "study/study_page.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>

namespace voxshell {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::json;

constexpr std::uintmax_t most_bytes = 64 << 20;

std::string read_text(const fs::path &file)
{
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    if (error) throw Failure(ExitCode::system, file.string(), error.message());
    if (size > most_bytes) throw Failure(ExitCode::invalid, file.string(), "too large for a study's");
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::string section(const fs::path &study)
{
    const fs::path file = study / "summary.json";
    try {
        const json told = json::parse(read_text(file));
        if (told.at("schema") != "voxshell-study/1")
            throw Failure(ExitCode::invalid, file.string(), "not voxshell-study/1");
        const std::string name = told.at("study"), folder = study.filename().string();
        std::map<std::string, int> verdicts;
        std::string fails;
        for (const json &claim : told.at("claims")) {
            const std::string verdict = claim.at("verdict");
            ++verdicts[verdict];
            if (verdict != "holds")
                fails += fmt::format("<li>{} <span class=\"verdict\">{}</span></li>\n",
                                     page_text(claim.at("claim")), page_text(verdict));
        }
        const json &figures = told.at("figures");
        std::size_t first = 0;
        while (first + 1 < figures.size() && figures.at(first).contains("absent")) ++first;
        const json &figure = figures.at(first);
        const std::string svg = read_text(study / fs::path(figure.at("svg").get<std::string>()).filename());
        return fmt::format(
            "<h2 id=\"study-{0}\"><a href=\"{1}/index.html\">study {0}</a></h2>\n<p><code>{2}</code>: {3} "
            "claims hold, {4} in part, {5} do not.</p>\n<ul>\n{6}</ul>\n<figure><img alt=\"{7}\" "
            "src=\"data:image/svg+xml;base64,{8}\"><figcaption>{7}</figcaption></figure>\n",
            page_text(name), page_text(folder), page_text(told.at("command")), verdicts["holds"],
            verdicts["holds in part"], verdicts["does not hold"], fails, page_text(figure.at("title")),
            page_base64(svg));
    } catch (const json::exception &error) {
        throw Failure(ExitCode::invalid, file.string(), fmt::format("no study's summary: {}", error.what()));
    }
}

} // namespace

void write_study_index(const fs::path &folder, Outputs &outputs)
{
    std::error_code error;
    std::vector<fs::path> studies;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
        if (fs::exists(at->path() / "summary.json") && fs::exists(at->path() / "index.html"))
            studies.push_back(at->path());
    }
    if (studies.empty())
        throw Failure(ExitCode::system, folder.string(),
                      "no study in its folders; voxshell study paper -o " + (folder / "paper").string() +
                          " makes one");
    std::sort(studies.begin(), studies.end());
    std::string page = page_head("Studies") + "<h1>Studies</h1>\n<p>What runs here, measured: each page says "
                                              "first what does not hold.</p>\n";
    for (const fs::path &study : studies) page += section(study);
    outputs.add(folder / "index.html", page + "</body></html>\n");
}

} // namespace voxshell
