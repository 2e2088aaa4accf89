// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/assembly.hpp"

#include "import/importers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>

namespace voxshell {
namespace {

using Matrix = std::array<double, 9>;
constexpr Matrix identity{1, 0, 0, 0, 1, 0, 0, 0, 1};
constexpr double same_shape = 2e-6; ///< transforms come as floats, through chains of nodes

double determinant(const Matrix &m)
{
    return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
           m[2] * (m[3] * m[7] - m[4] * m[6]);
}

/// Of the inverse, transposed.
Matrix cofactors(const Matrix &m)
{
    Matrix c;
    for (std::size_t r = 0; r < 3; ++r)
        for (std::size_t k = 0; k < 3; ++k) {
            const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            c[3 * r + k] = m[3 * r1 + k1] * m[3 * r2 + k2] - m[3 * r1 + k2] * m[3 * r2 + k1];
        }
    return c;
}

double largest(const Matrix &m)
{
    double most = 0;
    for (const double x : m) most = std::max(most, std::abs(x));
    return most;
}

/// The turn of m: its polar factor by Newton's iteration (Higham 1986), with determinant +1.
bool turn_of(const Matrix &m, Matrix &turn)
{
    const double scale = largest(m);
    if (!(scale > 0)) return false;
    for (std::size_t n = 0; n < 9; ++n) turn[n] = m[n] / scale;
    for (int step = 0; step < 60; ++step) {
        const double d = determinant(turn);
        if (!(std::abs(d) > 1e-12)) return false; // flat, or thinner than what its digits say
        const Matrix c = cofactors(turn);
        double moved = 0;
        for (std::size_t n = 0; n < 9; ++n) {
            const double next = (turn[n] + c[n] / d) / 2;
            moved = std::max(moved, std::abs(next - turn[n]));
            turn[n] = next;
        }
        if (moved < 1e-15) break;
    }
    if (determinant(turn) < 0)
        for (double &x : turn) x = -x;
    return true;
}

/// Six digits of the largest: what two chains of float transforms that mean the same agree on.
Matrix rounded(Matrix shape)
{
    const double scale = largest(shape);
    double off = 0;
    for (std::size_t n = 0; n < 9; ++n) off = std::max(off, std::abs(shape[n] - identity[n]));
    if (off <= same_shape) return identity;
    const double digit = std::pow(10, 5 - std::floor(std::log10(scale)));
    for (double &x : shape) x = std::round(x * digit) / digit + 0.0;
    return shape;
}

std::array<double, 4> quaternion(const Matrix &r)
{
    const double trace[4] = {1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                             1 - r[0] - r[4] + r[8]};
    const std::size_t most = static_cast<std::size_t>(std::max_element(trace, trace + 4) - trace);
    const double x = r[7] - r[5], y = r[2] - r[6], z = r[3] - r[1];
    const double xy = r[1] + r[3], xz = r[2] + r[6], yz = r[5] + r[7], t = trace[most];
    const double rows[4][4] = {{t, x, y, z}, {x, t, xy, xz}, {y, xy, t, yz}, {z, xz, yz, t}};
    std::array<double, 4> q;
    double norm = 0;
    for (std::size_t n = 0; n < 4; ++n) norm += rows[most][n] * rows[most][n];
    norm = std::copysign(std::sqrt(norm), rows[most][0]); // w >= 0
    for (std::size_t n = 0; n < 4; ++n) q[n] = rows[most][n] / norm + 0.0;
    return q;
}

Sha256 hash_of(const Mesh &mesh, const Matrix &shape)
{
    static_assert(std::endian::native == std::endian::little);
    const auto bytes = [](const auto &numbers) {
        return std::span(reinterpret_cast<const std::uint8_t *>(numbers.data()),
                         numbers.size() * sizeof numbers[0]);
    };
    const std::array<std::uint64_t, 2> counts{mesh.vertices.size(), mesh.triangles.size()};
    Sha256Stream hash;
    hash.update(bytes(counts));
    hash.update(bytes(mesh.vertices));
    hash.update(bytes(mesh.triangles));
    hash.update(bytes(shape));
    return hash.digest();
}

Point applied(const Matrix &m, const Point &p)
{
    Point q;
    for (std::size_t r = 0; r < 3; ++r) q[r] = m[3 * r] * p[0] + m[3 * r + 1] * p[1] + m[3 * r + 2] * p[2];
    return q;
}

class Names {
  public:
    std::string unique(const std::string &wanted)
    {
        std::string name = wanted;
        for (int n = 2; !taken_.insert(lower(name)).second; ++n) name = fmt::format("{}-{}", wanted, n);
        return name;
    }

  private:
    static std::string lower(std::string text)
    {
        for (char &c : text)
            if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
        return text;
    }
    std::set<std::string> taken_;
};

/// What to call a part: its mesh, or else the node that has it.
std::string name_of(const Scene &scene, const Instance &instance)
{
    const std::string &mesh = scene.meshes[instance.mesh].name;
    if (!mesh.empty() && mesh != scene.name) return file_name(mesh);
    return file_name(instance.name.substr(instance.name.rfind('/') + 1));
}

} // namespace

std::string file_name(std::string_view text)
{
    std::string name = printable(text, 120);
    std::replace(name.begin(), name.end(), '/', '_');
    if (!name.empty() && name[0] == '.') name[0] = '_';
    return name.empty() ? "part" : name;
}

Scene split_solids(Scene scene)
{
    if (scene.meshes.size() != 1 || scene.instances.size() != 1 || scene.meshes[0].solids.size() < 2)
        return scene;
    const Mesh whole = std::move(scene.meshes[0]);
    const Instance stands = scene.instances[0];
    scene.meshes.clear();
    scene.instances.clear();
    std::vector<std::uint32_t> vertex_of(whole.vertices.size(), ~0u);
    for (std::size_t n = 0; n < whole.solids.size(); ++n) {
        const std::size_t last =
            n + 1 < whole.solids.size() ? whole.solids[n + 1].first : whole.triangles.size();
        Mesh solid;
        solid.name = whole.solids[n].name.empty() ? fmt::format("solid {}", n + 1) : whole.solids[n].name;
        std::vector<std::uint32_t> used;
        for (std::size_t t = whole.solids[n].first; t < last; ++t) {
            Triangle triangle = whole.triangles[t];
            for (std::uint32_t &v : triangle) {
                if (vertex_of[v] == ~0u) {
                    vertex_of[v] = static_cast<std::uint32_t>(solid.vertices.size());
                    solid.vertices.push_back(whole.vertices[v]);
                    used.push_back(v);
                }
                v = vertex_of[v];
            }
            solid.triangles.push_back(triangle);
        }
        for (const std::uint32_t v : used) vertex_of[v] = ~0u;
        scene.instances.push_back(
            {stands.name + "/" + file_name(solid.name), static_cast<std::uint32_t>(n), stands.pose, {}});
        scene.meshes.push_back(std::move(solid));
    }
    return scene;
}

Assembly assemble(const Scene &scene)
{
    Assembly all;
    std::map<std::pair<std::uint32_t, Matrix>, Sha256> hashes; // a mesh is hashed once for each shape
    std::map<Sha256, std::size_t> parts;
    std::vector<double> radius(scene.meshes.size(), -1); // of a mesh about its own origin [m]
    Names names;
    all.nodes = scene.nodes;
    all.materials = scene.materials;
    for (const Mesh &mesh : scene.meshes) all.materials_of_mesh.push_back(mesh.materials);
    for (const Instance &instance : scene.instances) {
        const std::array<double, 12> &pose = instance.pose;
        const Matrix m{pose[0], pose[1], pose[2], pose[4], pose[5], pose[6], pose[8], pose[9], pose[10]};
        Matrix turn, stretch;
        if (!turn_of(m, turn))
            throw Failure(
                ExitCode::invalid, "",
                fmt::format("the transform of {} flattens it: a part needs all three axes", instance.name));
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t k = 0; k < 3; ++k)
                stretch[3 * r + k] =
                    turn[r] * m[k] + turn[3 + r] * m[3 + k] + turn[6 + r] * m[6 + k]; // turned back
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t k = r + 1; k < 3; ++k)
                stretch[3 * r + k] = stretch[3 * k + r] = (stretch[3 * r + k] + stretch[3 * k + r]) / 2;
        const Matrix shape = rounded(stretch);

        const Mesh &mesh = scene.meshes[instance.mesh];
        const auto [hash, is_new] = hashes.try_emplace({instance.mesh, shape});
        if (is_new) hash->second = hash_of(mesh, shape);
        const auto [part, first] = parts.try_emplace(hash->second, all.parts.size());
        if (first)
            all.parts.push_back(
                {names.unique(name_of(scene, instance)), instance.mesh, shape, hash->second, 0});
        ++all.parts[part->second].instances;
        all.instances.push_back({instance.name,
                                 part->second,
                                 quaternion(turn),
                                 {pose[3], pose[7], pose[11]},
                                 instance.node,
                                 instance.mesh});

        double &far = radius[instance.mesh];
        if (far < 0)
            for (const Point &p : mesh.vertices)
                far = std::max(far, std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]));
        double off = 0;
        for (std::size_t r = 0; r < 3; ++r)
            for (std::size_t k = 0; k < 3; ++k) {
                const double again =
                    turn[3 * r] * shape[k] + turn[3 * r + 1] * shape[3 + k] + turn[3 * r + 2] * shape[6 + k];
                off += (again - m[3 * r + k]) * (again - m[3 * r + k]);
            }
        all.pose_error = std::max(all.pose_error, far * std::sqrt(off));
    }
    return all;
}

Scene part_scene(const Scene &scene, const AssemblyPart &part)
{
    Scene alone;
    alone.name = part.name;
    alone.source_hash = part.hash;
    alone.meshes.push_back(scene.meshes[part.mesh]);
    Mesh &mesh = alone.meshes[0];
    mesh.name = part.name;
    if (part.shape != identity) {
        for (Point &p : mesh.vertices) p = applied(part.shape, p);
        if (determinant(part.shape) < 0)
            for (Triangle &t : mesh.triangles) std::swap(t[1], t[2]);
    }
    alone.instances.push_back({.name = "/" + part.name, .mesh = 0});
    return alone;
}

} // namespace voxshell
