// SPDX-License-Identifier: GPL-3.0-or-later
// The report against what another program found in the shared STL files (closed_manifold in MANIFEST.tsv).
#define DOCTEST_CONFIG_IMPLEMENT
#include "import/scene.hpp"
#include "mesh/report.hpp"

#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

using namespace voxshell;

namespace {

const std::filesystem::path data = VXS_TEST_DATA;

std::uint64_t number(const std::string &text, const char *pattern)
{
    std::smatch match;
    return std::regex_search(text, match, std::regex(pattern)) ? std::stoull(match[1]) : 0;
}

} // namespace

TEST_CASE("boundary and non-manifold edges, shells, closedness")
{
    std::ifstream manifest(data / "MANIFEST.tsv");
    int files = 0;
    for (std::string line; std::getline(manifest, line);) {
        std::vector<std::string> column;
        std::istringstream fields(line);
        for (std::string field; std::getline(fields, field, '\t');) column.push_back(field);
        if (column.size() < 11 || column[10].rfind("convert", 0) != 0) continue;
        if (!std::regex_search(column[0], std::regex("^(stl|hard)/[^/]*\\.(stl|STL)$"))) continue;
        const std::string &found = column[7];
        CAPTURE(column[0]);
        CAPTURE(found);
        ImportOptions options;
        options.unit = 1.0;
        const MeshReport r = report(flatten(import_scene(data / column[0], options)));
        ++files;
        CHECK(r.triangles == number(column[5], "^(\\d+)"));
        CHECK(r.boundary_edges == number(found, "open \\((\\d+) boundary"));
        // The other program keeps triangles without area and connects shells by vertices too.
        const std::uint64_t non_manifold = number(found, "non-manifold \\((\\d+) edge");
        CHECK((r.degenerate ? r.non_manifold_edges <= non_manifold : r.non_manifold_edges == non_manifold));
        CHECK(r.duplicate == number(found, "(\\d+) duplicate"));
        const std::uint64_t shells = number(found, "(\\d+) shell");
        CHECK((r.boundary_edges ? r.shells >= shells : r.shells == shells));
        if (found.rfind("closed", 0) == 0) CHECK(r.closed);
        if (r.boundary_edges) CHECK_FALSE(r.closed);
    }
    CHECK(files > 20);
}

int main(int argc, char **argv)
{
    if (!std::filesystem::exists(data / "MANIFEST.tsv")) {
        std::puts("skipped: the shared data are not here");
        return 77;
    }
    return doctest::Context(argc, argv).run();
}
