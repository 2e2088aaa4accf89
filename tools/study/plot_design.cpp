// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/plot_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace voxshell {
namespace {

constexpr double pi = std::numbers::pi;

/// Told apart by people who see few colours, and by their dashes in grey (Okabe and Ito 2008).
struct Line {
    const char *colour, *dash;
};
constexpr Line lines[] = {{"#d55e00", "1"}, {"#009e73", "'-'"}, {"#0072b2", "'_'"}, {"#000000", "'.-'"}};

struct Curve {
    std::string arm;
    std::vector<std::complex<double>> gain, impedance;
    std::vector<double> phase_deg,
        damping; ///< phase without jumps; real part that Colgate's condition asks about
};

struct Curves {
    std::vector<double> hz;
    std::vector<Curve> arms;
};

Curves curves_of(const Design &design)
{
    Curves out;
    const double t = design.input.device.sample_time;
    constexpr int points = 1200;
    for (int n = 0; n <= points; ++n) {
        out.hz.push_back(0.05 * std::pow(0.5 / t / 0.05, static_cast<double>(n) / points));
    }
    vxs_simulated_config device = design.input.device;
    for (const ArmDesign &arm : design.arms) {
        device.arm = *vxs_simulated_arm_named(arm.arm.c_str());
        const Loop loop(device, design.coupling);
        Curve curve{arm.arm, {}, {}, {}, {}};
        for (const double hz : out.hz) {
            const double angle = std::min(2 * pi * hz * t, pi);
            const std::complex<double> gain = design.seen * loop.gain(angle);
            double phase = std::arg(gain) * 180 / pi;
            if (!curve.phase_deg.empty()) {
                phase -= 360 * std::round((phase - curve.phase_deg.back()) / 360);
            }
            curve.gain.push_back(gain);
            curve.phase_deg.push_back(phase);
            curve.impedance.push_back(loop.impedance(angle, design.seen));
            curve.damping.push_back(loop.viscosity() - design.seen * loop.damping_needed(angle));
        }
        out.arms.push_back(std::move(curve));
    }
    return out;
}

/// hz, then the columns of each arm.
template<class F>
std::string table(const Curves &curves, const std::vector<std::string> &columns, F numbers)
{
    std::string text = "hz";
    for (const Curve &curve : curves.arms) {
        for (const std::string &column : columns) {
            text += ',';
            text += fmt::format(fmt::runtime(column), curve.arm);
        }
    }
    text += "\n";
    for (std::size_t n = 0; n < curves.hz.size(); ++n) {
        text += fmt::format("{}", curves.hz[n]);
        for (const Curve &curve : curves.arms) {
            for (const double number : numbers(curve, n)) {
                text += fmt::format(",{}", number);
            }
        }
        text += "\n";
    }
    return text;
}

/// "plot" of one column of each arm, the first at `first`, `step` apart; x: a column or an expression.
std::string plot(const std::string &data, const Design &design, const std::string &x, int first, int step,
                 bool with_key)
{
    std::string text = "plot ";
    for (std::size_t n = 0; n < design.arms.size(); ++n) {
        const std::string at = fmt::format(fmt::runtime(x), first + step * static_cast<int>(n) - 1);
        text +=
            fmt::format("{}{} using {}:{} with lines lw {} lc rgb '{}' dt {} {}", n ? ", " : "", data, at,
                        first + step * static_cast<int>(n), n == 0 ? 2.2 : 2, lines[n].colour, lines[n].dash,
                        with_key ? fmt::format("title '{}'", design.arms[n].arm) : "notitle");
    }
    return text + "\n";
}

std::string title_of(const Design &design)
{
    const double t = design.input.device.sample_time;
    std::string coupling = "no filter";
    if (design.coupling.kind == VXS_COUPLING_PT2) {
        coupling = fmt::format("PT2 {:.4g} Hz, d {:.3g}", design.coupling.omega0 / (2 * pi),
                               design.coupling.damping);
    } else if (design.coupling.kind == VXS_COUPLING_QUASI_STATIC) {
        coupling = fmt::format("spring {:.4g} N/m", design.coupling.stiffness);
    }
    return fmt::format("{}, {:.4g} Hz, {:.4g} N/m, {}", design.input.device.profile.name, 1 / t, design.seen,
                       coupling);
}

std::string head(const Design &design, const std::string &csv, const std::string &command)
{
    return fmt::format("$data << END\n{}END\nset datafile separator ','\n", csv.substr(csv.find('\n') + 1)) +
           fmt::format("set label 100 {} at screen 0.012, screen 0.018 left font ',13' textcolor rgb "
                       "'#505050' noenhanced\n",
                       gnuplot_text(command)) +
           fmt::format("title = {}\n", gnuplot_text(title_of(design)));
}

} // namespace

std::vector<std::uint8_t> DesignPlot::draw(Picture picture) const
{
    return gnuplot(gnuplot_sheet(picture, width, height) + script);
}

std::vector<DesignPlot> plot_design(const Design &design, const std::string &command)
{
    using Numbers = std::vector<double>;
    const Curves curves = curves_of(design);
    const double end = curves.hz.back();
    std::vector<DesignPlot> plots;

    const std::string bode = table(curves, {"gain_{}_db", "phase_{}_deg"}, [](const Curve &c, std::size_t n) {
        return Numbers{20 * std::log10(std::abs(c.gain[n])), c.phase_deg[n]};
    });
    plots.push_back(
        {"bode", bode,
         head(design, bode, command) +
             fmt::format("set xrange [0.05:{}]\nset logscale x\nset format x '%g'\n", end) +
             "set multiplot\nset lmargin at screen 0.12\nset rmargin at screen 0.97\n"
             "set tmargin at screen 0.92\nset bmargin at screen 0.55\n"
             "set title title noenhanced\nset ylabel 'loop gain [dB]'\nset format x ''\n"
             "set yrange [-80:80]\nset ytics 40\nset key top right horizontal\n"
             "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead lc rgb '#606060' lw 1.2\n" +
             plot("$data", design, "1", 2, 2, true) +
             "unset label 100\nunset title\nunset key\nset tmargin at screen 0.51\nset bmargin at screen "
             "0.14\n"
             "set format x '%g'\nset xlabel 'frequency [Hz]'\nset ylabel 'phase [deg]'\nset yrange "
             "[-540:0]\nset ytics 180\n"
             "set arrow 1 from graph 0, first -180 to graph 1, first -180 nohead lc rgb '#606060' lw 1.2\n" +
             plot("$data", design, "1", 3, 2, false) + "unset multiplot\n",
         900, 700});

    const std::string nyquist = table(curves, {"real_{}", "imaginary_{}"}, [](const Curve &c, std::size_t n) {
        return Numbers{c.gain[n].real(), c.gain[n].imag()};
    });
    plots.push_back(
        {"nyquist", nyquist,
         head(design, nyquist, command) +
             "set title title noenhanced\nset size ratio -1\nset bmargin at screen 0.14\n"
             "set xrange [-3:1.5]\nset yrange [-2:2]\nset xlabel 'loop gain, real part [1]'\n"
             "set ylabel 'imaginary part [1]'\nset key top right opaque box lc rgb '#d8d8d8' width 1\n"
             "set object 1 circle at 0, 0 size 1 fc rgb '#a0a0a0' lw 1 dt 3\n"
             "set label 1 '-1' at -1, 0 point pt 7 ps 1.2 lc rgb '#cc0000' offset 0.6, 0.7\n" +
             plot("$data", design, "{}", 3, 2, true),
         900, 780});

    const std::string impedance =
        table(curves, {"size_{}_ns_per_m", "damping_{}_ns_per_m"}, [](const Curve &c, std::size_t n) {
            return Numbers{std::abs(c.impedance[n]), c.damping[n]};
        });
    double deepest = 0, highest = 1e-3, largest = 0;
    for (const Curve &c : curves.arms) {
        for (const auto &z : c.impedance) {
            largest = std::max(largest, std::abs(z));
        }
        deepest = std::min(deepest, *std::min_element(c.damping.begin(), c.damping.end()));
        highest = std::max(highest, *std::max_element(c.damping.begin(), c.damping.end()));
    }
    plots.push_back(
        {"impedance", impedance,
         head(design, impedance, command) + fmt::format("set xrange [0.05:{}]\nset logscale x\n", end) +
             "set multiplot\nset lmargin at screen 0.13\nset rmargin at screen 0.97\n"
             "set tmargin at screen 0.92\nset bmargin at screen 0.55\n"
             "set title title noenhanced\nset ylabel '|Z| [N s/m]'\nset format x ''\nset logscale y\nset "
             "format y '10^{%L}'\n" +
             fmt::format("set key top right horizontal\nset yrange [*:{}]\n", 30 * largest) +
             plot("$data", design, "1", 2, 2, true) +
             "unset label 100\nunset title\nunset key\nset tmargin at screen 0.51\nset bmargin at screen "
             "0.14\nunset logscale y\n"
             "set format x '%g'\nset format y '%g'\nset xlabel 'frequency [Hz]'\nset ylabel 'Re Z: below 0 "
             "it drives [N s/m]'\n" +
             fmt::format("set yrange [{}:{}]\n", 1.1 * deepest, 1.1 * highest) +
             "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead lc rgb '#606060' lw 1.2\n" +
             plot("$data", design, "1", 3, 2, false) + "unset multiplot\n",
         900, 700});
    return plots;
}

} // namespace voxshell
