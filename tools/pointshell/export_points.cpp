// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/export_points.hpp"
#include "voxmap/export_glb.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/core.h>

namespace voxshell {
namespace {

std::array<float, 7> row(const ShellPoint &p)
{
    return {p.position[0], p.position[1], p.position[2], p.normal[0], p.normal[1], p.normal[2], p.area};
}

void append(std::string &bytes, const float *values, std::size_t count)
{
    bytes.append(reinterpret_cast<const char *>(values), count * sizeof(float));
}

} // namespace

void points_csv(const Shell &shell, const std::function<void(std::string_view)> &sink)
{
    std::string block = "x,y,z,nx,ny,nz,area\n";
    for (const ShellPoint &point : shell.points) {
        char separator = 0;
        for (const float value : row(point)) {
            char text[32];
            if (separator) block += separator;
            block.append(text, std::to_chars(text, text + sizeof text, value).ptr);
            separator = ',';
        }
        block += '\n';
        if (block.size() < 1 << 20) continue;
        sink(block);
        block.clear();
    }
    sink(block);
}

void points_ply(const Shell &shell, const std::function<void(std::string_view)> &sink)
{
    std::string block = fmt::format("ply\nformat binary_little_endian 1.0\ncomment pointshell, metres and "
                                    "square metres, normals inwards\n"
                                    "element vertex {}\n",
                                    shell.points.size());
    for (const char *name : {"x", "y", "z", "nx", "ny", "nz", "area"})
        block += fmt::format("property float {}\n", name);
    block += "end_header\n";
    for (const ShellPoint &point : shell.points) {
        append(block, row(point).data(), 7);
        if (block.size() < 1 << 20) continue;
        sink(block);
        block.clear();
    }
    sink(block);
}

std::vector<std::uint8_t> points_glb(const Shell &shell)
{
    const std::size_t count = shell.points.size();
    check_glb_size(28 * count);
    std::string binary;
    binary.reserve(28 * count);
    std::array<float, 3> low = shell.points.front().position, high = low;
    for (const ShellPoint &point : shell.points) {
        append(binary, point.position.data(), 3);
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], point.position[a]);
            high[a] = std::max(high[a], point.position[a]);
        }
    }
    for (const ShellPoint &point : shell.points) append(binary, point.normal.data(), 3);
    for (const ShellPoint &point : shell.points) append(binary, &point.area, 1);
    const std::string json = fmt::format(
        R"({{"asset":{{"version":"2.0","generator":"voxshell"}},"scene":0,"scenes":[{{"nodes":[0]}}],)"
        R"("nodes":[{{"name":"pointshell","mesh":0}}],)"
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1,"_AREA":2}},"mode":0}}]}}],)"
        R"("buffers":[{{"byteLength":{}}}],)"
        R"("bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{},"target":34962}},)"
        R"({{"buffer":0,"byteOffset":{},"byteLength":{},"target":34962}},{{"buffer":0,"byteOffset":{},"byteLength":{},"target":34962}}],)"
        R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}},)"
        R"({{"bufferView":1,"componentType":5126,"count":{},"type":"VEC3"}},{{"bufferView":2,"componentType":5126,"count":{},"type":"SCALAR"}}]}})",
        28 * count, 12 * count, 12 * count, 12 * count, 24 * count, 4 * count, count, low[0], low[1], low[2],
        high[0], high[1], high[2], count, count);
    return glb_bytes(json, {reinterpret_cast<const std::uint8_t *>(binary.data()), binary.size()});
}

} // namespace voxshell
