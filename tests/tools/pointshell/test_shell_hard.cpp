// SPDX-License-Identifier: GPL-3.0-or-later
// Every STL file of the shared data: open, inverted, torn, tripled. The rules of a shell hold for all of
// them.
#define DOCTEST_CONFIG_IMPLEMENT
#include "rules.hpp"

#include "import/scene.hpp"
#include "mesh/orient.hpp"

#include <doctest/doctest.h>

#include <cctype>
#include <cstdio>
#include <filesystem>

using namespace voxshell;
namespace fs = std::filesystem;

namespace {

std::vector<fs::path> stl_files()
{
    std::vector<fs::path> files;
    for (const char *folder : {"hard", "stl"}) {
        std::error_code none;
        for (const auto &entry : fs::directory_iterator(fs::path(VXS_TEST_DATA) / folder, none)) {
            std::string ending = entry.path().extension().string();
            for (char &c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            if (ending == ".stl") files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

} // namespace

TEST_CASE("every STL file makes a shell that keeps the rules")
{
    for (const fs::path &file : stl_files()) {
        CAPTURE(file.string());
        ImportOptions options;
        options.unit = 1e-3;
        Mesh mesh = flatten(import_scene(file, options));
        orient(mesh);
        Point low = mesh.vertices[0], high = low;
        for (const Point &p : mesh.vertices)
            for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
        const double longest = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
        for (const double cells : {17.0, 48.0}) {
            const Made made = make(mesh, longest / cells);
            check_rules(made);
            CHECK(made.shell.surface_error <=
                  longest * 0x1p-21); // floats as large as the part, and its place
        }
    }
}

int main(int argc, char **argv)
{
    if (stl_files().empty()) {
        std::puts("skipped: the shared data are not here");
        return 77;
    }
    return doctest::Context(argc, argv).run();
}
