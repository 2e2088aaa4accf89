// SPDX-License-Identifier: GPL-3.0-or-later
// The parts that must not go wrong: hand-made ones, always there, and the STL files of the shared data.
#pragma once

#include "import/scene.hpp"
#include "mesh/orient.hpp"
#include "mesh/report.hpp"
#include "solids.hpp"

#include <algorithm>
#include <cctype>
#include <functional>
#include <random>
#include <string>
#include <vector>

namespace parts {

using namespace voxshell;
namespace fs = std::filesystem;

struct Part {
    std::string name;
    Mesh mesh; ///< turned outwards, as the pipeline hands it on
};

inline double longest_side(const Mesh &mesh)
{
    double longest = 0;
    for (int a = 0; a < 3; ++a) {
        double low = mesh.vertices[0][a], high = low;
        for (const Point &p : mesh.vertices) low = std::min(low, p[a]), high = std::max(high, p[a]);
        longest = std::max(longest, high - low);
    }
    return longest;
}

inline Mesh moved(Mesh mesh, const std::function<Point(const Point &)> &place)
{
    for (Point &p : mesh.vertices) p = place(p);
    return mesh;
}

/// Tilted so that no face is parallel to anything.
inline Point tilted(const Point &p)
{
    return {0.8 * p[0] - 0.6 * p[1] + 0.01, 0.48 * p[0] + 0.64 * p[1] - 0.6 * p[2] - 0.02,
            0.36 * p[0] + 0.48 * p[1] + 0.8 * p[2] + 0.03};
}

/// A ring of `around` x `section` quads about the y axis.
inline Mesh torus(double radius, double thick, std::uint32_t around, std::uint32_t section)
{
    Mesh mesh;
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < section; ++j) {
            const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / section,
                         r = radius + thick * std::cos(v);
            mesh.vertices.push_back({r * std::cos(u), thick * std::sin(v), r * std::sin(u)});
        }
    for (std::uint32_t i = 0; i < around; ++i)
        for (std::uint32_t j = 0; j < section; ++j) {
            const std::uint32_t in = (i + 1) % around, jn = (j + 1) % section, a = i * section + j,
                                b = i * section + jn, c = in * section + jn, d = in * section + j;
            mesh.triangles.push_back({a, b, c});
            mesh.triangles.push_back({a, c, d});
        }
    return mesh;
}

inline std::vector<Part> hand_made()
{
    const Mesh cube =
        solids::box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}); // 24 cells: its faces lie on grid planes
    const Mesh ball = solids::sphere({0, 0, 0}, 0.5, 12);
    std::vector<Part> all{
        {"cube on grid planes", cube},
        {"cube on cell centres", moved(cube,
                                       [](const Point &p) {
                                           return Point{p[0] + 1.0 / 48, p[1] + 1.0 / 48, p[2] + 1.0 / 48};
                                       })},
        {"tilted cube", moved(cube, tilted)},
        {"ball inside out", solids::turned_inside_out(ball)},
        {"needle", moved(ball,
                         [](const Point &p) {
                             return tilted({p[0], 1e-5 * p[1], 1e-5 * p[2]});
                         })},
        {"plate thinner than a lattice unit", moved(cube,
                                                    [](const Point &p) {
                                                        return tilted({p[0], 1e-7 * p[1], p[2]});
                                                    })},
        {"ring of slivers", torus(0.4, 0.1, 3, 300)},
        {"cubes that share an edge", solids::join(cube, solids::box({0.5, 0.5, -0.5}, {1, 1, 0.5}))},
        {"solids through each other", solids::join(moved(cube, tilted), ball)},
    };
    Mesh tripled = cube, soup;
    for (int n = 0; n < 2; ++n)
        tripled.triangles.insert(tripled.triangles.end(), cube.triangles.begin(), cube.triangles.end());
    all.push_back({"every face three times", tripled});
    std::mt19937 random(4);
    for (std::uint32_t t = 0; t < 200;
         ++t) { // sizes from a lattice unit to the whole box, corners often on planes
        const double size = std::pow(2.0, -static_cast<double>(random() % 18));
        const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0; };
        const Point at{std::floor(24 * unit()) / 24, std::floor(24 * unit()) / 24, unit()};
        for (int v = 0; v < 3; ++v)
            soup.vertices.push_back(
                {at[0] + size * (v == 1), at[1] + size * unit() * (v == 2), at[2] + size * unit()});
        soup.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    all.push_back({"soup of all sizes", soup});
    for (Part &part : all) orient(part.mesh);
    return all;
}

/// The .stl files of these folders of the shared data, in millimetres or metres; none if the data are not
/// here.
inline std::vector<Part> from_data(std::initializer_list<const char *> folders)
{
    std::vector<fs::path> files;
    for (const char *folder : folders) {
        std::error_code none;
        for (const auto &entry : fs::directory_iterator(fs::path(VXS_TEST_DATA) / folder, none)) {
            std::string ending = entry.path().extension().string();
            for (char &c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
            if (ending == ".stl") files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    std::vector<Part> all;
    for (const fs::path &file : files) {
        ImportOptions options;
        options.unit = 1e-3;
        all.push_back({file.filename().string(), flatten(import_scene(file, options))});
        options.unit = 1;
        if (longest_side(all.back().mesh) < 1e-3) all.back().mesh = flatten(import_scene(file, options));
        orient(all.back().mesh);
    }
    return all;
}

} // namespace parts
