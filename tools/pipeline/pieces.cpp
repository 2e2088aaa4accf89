// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/pieces.hpp"

#include "mesh/weld.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace voxshell {
namespace {

struct Box {
    Point low, high;
    Box()
    {
        low.fill(std::numeric_limits<double>::infinity()),
            high.fill(-std::numeric_limits<double>::infinity());
    }
    void grow(const Point &p)
    {
        for (std::size_t a = 0; a < 3; ++a)
            low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
    }
};

std::uint32_t root_of(std::vector<std::uint32_t> &parent, std::uint32_t v)
{
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
}

/// Bit n of the low 21 to bit 3 n.
std::uint64_t spread(std::uint64_t bits)
{
    bits &= 0x1fffff;
    bits = (bits | bits << 32) & 0x001f00000000ffff;
    bits = (bits | bits << 16) & 0x001f0000ff0000ff;
    bits = (bits | bits << 8) & 0x100f00f00f00f00f;
    bits = (bits | bits << 4) & 0x10c30c30c30c30c3;
    return (bits | bits << 2) & 0x1249249249249249;
}

} // namespace

Pieces::Pieces(const Mesh &mesh)
{
    if (mesh.triangles.empty()) return;
    const Weld welded = weld(mesh);
    std::vector<std::uint32_t> parent(welded.count);
    std::iota(parent.begin(), parent.end(), 0u);
    for (const Triangle &t : mesh.triangles)
        for (const std::uint32_t v : t)
            parent[root_of(parent, welded.of[v])] = root_of(parent, welded.of[t[0]]);

    Box all;
    std::vector<Box> piece(welded.count);
    for (const Triangle &t : mesh.triangles)
        for (const std::uint32_t v : t) {
            piece[root_of(parent, welded.of[v])].grow(mesh.vertices[v]);
            all.grow(mesh.vertices[v]);
        }
    for (const Box &box : piece) {
        if (box.low[0] > box.high[0]) continue;
        ++count_;
        for (std::size_t a = 0; a < 3; ++a) extent_ += box.high[a] - box.low[a];
    }
    for (std::size_t a = 0; a < 3; ++a) span_ = std::max(span_, all.high[a] - all.low[a]);
    if (!(span_ > 0)) return;

    // In Morton's order vertices in one box stand together, whatever the box's size: neighbours that first
    // differ at some level begin a box there and at all finer ones.
    std::vector<std::uint64_t> places;
    places.reserve(welded.count);
    std::vector<bool> placed(welded.count);
    for (const Triangle &t : mesh.triangles)
        for (const std::uint32_t v : t) {
            if (placed[welded.of[v]]) continue;
            placed[welded.of[v]] = true;
            std::uint64_t place = 0;
            for (std::size_t a = 0; a < 3; ++a) {
                const double at = (mesh.vertices[v][a] - all.low[a]) / span_ * (1 << levels);
                place |= spread(static_cast<std::uint64_t>(std::min(at, double{(1 << levels) - 1}))) << a;
            }
            places.push_back(place);
        }
    std::sort(places.begin(), places.end());
    boxes_[0] = 1;
    for (std::size_t n = 1; n < places.size(); ++n)
        if (places[n] != places[n - 1])
            ++boxes_[static_cast<std::size_t>(levels -
                                              (63 - std::countl_zero(places[n] ^ places[n - 1])) / 3)];
    std::partial_sum(boxes_.begin(), boxes_.end(), boxes_.begin());
}

double Pieces::cubes(double size) const
{
    double most = count_, edge = span_;
    for (const double boxes : boxes_) {
        if (edge > 0) most = std::min(most, boxes * std::pow(edge / size + 1, 3));
        edge /= 2;
    }
    return extent_ / size + most;
}

} // namespace voxshell
