// SPDX-License-Identifier: GPL-3.0-or-later
// How a tick's time goes with the points of what moves, and with the size of what stands.
#include "study/accuracy_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace voxshell {
namespace {

constexpr double points_to_cell_faces = 1.5; ///< points a shell has for each h^2 of its surface, about
constexpr double quick_points[] = {1e3, 2e3, 4e3, 8e3, 1.6e4, 3.2e4},
                 full_points[] = {1e3, 3e3, 1e4, 3e4, 1e5, 3e5, 1e6};

struct Box {
    Point low, high;
};

Box box_of(const Mesh &mesh)
{
    Box box{mesh.vertices[0], mesh.vertices[0]};
    for (const Point &p : mesh.vertices) {
        for (std::size_t i = 0; i < 3; ++i) {
            box.low[i] = std::min(box.low[i], p[i]);
            box.high[i] = std::max(box.high[i], p[i]);
        }
    }
    return box;
}

/// 2, 4 or 8 times what stands, whole cells apart, where what moves never gets.
Mesh copies(const AccuracyScene &scene, const AccuracyPath &path, unsigned count)
{
    Box box = box_of(scene.statics);
    for (const double t : path.times) {
        const Pose pose = scene.hand.at(t);
        for (std::size_t i = 0; i < 3; ++i) {
            box.low[i] = std::min(box.low[i], pose.position[i] - 3 * path.radius);
            box.high[i] = std::max(box.high[i], pose.position[i] + 3 * path.radius);
        }
    }
    Mesh all;
    all.name = scene.statics.name;
    for (unsigned n = 0; n < count; ++n) {
        const auto first = static_cast<std::uint32_t>(all.vertices.size());
        for (const Point &p : scene.statics.vertices) {
            Point moved = p;
            for (std::size_t i = 0; i < 3; ++i) {
                if (n >> i & 1) // a whole number of cells: each copy's cells are as the first one's
                    moved[i] += scene.voxel * (std::ceil((box.high[i] - box.low[i]) / scene.voxel) + 8);
            }
            all.vertices.push_back(moved);
        }
        for (const Triangle &t : scene.statics.triangles)
            all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
    return all;
}

constexpr std::size_t row_numbers = 15;

void append(std::vector<double> &numbers, const ScaleRow &r)
{
    for (const double x : {r.factor, r.points, r.cells, r.map_bytes, r.shell_bytes, r.hits, r.probed, r.error,
                           r.differing, r.mean_ns, r.most_ns, r.ns.p50, r.ns.p99, r.ns.p999, r.ns.max})
        numbers.push_back(x);
}

class Scale {
  public:
    Scale(const AccuracyScene &scene, const AccuracyPath &path, Progress &progress)
        : scene_(scene), path_(path), progress_(progress)
    {
    }
    MadePart map(const Mesh &mesh, double voxel) const
    {
        PartOptions options;
        options.voxel = voxel;
        const double reach = reach_of(scene_.method.field, voxel, path_.deepest);
        if (scene_.method.field == VXS_CONTACT_LAYERS) options.channels.layers = static_cast<int>(reach);
        if (scene_.method.field == VXS_CONTACT_DISTANCE) options.channels.distance_cells = reach;
        return make_part("static", mesh, options, progress_);
    }
    MadePart shell(double spacing) const
    {
        PartOptions options;
        options.voxel = scene_.voxel;
        options.shell = scene_.method.shell;
        options.stands = false;
        if (spacing != scene_.voxel) options.shell_spacing = spacing;
        return make_part("dynamic", scene_.dynamic, options, progress_);
    }
    ScaleRow measured(double factor, const MadePart &stands, const MadePart &moves,
                      std::vector<Wrench> &first) const
    {
        progress_.check();
        const Walk w = walk(scene_, path_, stands.part->map, moves.part->shell, scene_.method, as_is, {});
        AccuracyRow scored{};
        score(w.wrenches, path_, scored);
        ScaleRow row{};
        row.factor = factor;
        row.points = moves.part->shell.point_count;
        row.cells = static_cast<double>(stands.part->map.surface_cells);
        row.map_bytes = static_cast<double>(stands.part->map_file().size);
        row.shell_bytes = static_cast<double>(moves.part->shell_file().size);
        row.hits = w.hits;
        row.probed = w.probed;
        row.error = scored.error;
        if (first.empty()) first = w.wrenches;
        for (std::size_t n = 0; n < first.size(); ++n)
            row.differing += first[n].force != w.wrenches[n].force || first[n].torque != w.wrenches[n].torque;
        std::vector<float> ns = w.ns;
        for (const float x : ns) row.mean_ns += double{x} / static_cast<double>(ns.size());
        row.ns = durations(ns);
        row.most_ns = w.most_ns;
        return row;
    }

  private:
    const AccuracyScene &scene_;
    const AccuracyPath &path_;
    Progress &progress_;
};

std::vector<double> asked_points(bool quick)
{
    return quick ? std::vector<double>(std::begin(quick_points), std::end(quick_points))
                 : std::vector<double>(std::begin(full_points), std::end(full_points));
}

std::vector<double> asked_factors(bool quick)
{
    return quick ? std::vector<double>{1, 2, 4} : std::vector<double>{1, 2, 4, 8};
}

} // namespace

std::size_t scale_rows(bool quick)
{
    return asked_points(quick).size() + 2 * asked_factors(quick).size();
}

std::vector<ScaleRow> run_scale(const AccuracyScene &scene, const AccuracyPath &path, bool quick,
                                FinishedWork &work, Progress &progress)
{
    const Scale scale(scene, path, progress);
    std::vector<ScaleRow> rows;
    const auto add = [&](const std::string &kind, const std::string &name, const auto &measure) {
        const std::vector<double> *done = work.find("scale " + name);
        if (!done) done = &work.add("scale " + name, measure());
        for (const double *v = done->data(); v + row_numbers <= done->data() + done->size();
             v += row_numbers) {
            rows.push_back({kind,
                            v[0],
                            v[1],
                            v[2],
                            v[3],
                            v[4],
                            v[5],
                            v[6],
                            v[7],
                            v[8],
                            v[9],
                            v[10],
                            {v[11], v[12], v[13], v[14]}});
            progress.advance(1);
        }
    };
    const double area = area_of(scene.dynamic);
    MadePart map;
    for (const double points : asked_points(quick)) {
        add("points", fmt::format("points {}", points), [&] {
            if (!map.part) map = scale.map(scene.statics, scene.voxel);
            const MadePart shell = scale.shell(std::sqrt(points_to_cell_faces * area / points));
            std::vector<double> numbers;
            std::vector<Wrench> first;
            append(numbers, scale.measured(points, map, shell, first));
            return numbers;
        });
    }
    for (const bool is_copied : {true, false}) {
        const char *kind = is_copied ? "copies" : "finer";
        add(kind, kind, [&] {
            const MadePart shell = scale.shell(scene.voxel);
            std::vector<double> numbers;
            std::vector<Wrench> first; // of the map as it is: forces in copies are compared with it
            for (const double factor : asked_factors(quick)) {
                const MadePart larger =
                    is_copied ? scale.map(copies(scene, path, static_cast<unsigned>(factor)), scene.voxel)
                              : scale.map(scene.statics, scene.voxel / std::sqrt(factor));
                append(numbers, scale.measured(factor, larger, shell, first));
            }
            return numbers;
        });
    }
    return rows;
}

} // namespace voxshell
