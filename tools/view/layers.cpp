// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/layers.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace voxshell {
namespace {

using json = nlohmann::ordered_json;

std::uint8_t byte_of(double value)
{
    return static_cast<std::uint8_t>(static_cast<int>(std::lround(std::clamp(value, -127.0, 127.0))));
}

/// Each but the first of a row of eight as its difference from the one before.
void put_rows(std::vector<std::uint8_t> &out, const std::array<std::uint8_t, 512> &cells)
{
    for (std::size_t n = 0; n < cells.size(); ++n)
        out.push_back(static_cast<std::uint8_t>(cells[n] - (n % 8 ? cells[n - 1] : 0)));
}

void channel_layers(const Channels &channels, PageData &data, json &layer)
{
    std::vector<std::uint8_t> out;
    std::array<std::uint8_t, 512> cells;
    if (channels.layer_count > 0) {
        for (const auto &brick : channels.layer) {
            std::ranges::transform(brick, cells.begin(), byte_of);
            put_rows(out, cells);
        }
        layer["layers"] = channels.layer_count;
        layer["layer"] = data.bytes(out);
    }
    if (channels.distance_band > 0) {
        out.clear();
        const double scale = 127 * channels.distance_step / channels.distance_band;
        for (const auto &brick : channels.distance) {
            std::ranges::transform(brick, cells.begin(), [&](std::int16_t d) { return byte_of(scale * d); });
            put_rows(out, cells);
        }
        layer["band"] = channels.distance_band;
        layer["distance"] = data.bytes(out);
    }
}

/// A unit vector on an octahedron, folded into a square: two bytes.
std::array<std::uint8_t, 2> octahedral(const std::array<float, 3> &v)
{
    const double sum = std::abs(double{v[0]}) + std::abs(double{v[1]}) + std::abs(double{v[2]});
    if (!(sum > 0)) return {0, 0};
    double x = v[0] / sum, y = v[1] / sum;
    if (v[2] < 0) {
        const double folded = (1 - std::abs(y)) * (x < 0 ? -1 : 1);
        y = (1 - std::abs(x)) * (y < 0 ? -1 : 1);
        x = folded;
    }
    return {byte_of(127 * x), byte_of(127 * y)};
}

/// Positions in whole steps from a base.
struct Rounded {
    Point base{};
    double step = 1;
    std::array<std::int32_t, 3> of(const Point &p) const
    {
        std::array<std::int32_t, 3> out;
        for (std::size_t axis = 0; axis < 3; ++axis)
            out[axis] =
                static_cast<std::int32_t>(std::clamp((p[axis] - base[axis]) / step, 0.0, 2147483647.0) + 0.5);
        return out;
    }
};

struct Box {
    Point low{}, high{};
    bool empty = true;
    void take(const Point &p)
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = empty ? p[axis] : std::min(low[axis], p[axis]);
            high[axis] = empty ? p[axis] : std::max(high[axis], p[axis]);
        }
        empty = false;
    }
    double longest() const { return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}); }
};

Point point_of(const std::array<float, 3> &p)
{
    return {p[0], p[1], p[2]};
}

} // namespace

json cells_layer(const VoxmapFile &file, PageData &data)
{
    const Cells &cells = file.cells;
    std::vector<std::int32_t> at, solid;
    std::vector<std::uint8_t> surface, interior;
    const auto put_bits = [](std::vector<std::uint8_t> &out, const std::array<std::uint64_t, 8> &words) {
        for (const std::uint64_t word : words)
            for (int n = 0; n < 64; n += 8) out.push_back(static_cast<std::uint8_t>(word >> n));
    };
    for (const Brick &brick : cells.bricks) {
        at.insert(at.end(), brick.at.begin(), brick.at.end());
        put_bits(surface, brick.surface);
        put_bits(interior, brick.interior);
    }
    for (const SolidRun &run : cells.solid) solid.insert(solid.end(), {run.i, run.j, run.first, run.last});
    json layer = {{"voxel", cells.voxel},
                  {"origin", cells.origin},
                  {"min", cells.min},
                  {"max", cells.max},
                  {"closed", cells.closed},
                  {"surface_cells", cells.surface_cells},
                  {"bricks", cells.bricks.size()},
                  {"at", data.ints(at, 3)},
                  {"surface", data.bytes(surface)},
                  {"interior", data.bytes(interior)},
                  {"solid", data.ints(solid, 4)}};
    channel_layers(file.channels, data, layer);
    return layer;
}

json points_layer(const PointshellFile &file, PageData &data)
{
    const Shell &shell = file.shell;
    Box box;
    for (const ShellPoint &point : shell.points) box.take(point_of(point.position));
    const Rounded rounded{box.low, std::max(shell.voxel / 64, box.longest() / 2e9)};
    std::vector<std::int32_t> at, counts;
    std::vector<std::uint8_t> normal;
    std::array<std::uint8_t, 2> last{};
    for (const ShellPoint &point : shell.points) {
        const auto whole = rounded.of(point_of(point.position));
        at.insert(at.end(), whole.begin(), whole.end());
        const auto folded = octahedral(point.normal);
        for (std::size_t n = 0; n < 2; ++n) normal.push_back(static_cast<std::uint8_t>(folded[n] - last[n]));
        last = folded;
    }
    std::vector<float> spheres;
    for (const Cluster &cluster : shell.clusters) {
        counts.push_back(static_cast<std::int32_t>(cluster.count));
        spheres.insert(spheres.end(), cluster.center.begin(), cluster.center.end());
        spheres.push_back(cluster.radius);
    }
    return {{"voxel", shell.voxel},           {"step", rounded.step},
            {"base", rounded.base},           {"at", data.ints(at, 3)},
            {"normal", data.bytes(normal)},   {"counts", data.ints(counts, 1)},
            {"spheres", data.floats(spheres)}};
}

json mesh_layer(const Mesh &mesh, PageData &data)
{
    Box box;
    for (const Triangle &triangle : mesh.triangles)
        for (const std::uint32_t v : triangle) box.take(mesh.vertices[v]);
    const Rounded rounded{box.low, box.longest() > 0 ? box.longest() / 65535 : 1};
    std::vector<std::int32_t> at, triangles;
    std::unordered_map<std::uint64_t, std::int32_t> known;
    for (const Triangle &triangle : mesh.triangles) {
        std::array<std::int32_t, 3> corner;
        for (std::size_t n = 0; n < 3; ++n) {
            const auto whole = rounded.of(mesh.vertices[triangle[n]]);
            const auto key = static_cast<std::uint64_t>(whole[0]) << 40 |
                             static_cast<std::uint64_t>(whole[1]) << 20 |
                             static_cast<std::uint64_t>(whole[2]);
            const auto [found, is_new] = known.try_emplace(key, static_cast<std::int32_t>(known.size()));
            if (is_new) at.insert(at.end(), whole.begin(), whole.end());
            corner[n] = found->second;
        }
        if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
        triangles.insert(triangles.end(), corner.begin(), corner.end());
    }
    return {{"step", rounded.step},
            {"base", rounded.base},
            {"at", data.ints(at, 3)},
            {"triangles", data.ints(triangles, 3)}};
}

json track_layer(std::span<const Pose> poses, PageData &data)
{
    std::vector<float> columns(7 * poses.size());
    for (std::size_t n = 0; n < poses.size(); ++n) {
        for (std::size_t axis = 0; axis < 3; ++axis)
            columns[axis * poses.size() + n] = static_cast<float>(poses[n].position[axis]);
        for (std::size_t axis = 0; axis < 4; ++axis)
            columns[(3 + axis) * poses.size() + n] = static_cast<float>(poses[n].rotation[axis]);
    }
    return data.floats(columns);
}

json recorded_layer(const Recorded &recorded, PageData &data)
{
    std::vector<float> columns;
    std::vector<Pose> body;
    const auto put = [&](auto value) {
        for (const Moment &moment : recorded.rows) columns.push_back(static_cast<float>(value(moment)));
    };
    put([](const Moment &m) { return m.t; });
    for (const auto member : {&Moment::device, &Moment::hand, &Moment::collision_force,
                              &Moment::collision_torque, &Moment::output_force}) {
        for (std::size_t axis = 0; axis < 3; ++axis) put([&](const Moment &m) { return (m.*member)[axis]; });
    }
    put([](const Moment &m) { return m.contacts; });
    for (const Moment &moment : recorded.rows) body.push_back(moment.body);
    return {
        {"source", recorded.source}, {"rows", recorded.rows.size()},    {"of", recorded.of},
        {"forces", recorded.forces}, {"columns", data.floats(columns)}, {"body", track_layer(body, data)}};
}

} // namespace voxshell
