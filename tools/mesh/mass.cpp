// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mass.hpp"

#include "cli/failure.hpp"
#include "mesh/report.hpp"
#include "mesh/sum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

std::string named(const Mesh &mesh)
{
    return mesh.name.empty() ? "the mesh" : fmt::format("mesh \"{}\"", mesh.name);
}

void refuse_unless_solid(const Mesh &mesh)
{
    const MeshReport r = report(mesh);
    if (r.triangles == 0)
        throw Failure(ExitCode::requirement, "", named(mesh) + " has no triangles: nothing to weigh");
    if (!r.closed) {
        throw Failure(ExitCode::requirement, "",
                      fmt::format("{} has {} open edges, and what is open has no volume: close it, or say "
                                  "mass, com and inertia",
                                  named(mesh), r.boundary_edges));
    }
    if (!r.oriented) {
        throw Failure(
            ExitCode::requirement, "",
            fmt::format(
                "{} has {} edges where triangles face opposite ways: orient it, or say mass, com and inertia",
                named(mesh), std::max<std::uint64_t>(r.badly_wound_edges, 1)));
    }
}

Point middle_of(const Mesh &mesh)
{
    Point low = mesh.vertices[mesh.triangles[0][0]], high = low;
    for (const Triangle &t : mesh.triangles)
        for (const std::uint32_t v : t)
            for (std::size_t i = 0; i < 3; ++i) {
                low[i] = std::min(low[i], mesh.vertices[v][i]);
                high[i] = std::max(high[i], mesh.vertices[v][i]);
            }
    return {low[0] + (high[0] - low[0]) / 2, low[1] + (high[1] - low[1]) / 2,
            low[2] + (high[2] - low[2]) / 2};
}

constexpr std::size_t pairs[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}};

} // namespace

MassProperties mass_properties(const Mesh &mesh, double density)
{
    if (!(density > 0 && std::isfinite(density))) {
        throw Failure(ExitCode::invalid, "",
                      fmt::format("a density of {:g} kg/m^3: must be more than 0", density));
    }
    refuse_unless_solid(mesh);
    const Point middle = middle_of(mesh);
    Sum volume, first[3], second[6];
    for (const Triangle &t : mesh.triangles) {
        Point p[3];
        for (std::size_t corner = 0; corner < 3; ++corner)
            for (std::size_t i = 0; i < 3; ++i) p[corner][i] = mesh.vertices[t[corner]][i] - middle[i];
        const auto &[a, b, c] = p;
        const double v = (a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
                          a[2] * (b[0] * c[1] - b[1] * c[0])) /
                         6;
        const Point sum{a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]};
        volume.add(v);
        for (std::size_t i = 0; i < 3; ++i) first[i].add(v / 4 * sum[i]);
        for (std::size_t n = 0; n < 6; ++n) {
            const std::size_t i = pairs[n][0], j = pairs[n][1];
            second[n].add(v / 20 * (((a[i] * a[j] + b[i] * b[j]) + c[i] * c[j]) + sum[i] * sum[j]));
        }
    }
    const double sign = volume.value() < 0 ? -1 : 1, whole = sign * volume.value();
    Point com = middle, arm{};
    double cross[6];
    for (std::size_t i = 0; i < 3; ++i) {
        arm[i] = sign * first[i].value() / whole;
        com[i] += arm[i];
    }
    double spread = 0;
    for (std::size_t n = 0; n < 6; ++n) {
        const std::size_t i = pairs[n][0], j = pairs[n][1];
        cross[n] = density * (sign * second[n].value() - whole * (arm[i] * arm[j]));
        if (i == j) spread += cross[n];
    }
    MassProperties result{whole, density * whole, com, {}};
    for (std::size_t n = 0; n < 6; ++n) result.inertia[n] = n < 3 ? spread - cross[n] : -cross[n];
    const bool is_finite =
        std::isfinite(result.mass) && std::all_of(result.inertia.begin(), result.inertia.end(),
                                                  [](double value) { return std::isfinite(value); });
    if (!is_finite || !(whole > 0) || !(cross[0] > 0 && cross[1] > 0 && cross[2] > 0)) {
        throw Failure(ExitCode::requirement, "",
                      named(mesh) + " encloses no volume that weighs: say mass, com and inertia");
    }
    return result;
}

} // namespace voxshell
