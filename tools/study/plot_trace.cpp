// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/trace.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

double magnitude(const Point &force)
{
    return std::hypot(force[0], force[1], force[2]);
}

} // namespace

std::vector<std::uint8_t> plot_trace(const std::vector<TraceRow> &rows, const std::string &title,
                                     Picture picture)
{
    std::string script = "$trace << END\n";
    double highest = 0;
    for (const TraceRow &row : rows) {
        const double collision = magnitude(row.collision_force), output = magnitude(row.output_force);
        highest = std::max({highest, collision, output});
        script += fmt::format("{} {} {}\n", row.t, collision, output);
    }
    script += "END\n";
    script += gnuplot_sheet(picture, 900, 480);
    script += "set title " + gnuplot_text(title) +
              " noenhanced\n"
              "set xlabel 'time [s]'\n"
              "set ylabel 'force, magnitude [N]'\n"
              "set key top right Left reverse samplen 3 opaque box lc rgb '#d8d8d8'\n";
    script += fmt::format("set xrange [0:{}]\nset yrange [0:{}]\n", rows.empty() ? 1.0 : rows.back().t,
                          highest > 0 ? 1.15 * highest : 1.0);
    script += "plot $trace using 1:2 with lines lw 0.7 lc rgb '#d95f02' title 'collision force', "
              "$trace using 1:3 with lines lw 3 lc rgb '#1b3f8b' title 'output force'\n";

    return gnuplot(script);
}

} // namespace voxshell
