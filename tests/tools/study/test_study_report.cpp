// SPDX-License-Identifier: GPL-3.0-or-later
// A figure without a value has no picture: its CSV, the summary and the page say why.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "study/study_report.hpp"
#include "study/temporary_folder.hpp"

#include <fstream>
#include <iterator>

using namespace voxshell;

namespace {

std::string text_of(const std::filesystem::path &path)
{
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

} // namespace

TEST_CASE("what cannot be drawn is left out, in a sentence")
{
    Study study;
    study.name = "accuracy";
    StudyFigure figure{"filter", "Filter: delay", "Each curve.", "hertz,delay\n", "plot $data\n", 900, 500};
    figure.absent = "the hand rests, it says \"so\".";
    study.figures.push_back(figure);
    const TemporaryFolder folder;
    Outputs outputs(false);
    Progress unseen;
    write_study(study, folder.path / "study", outputs, unseen);
    outputs.commit();
    CHECK(text_of(folder.path / "study/filter.csv") == "absent\n\"the hand rests, it says \"\"so\"\".\"\n");
    CHECK(!std::filesystem::exists(folder.path / "study/filter.svg"));
    CHECK(!std::filesystem::exists(folder.path / "study/filter.png"));
    const std::string page = text_of(folder.path / "study/index.html"),
                      told = text_of(folder.path / "study/summary.json");
    CHECK(page.find("No picture: the hand rests, it says &quot;so&quot;.") != std::string::npos);
    CHECK(page.find("<img") == std::string::npos);
    CHECK(told.find("\"absent\": \"the hand rests, it says \\\"so\\\".\"") != std::string::npos);
    CHECK(told.find("filter.svg") == std::string::npos);
}
