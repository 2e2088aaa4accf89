// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/weld.hpp"

#include <bit>

namespace voxshell {
namespace {

std::uint64_t stir(std::uint64_t x)
{
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

std::uint64_t hash(const Point &p)
{
    std::uint64_t h = 0x9e3779b97f4a7c15u;
    for (const double x : p) h = stir(h + std::bit_cast<std::uint64_t>(x + 0.0)); // -0 + 0 is +0
    return h;
}

} // namespace

Weld weld(const Mesh &mesh)
{
    constexpr std::uint32_t none = ~std::uint32_t{0};
    const std::size_t slots = std::bit_ceil(mesh.vertices.size() * 2 + 2);
    std::vector<std::uint32_t> table(slots, none); // first vertex at a place, open addressing
    Weld out;
    out.of.resize(mesh.vertices.size());
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
        std::size_t slot = hash(mesh.vertices[v]) & (slots - 1);
        while (table[slot] != none && mesh.vertices[table[slot]] != mesh.vertices[v])
            slot = (slot + 1) & (slots - 1);
        if (table[slot] == none) {
            table[slot] = v;
            out.of[v] = out.count++;
        } else {
            out.of[v] = out.of[table[slot]];
        }
    }
    return out;
}

} // namespace voxshell
