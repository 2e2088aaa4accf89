// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/paper_points.hpp"

#include "plan/memory.hpp"
#include "study/bodies.hpp"
#include "study/open_part.hpp"
#include "study/paper_scenarios.hpp"

#include "voxshell/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxshell {
namespace {

constexpr double e = 1e-3; ///< [m]
constexpr double way_e = 2.5, step_e = 0.125;
constexpr double followed_slope = 0.3; ///< of the point of figure 5 to the plane's normal [rad]

vxs_pose pose_at(double x_e)
{
    vxs_pose pose = vxs_pose_identity();
    pose.position[0] = x_e * e;
    pose.position[2] = (drawn_top_e - drawn_depth_e + drawn_radius_e) * e;
    pose.orientation[0] = std::cos(drawn_turn / 2);
    pose.orientation[2] = std::sin(drawn_turn / 2);
    return pose;
}

Point turned(const double m[9], double x, double y, double z)
{
    return {m[0] * x + m[1] * y + m[2] * z, m[3] * x + m[4] * y + m[5] * z, m[6] * x + m[7] * y + m[8] * z};
}

struct Placed {
    Point at, normal; ///< scene [m]
    bool collides;
    Point centre; ///< of its cell [m]
};

Placed placed(const vxs_pointshell &shell, std::uint32_t n, const vxs_pose &pose, const vxs_voxmap &map)
{
    double m[9];
    vxs_pose_rotation(&pose, m);
    Placed p{turned(m, shell.x[n], shell.y[n], shell.z[n]),
             turned(m, shell.nx[n], shell.ny[n], shell.nz[n]),
             false,
             {}};
    for (std::size_t i = 0; i < 3; ++i) p.at[i] += pose.position[i];
    std::int64_t cell[3];
    p.collides = vxs_voxmap_cell_of(&map, p.at.data(), cell) &&
                 vxs_voxmap_state_at(&map, cell[0], cell[1], cell[2]) == VXS_CELL_SURFACE;
    for (std::size_t i = 0; i < 3; ++i) p.centre[i] = e * (static_cast<double>(cell[i]) + 0.5);
    return p;
}

/// METHOD section 3: the plane through the cell's centre across `normal` [e].
double depth_of(const Placed &p, const Point &normal)
{
    double depth = 0;
    for (std::size_t i = 0; i < 3; ++i) depth += (p.centre[i] - p.at[i]) * normal[i] / e;
    return p.collides ? std::max(0.0, depth) : 0;
}

vxs_contact_result evaluate(const OpenPart &stands, const OpenPart &moves, const vxs_pose &pose,
                            std::uint32_t law)
{
    vxs_contact_config config;
    vxs_contact_config_default(&config);
    config.law = law;
    config.stiffness = 1 / e;
    const Memory room(vxs_contact_memory(&moves.shell, 1));
    vxs_contact *contact = nullptr;
    if (vxs_contact_init(room.get(), room.size(), &moves.shell, 1, &contact) != VXS_OK)
        throw Failure(ExitCode::bug, "figure 2", "no contact");
    const vxs_contact_static statics{&stands.map, nullptr};
    vxs_contact_result result;
    vxs_contact_evaluate(contact, &statics, 1, &pose, &config, &result);
    return result;
}

SliceRun slice(ShellKind kind, const OpenPart &stands, const OpenPart &moves, const OpenPart &raster)
{
    SliceRun run{kind, {}, {}, 0, 0, 0, 0};
    const vxs_pose pose = pose_at(0);
    Point sum{};
    for (std::uint32_t n = 0; n < moves.shell.point_count; ++n) {
        const Placed p = placed(moves.shell, n, pose, stands.map);
        const double depth = depth_of(p, p.normal);
        for (std::size_t i = 0; i < 3; ++i) sum[i] += depth * p.normal[i];
        run.pushing += depth > 0;
        if (moves.shell.y[n] < 0 || moves.shell.y[n] >= static_cast<float>(e)) continue;
        run.points.push_back(
            {p.at[0] / e, p.at[2] / e, depth * p.normal[0], depth * p.normal[2], p.collides});
    }
    for (std::uint32_t n = 0; n < raster.shell.point_count; ++n) {
        if (raster.shell.y[n] < 0 || raster.shell.y[n] >= static_cast<float>(e)) continue;
        const Placed p = placed(raster.shell, n, pose, stands.map);
        run.raster.push_back({p.at[0] / e, p.at[2] / e});
    }
    const vxs_contact_result result = evaluate(stands, moves, pose, VXS_CONTACT_ORIGINAL);
    const double *f = result.wrench.force;
    run.size = std::hypot(f[0], f[1], f[2]);
    run.across = std::hypot(f[0], f[1]);
    run.off = run.size > 0 ? std::hypot(sum[0] - f[0], sum[1] - f[1], sum[2] - f[2]) / run.size
                           : std::numeric_limits<double>::quiet_NaN();
    return run;
}

CrossingRun cross(const OpenPart &stands, const OpenPart &moves)
{
    // The point of the slice whose normal is nearest to the slope asked for, on the side it moves to.
    const vxs_pose start = pose_at(0);
    std::uint32_t followed = 0;
    double nearest = std::numeric_limits<double>::infinity();
    for (std::uint32_t n = 0; n < moves.shell.point_count; ++n) {
        if (moves.shell.y[n] < 0 || moves.shell.y[n] >= static_cast<float>(e)) continue;
        const Placed p = placed(moves.shell, n, start, stands.map);
        const double off =
            std::abs(std::atan2(p.normal[0], p.normal[2]) + followed_slope) + std::abs(p.normal[1]);
        if (off < nearest) {
            nearest = off;
            followed = n;
        }
    }
    CrossingRun run;
    for (int n = 0; n <= static_cast<int>(way_e / step_e); ++n) {
        const vxs_pose pose = pose_at(n * step_e);
        const Placed p = placed(moves.shell, followed, pose, stands.map);
        const vxs_contact_result result = evaluate(stands, moves, pose, VXS_CONTACT_AVERAGE);
        const Point mean{result.normal[0], result.normal[1], result.normal[2]};
        const double own = depth_of(p, p.normal), shared = depth_of(p, mean);
        run.original.push_back({p.at[0] / e, p.at[2] / e, own * p.normal[0], own * p.normal[2], p.collides});
        run.average.push_back({p.at[0] / e, p.at[2] / e, shared * mean[0], shared * mean[2], p.collides});
    }
    return run;
}

} // namespace

PointRuns run_points(Progress &progress)
{
    const auto part = [&](const char *name, const Mesh &mesh, ShellKind shell, bool stands) {
        PartOptions options;
        options.voxel = e;
        options.shell = shell;
        options.stands = stands;
        return OpenPart(name, mesh, options, progress);
    };
    const OpenPart plane =
        part("plane of figure 2", slab(15 * e, drawn_top_e * e, 5 * e), ShellKind::exact, true);
    const Mesh mesh = ball(drawn_radius_e * e);
    const OpenPart naive = part("ball of figure 2", mesh, ShellKind::naive, false),
                   exact = part("ball of figure 2", mesh, ShellKind::exact, false);
    return {{slice(ShellKind::naive, plane, naive, naive), slice(ShellKind::exact, plane, exact, naive)},
            cross(plane, exact)};
}

StudyTable point_table(const PointRuns &runs)
{
    StudyTable table{"fig2_sums",
                     "Figure 2, all points together",
                     "Law original. Single forces follow from the definition of the law; off: their sum off "
                     "the force that the runtime gives.",
                     {{"shell", "shell"},
                      {"slice_points", "points in the slice"},
                      {"slice_pushing", "that push"},
                      {"pushing", "pushing, in all"},
                      {"force_ke", "force [k e]"},
                      {"across_ke", "of it across the normal [k e]"},
                      {"off_pct", "off [%]"}},
                     {},
                     "fig2"};
    for (const SliceRun &run : runs.slices) {
        const auto pushing = std::count_if(run.points.begin(), run.points.end(), [](const DrawnPoint &p) {
            return p.force_x != 0 || p.force_z != 0;
        });
        table.rows.push_back({shell_name(run.shell), static_cast<double>(run.points.size()),
                              static_cast<double>(pushing), run.pushing, run.size, run.across,
                              100 * run.off});
    }
    return table;
}

} // namespace voxshell
