// SPDX-License-Identifier: GPL-3.0-or-later
// Files that nobody here made, against the manifest that somebody else measured: triangles after instancing,
// bounding box, converted or refused. Skipped where the data set is not there.
#define DOCTEST_CONFIG_IMPLEMENT
#include "import_test.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <sstream>

using namespace import_test;

namespace {

using Row = std::map<std::string, std::string>;

std::filesystem::path data_folder()
{
    const char *chosen = std::getenv("VOXSHELL_DATA");
    return chosen && *chosen ? chosen : VXS_TEST_DATA;
}

std::vector<Row> manifest()
{
    std::vector<Row> rows;
    std::vector<std::string> names;
    std::ifstream file(data_folder() / "MANIFEST.tsv");
    for (std::string line; std::getline(file, line);) {
        std::vector<std::string> cells;
        std::istringstream split(line);
        for (std::string cell; std::getline(split, cell, '\t');) cells.push_back(cell);
        if (names.empty()) {
            names = cells;
            continue;
        }
        Row row;
        for (std::size_t i = 0; i < std::min(names.size(), cells.size()); ++i) row[names[i]] = cells[i];
        const std::string &path = row["path"];
        const std::string ending = std::filesystem::path(path).extension();
        if (ending != ".off" && row["expected"] != "-" && !row["expected"].empty()) rows.push_back(row);
    }
    return rows;
}

} // namespace

TEST_CASE("the data set comes out as its manifest says")
{
    std::size_t converted = 0, refused = 0, measured = 0;
    for (Row &row : manifest()) {
        const std::string path = row["path"], expected = row["expected"];
        CAPTURE(path);
        voxshell::ImportOptions options;
        if (std::filesystem::path(path).extension() == ".stl" ||
            std::filesystem::path(path).extension() == ".STL") {
            options.unit = 1.0;
        }
        const std::string message = refusal(data_folder() / path, options);
        if (message != "converted") {
            ++refused;
            CHECK_MESSAGE(expected != "convert", message);
            CHECK((message[0] >= '2' && message[0] <= '5'));
            continue;
        }
        ++converted;
        CHECK(expected != "reject");
        const voxshell::Mesh mesh = voxshell::flatten(voxshell::import_scene(data_folder() / path, options));
        CHECK(mesh.triangles.size() == std::strtoull(row["triangles"].c_str(), nullptr, 10));
        double size[3];
        if (std::sscanf(row["bbox_size"].c_str(), "%lf x %lf x %lf", &size[0], &size[1], &size[2]) != 3)
            continue;
        ++measured;
        const Box b = box(mesh);
        const double largest = std::max({size[0], size[1], size[2]});
        for (std::size_t a = 0; a < 3; ++a) CHECK(std::abs(b.size(a) - size[a]) < 1e-5 * largest);
    }
    MESSAGE(converted << " converted, " << refused << " refused, " << measured << " measured");
    CHECK(converted > 50);
    CHECK(refused > 40);
    CHECK(measured > 50);
}

int main(int argc, char **argv)
{
    if (!std::filesystem::exists(data_folder() / "MANIFEST.tsv")) {
        std::printf("skipped: no data set at %s\n", data_folder().c_str());
        return 77;
    }
    return doctest::Context(argc, argv).run();
}
