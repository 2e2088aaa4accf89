// SPDX-License-Identifier: GPL-3.0-or-later
// The report against what another program found in the shared STL files (closed_manifold in MANIFEST.tsv).
#define DOCTEST_CONFIG_IMPLEMENT
#include "import/scene.hpp"
#include "mesh/intersections.hpp"
#include "mesh/mend.hpp"
#include "mesh/report.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
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
    int files = 0, stitched = 0;
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
        Mesh mesh = flatten(import_scene(data / column[0], options));
        const MeshReport r = report(mesh);
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

        // The other program does not count faces that only touch, but does count duplicates.
        Progress silent;
        const std::uint64_t cut = number(found, "(\\d+) self-intersecting");
        const auto self = self_intersections(mesh, 1'000'000'000, silent);
        REQUIRE(self.has_value());
        if (r.duplicate == 0) CHECK(*self >= cut);
        const std::string name = column[0].substr(column[0].find('/') + 1);
        for (const char *same : {"three_cubes_overlapping.stl", "trimesh_soup.stl", "cgal_pig.stl", "assimp_Spider_binary.stl"})
            if (name == same) CHECK(*self == cut);

        // A weld of 1e-6 of the diagonal leaves as many boundary edges as the other program's, which also lets
        // shorter edges collapse.
        if (found.find("left after a 1e-6") == std::string::npos) continue;
        Point low = mesh.vertices[0], high = low;
        for (const Point &p : mesh.vertices)
            for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
        const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
        stitch(mesh, 1e-6 * diagonal);
        const std::uint64_t left = number(found, "(\\d+) boundary edges left");
        CHECK(report(mesh).boundary_edges >= left);
        CHECK(report(mesh).boundary_edges <= left + (name.starts_with("kuka")));
        ++stitched;
    }
    CHECK(files > 20);
    CHECK(stitched > 8);
}

int main(int argc, char **argv)
{
    if (!std::filesystem::exists(data / "MANIFEST.tsv")) {
        std::puts("skipped: the shared data are not here");
        return 77;
    }
    return doctest::Context(argc, argv).run();
}
