// SPDX-License-Identifier: GPL-3.0-or-later
// A trace as CSV reads back the same, as a picture it is one.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include "study/trace.hpp"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <limits>
#include <sstream>

using namespace voxshell;

namespace {

std::vector<TraceRow> rows()
{
    std::vector<TraceRow> rows(3);
    rows[1].t = 0.1 + 0.2;
    rows[1].device = {1.0 / 3, -2e-300, std::numeric_limits<double>::denorm_min()};
    rows[1].hand = {1e22, -0.0, 5};
    rows[1].body = {-1e-9, 11, 12};
    rows[1].collision_force = {0.1, 0.2, 0.3};
    rows[1].collision_torque = {4, 5, 6};
    rows[1].output_force = {7, 8, 9};
    rows[1].contacts = 42;
    rows[1].flags = 0xffffffff;
    rows[1].energy = -0.125;
    rows[2].t = 1;
    return rows;
}

} // namespace

TEST_CASE("every number of the CSV reads back as the same double")
{
    std::istringstream text(trace_csv(rows()));
    std::string line, cell;
    std::getline(text, line);
    CHECK(std::count(line.begin(), line.end(), ',') == 21);
    std::getline(text, line);
    CHECK(line == "0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0");
    std::getline(text, line);
    std::istringstream cells(line);
    std::vector<double> values;
    while (std::getline(cells, cell, ',')) {
        double value = 0;
        const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        CHECK(error == std::errc{});
        CHECK(end == cell.data() + cell.size());
        values.push_back(value);
    }
    const TraceRow r = rows()[1];
    const std::vector<double> expected{r.t, r.device[0], r.device[1],  r.device[2], 1e22, -0.0, 5, -1e-9, 11,
                                       12,  0.1,         0.2,          0.3,         4,    5,    6, 7,     8,
                                       9,   42,          4294967295.0, -0.125};
    CHECK(values == expected);
}

TEST_CASE("a picture")
{
    CHECK(picture_of("a/b.svg") == Picture::svg);
    CHECK(picture_of("b.png") == Picture::png);
    CHECK_THROWS_AS(picture_of("b.pdf"), Failure);
    const char *path = std::getenv("PATH");
    const std::string kept = path ? path : "";
    setenv("PATH", "/nonexistent", 1);
    try {
        plot_trace(rows(), "x", Picture::svg);
        FAIL("drawn without gnuplot");
    } catch (const Failure &failure) {
        CHECK(failure.code == ExitCode::system);
        CHECK(std::string(failure.what()).find("gnuplot is not installed") == 0);
    }
    setenv("PATH", kept.c_str(), 1);
    if (std::system("command -v gnuplot >/dev/null") != 0) {
        MESSAGE("gnuplot is not installed: nothing drawn");
        return;
    }
    const auto svg = plot_trace(rows(), "a 'quoted' title; `x`", Picture::svg);
    const std::string text(svg.begin(), svg.end());
    CHECK(text.find("<svg") != std::string::npos);
    CHECK(text.find("collision force") != std::string::npos);
    CHECK(text.find("time [s]") != std::string::npos);
    CHECK(plot_trace(rows(), "x", Picture::svg) == plot_trace(rows(), "x", Picture::svg));
    const auto png = plot_trace(rows(), "x", Picture::png);
    REQUIRE(png.size() > 1000);
    CHECK(std::string(png.begin() + 1, png.begin() + 4) == "PNG");
    CHECK_FALSE(plot_trace({}, "", Picture::svg).empty());
}
