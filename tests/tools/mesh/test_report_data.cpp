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
#include <sstream>
#include <string_view>

using namespace voxshell;

namespace {

const std::filesystem::path data = VXS_TEST_DATA;

/// The first number that stands right between `before` and `after`, 0 if none does.
std::uint64_t number(std::string_view text, std::string_view before, std::string_view after)
{
    for (std::size_t at = text.find(after); at != text.npos; at = text.find(after, at + 1)) {
        std::size_t first = at;
        while (first > 0 && text[first - 1] >= '0' && text[first - 1] <= '9') --first;
        if (first < at && text.substr(0, first).ends_with(before))
            return std::stoull(std::string(text.substr(first, at - first)));
    }
    return 0;
}

bool is_stl(const std::filesystem::path &path)
{
    return (path.parent_path() == "stl" || path.parent_path() == "hard") &&
           (path.extension() == ".stl" || path.extension() == ".STL");
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
        if (!is_stl(column[0])) continue;
        const std::string &found = column[7];
        CAPTURE(column[0]);
        CAPTURE(found);
        ImportOptions options;
        options.unit = 1.0;
        Mesh mesh = flatten(import_scene(data / column[0], options));
        const MeshReport r = report(mesh);
        ++files;
        CHECK(r.triangles == std::stoull(column[5]));
        CHECK(r.boundary_edges == number(found, "open (", " boundary"));
        // The other program keeps triangles without area and connects shells by vertices too.
        const std::uint64_t non_manifold = number(found, "non-manifold (", " edge");
        CHECK((r.degenerate ? r.non_manifold_edges <= non_manifold : r.non_manifold_edges == non_manifold));
        CHECK(r.duplicate == number(found, "", " duplicate"));
        const std::uint64_t shells = number(found, "", " shell");
        CHECK((r.boundary_edges ? r.shells >= shells : r.shells == shells));
        if (found.rfind("closed", 0) == 0) CHECK(r.closed);
        if (r.boundary_edges) CHECK_FALSE(r.closed);

        // The other program does not count faces that only touch, but does count duplicates.
        Progress silent;
        const std::uint64_t cut = number(found, "", " self-intersecting");
        const auto self = self_intersections(mesh, 1'000'000'000, silent);
        REQUIRE(self.has_value());
        if (r.duplicate == 0) CHECK(*self >= cut);
        const std::string name = column[0].substr(column[0].find('/') + 1);
        for (const char *same :
             {"three_cubes_overlapping.stl", "trimesh_soup.stl", "cgal_pig.stl", "assimp_Spider_binary.stl"})
            if (name == same) CHECK(*self == cut);

        // A weld of 1e-6 of the diagonal leaves as many boundary edges as the other program's, which also
        // lets shorter edges collapse.
        if (found.find("left after a 1e-6") == std::string::npos) continue;
        Point low = mesh.vertices[0], high = low;
        for (const Point &p : mesh.vertices)
            for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
        const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
        stitch(mesh, 1e-6 * diagonal);
        const std::uint64_t left = number(found, "", " boundary edges left");
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
