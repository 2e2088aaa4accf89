// SPDX-License-Identifier: GPL-3.0-or-later
// Figures 2 and 5: a slice of the contact, with what its points do.
#include "study/gnuplot.hpp"
#include "study/palette.hpp"
#include "study/paper_points.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace voxshell {
namespace {

constexpr double arrow = 2.5; ///< e on the sheet for a force of k e
constexpr const char *head = "panel,kind,x_e,z_e,dx_e,dz_e\n";

std::string row(const char *panel, const char *kind, double x, double z, double dx = 0, double dz = 0)
{
    return fmt::format("{},{},{:.5g},{:.5g},{:.5g},{:.5g}\n", panel, kind, x, z, dx, dz);
}

/// The row of surface cells, and the ball that stands over x = at.
std::string scene(const char *panel, double from, double to, double at, bool with_ball)
{
    std::string out;
    for (double x = std::floor(from) + 0.5; x < to; ++x) out += row(panel, "cell", x, 0.5);
    if (!with_ball) return out;
    const double up = drawn_top_e - drawn_depth_e + drawn_radius_e;
    double before[2] = {0, 0};
    for (int n = 0; n <= 90; ++n) {
        const double turn = std::numbers::pi * (1 + n / 90.0);
        const double now[2] = {at + drawn_radius_e * std::cos(turn), up + drawn_radius_e * std::sin(turn)};
        if (n) out += row(panel, "ball", before[0], before[1], now[0] - before[0], now[1] - before[1]);
        before[0] = now[0];
        before[1] = now[1];
    }
    return out;
}

std::string points(const char *panel, const std::vector<DrawnPoint> &all)
{
    std::string out;
    for (const DrawnPoint &p : all) {
        const bool pushes = p.force_x != 0 || p.force_z != 0;
        out += row(panel, pushes ? "pushing" : p.collides ? "colliding" : "free", p.x, p.z);
        if (pushes) out += row(panel, "force", p.x, p.z, arrow * p.force_x, arrow * p.force_z);
    }
    return out;
}

/// What a panel shows, in its colour.
std::string plot(const std::string &panel, const char *colour, double tip = 0.22)
{
    const auto of = [&](const char *kind) {
        return fmt::format("$data using (strcol(1) eq '{}' && strcol(2) eq '{}' ? $3 : NaN):4", panel, kind);
    };
    return fmt::format(
        "plot {}:(0.5):(0.5) with boxxyerror fs solid 1 border lc rgb '#b0b0b0' fc rgb '#e8e8e8' notitle, "
        "{}:5:6 with vectors nohead dt 2 lw 0.8 lc rgb '#909090' notitle, {}:5:6 with vectors nohead lw 1.5 "
        "lc rgb '{}' notitle, {} with points pt 6 ps 0.8 lw 1.2 lc rgb '{}' notitle, {} with points pt 7 ps "
        "0.8 lc rgb '{}' notitle, {} with points pt 7 ps 0.8 lc rgb '{}' notitle, {}:5:6 with vectors head "
        "filled size {},20 lw 2 lc rgb '{}' notitle\n{}",
        of("cell"), of("raster"), of("ball"), palette::black, of("free"), palette::grey, of("colliding"),
        palette::grey, of("pushing"), colour, of("force"), tip, colour, gnuplot_said_once);
}

StudyFigure figure2(const PointRuns &runs)
{
    StudyFigure figure{"fig2",
                       "Figure 2: the same collision with the original and with the exact shell",
                       fmt::format("A slice of one cell through a ball of {:g} e that is {:g} e deep in a "
                                   "plane, law original. Grey squares: surface cells of the plane; dashed: "
                                   "those of the ball, in its own turned raster; full dots collide, "
                                   "coloured ones push. An arrow of {:g} e is a force of k e.",
                                   drawn_radius_e, drawn_depth_e, arrow),
                       head,
                       "",
                       900,
                       620};
    for (std::size_t n = 0; n < runs.slices.size(); ++n) {
        const char *panel = n ? "b" : "a";
        figure.csv += scene(panel, -6, 6, 0, true);
        const double c = 0.5 * std::cos(drawn_turn), s = 0.5 * std::sin(drawn_turn);
        for (const auto &[x, z] : runs.slices[n].raster) {
            const double corner[4][2] = {{x - c - s, z + s - c},
                                         {x + c - s, z - s - c},
                                         {x + c + s, z - s + c},
                                         {x - c + s, z + s + c}};
            for (int i = 0; i < 4; ++i) {
                const double *a = corner[i], *b = corner[(i + 1) % 4];
                figure.csv += row(panel, "raster", a[0], a[1], b[0] - a[0], b[1] - a[1]);
            }
        }
        figure.csv += points(panel, runs.slices[n].points);
    }
    figure.script = gnuplot_panels(figure.height, 2, 1) +
                    "unset grid\nset xrange [-6.6:6.6]\nset yrange [-0.4:3.2]\nset size ratio -1\nset xtics "
                    "1\nset ytics 1\nset ylabel 'height [e]'\n";
    figure.script += "set title 'a  original shell: middles of cells'\n" + plot("a", palette::vermilion);
    figure.script += "set title 'b  exact shell: points on the surface'\nset xlabel 'x [e]'\n" +
                     plot("b", palette::blue) + "unset multiplot\n";
    return figure;
}

StudyFigure figure5(const PointRuns &runs)
{
    StudyFigure figure{
        "fig5",
        "Figure 5: a point that crosses the borders of cells while the ball slides",
        fmt::format(
            "a: the ball slides to the right; b and c: one of its points on its way, every eighth of "
            "e, with its force by the original law and by the average. Where it enters the next cell, "
            "the depth across its own aslant normal starts anew; across the mean normal of all "
            "colliding points it hardly changes. An arrow of {:g} e is a force of k e.",
            arrow),
        head,
        "",
        900,
        620};
    const auto &first = runs.crossing.original.front(), &last = runs.crossing.original.back();
    figure.csv += scene("a", -6, 8, 0, true) + points("a", runs.slices.back().points) +
                  row("a", "way", first.x, first.z, last.x - first.x, 0);
    const double from = std::floor(first.x), to = std::ceil(last.x);
    for (const char *panel : {"b", "c"}) {
        figure.csv += scene(panel, from, to, 0, false) +
                      points(panel, panel[0] == 'b' ? runs.crossing.original : runs.crossing.average);
    }
    const auto place = [](double left, double right, double bottom, double top) {
        return fmt::format(
            "set lmargin at screen {}\nset rmargin at screen {}\nset bmargin at screen {}\nset "
            "tmargin at screen {}\n",
            left, right, bottom, top);
    };
    figure.script = "set multiplot\n" + place(0.095, 0.975, 0.57, 0.94) +
                    "unset grid\nset size ratio -1\nset xtics 1\nset ytics 1\nset xrange [-6.6:8.6]\nset "
                    "yrange [-0.4:3.2]\nset ylabel 'height [e]'\nset title 'a  sliding'\n";
    std::string whole = plot("a", palette::vermilion);
    whole.insert(whole.find('\n'),
                 fmt::format(", $data using (strcol(2) eq 'way' ? $3 : NaN):4:5:6 with vectors head filled "
                             "size 0.3,20 lw 2.5 lc rgb '{}' notitle",
                             palette::black));
    figure.script += whole;
    figure.script += place(0.095, 0.5, 0.14, 0.45) +
                     fmt::format("set xrange [{}:{}]\nset yrange [-0.1:1.6]\nset xlabel 'x [e]'\nset title "
                                 "'b  original: its own normal'\n",
                                 from - 0.1, to + 0.1);
    figure.script += plot("b", palette::vermilion, 0.1) + place(0.57, 0.975, 0.14, 0.45) +
                     "set ylabel ''\nset title 'c  average: the mean normal'\n" +
                     plot("c", palette::blue, 0.1) + "unset multiplot\n";
    return figure;
}

} // namespace

std::vector<StudyFigure> point_figures(const PointRuns &runs)
{
    return {figure2(runs), figure5(runs)};
}

} // namespace voxshell
