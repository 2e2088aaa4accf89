// SPDX-License-Identifier: GPL-3.0-or-later
#include "pointshell/export_points.hpp"
#include "voxmap/export_glb.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/core.h>

namespace voxshell {
namespace {

constexpr const char *names[] = {"x", "y", "z", "nx", "ny", "nz", "area"};

/// One value for each of the names; the last only where the file has areas.
std::array<float, 7> row(const ShellPoint &p)
{
    return {p.position[0], p.position[1], p.position[2], p.normal[0], p.normal[1], p.normal[2], p.area};
}

std::size_t columns(const PointshellFile &file)
{
    return file.areas ? 7 : 6;
}

void append(std::string &bytes, const float *values, std::size_t count)
{
    bytes.append(reinterpret_cast<const char *>(values), count * sizeof(float));
}

} // namespace

void points_csv(const PointshellFile &file, const std::function<void(std::string_view)> &sink)
{
    std::string block;
    for (std::size_t n = 0; n < columns(file); ++n) {
        if (n) block += ',';
        block += names[n];
    }
    block += '\n';
    for (const ShellPoint &point : file.shell.points) {
        const std::array<float, 7> values = row(point);
        for (std::size_t n = 0; n < columns(file); ++n) {
            char text[32];
            if (n) block += ',';
            block.append(text, std::to_chars(text, text + sizeof text, values[n]).ptr);
        }
        block += '\n';
        if (block.size() < 1 << 20) continue;
        sink(block);
        block.clear();
    }
    sink(block);
}

void points_ply(const PointshellFile &file, const std::function<void(std::string_view)> &sink)
{
    std::string block = fmt::format("ply\nformat binary_little_endian 1.0\ncomment pointshell, metres and "
                                    "square metres, normals inwards\n"
                                    "element vertex {}\n",
                                    file.shell.points.size());
    for (std::size_t n = 0; n < columns(file); ++n) block += fmt::format("property float {}\n", names[n]);
    block += "end_header\n";
    for (const ShellPoint &point : file.shell.points) {
        append(block, row(point).data(), columns(file));
        if (block.size() < 1 << 20) continue;
        sink(block);
        block.clear();
    }
    sink(block);
}

std::vector<std::uint8_t> points_glb(const PointshellFile &file)
{
    const Shell &shell = file.shell;
    const std::size_t count = shell.points.size(), size = columns(file) * sizeof(float) * count;
    check_glb_size(size);
    std::string binary;
    binary.reserve(size);
    std::array<float, 3> low = shell.points.front().position, high = low;
    for (const ShellPoint &point : shell.points) {
        append(binary, point.position.data(), 3);
        for (std::size_t a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], point.position[a]);
            high[a] = std::max(high[a], point.position[a]);
        }
    }
    for (const ShellPoint &point : shell.points) append(binary, point.normal.data(), 3);
    std::string attribute, view, accessor;
    if (file.areas) {
        for (const ShellPoint &point : shell.points) append(binary, &point.area, 1);
        attribute = R"(,"_AREA":2)";
        view = fmt::format(R"(,{{"buffer":0,"byteOffset":{},"byteLength":{},"target":34962}})", 24 * count,
                           4 * count);
        accessor =
            fmt::format(R"(,{{"bufferView":2,"componentType":5126,"count":{},"type":"SCALAR"}})", count);
    }
    const std::string json = fmt::format(
        R"({{"asset":{{"version":"2.0","generator":"voxshell"}},"scene":0,"scenes":[{{"nodes":[0]}}],)"
        R"("nodes":[{{"name":"pointshell","mesh":0}}],)"
        R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"NORMAL":1{}}},"mode":0}}]}}],)"
        R"("buffers":[{{"byteLength":{}}}],)"
        R"("bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":{},"target":34962}},)"
        R"({{"buffer":0,"byteOffset":{},"byteLength":{},"target":34962}}{}],)"
        R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3","min":[{},{},{}],"max":[{},{},{}]}},)"
        R"({{"bufferView":1,"componentType":5126,"count":{},"type":"VEC3"}}{}]}})",
        attribute, size, 12 * count, 12 * count, 12 * count, view, count, low[0], low[1], low[2], high[0],
        high[1], high[2], count, accessor);
    return glb_bytes(json, {reinterpret_cast<const std::uint8_t *>(binary.data()), binary.size()});
}

} // namespace voxshell
