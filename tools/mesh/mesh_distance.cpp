// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh_distance.hpp"

#include "mesh/intersections.hpp"
#include "mesh/report.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <atomic>
#include <cmath>
#include <vector>

namespace voxshell {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Boxes = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 point_of(const Point &p)
{
    return {p[0], p[1], p[2]};
}

/// Along no edge that anybody draws.
const Kernel::Vector_3 far_away{0.5773502691896258, 0.3141592653589793, 0.2718281828459045};

constexpr std::uint64_t most_pairs = 10'000'000; ///< of triangles that may cut each other: a second
constexpr double clear = 1e-9;                   ///< [m] off the surface, far above its rounding
constexpr double upright = 1e-9;                 ///< 1 - cosine of the way and the triangle's normal

/// What is in front of a triangle and behind it: Nearest::side.
struct Sides {
    std::atomic<signed char> front{0}, behind{0};
};

bool is_sound(const Mesh &mesh)
{
    const MeshReport found = report(mesh);
    Progress unseen;
    return found.closed && found.oriented && found.duplicate == 0 &&
           self_intersections(mesh, most_pairs, unseen) == 0;
}

} // namespace

struct MeshDistance::Tree {
    Triangles triangles;
    std::vector<Kernel::Vector_3> normals; ///< unit
    Boxes boxes;
    std::vector<Sides> sides; ///< of each triangle; none where a triangle's front may be on both sides

    Boxes::Point_and_primitive_id seed(const Kernel::Point_3 &p, std::uint32_t near) const
    {
        const auto triangle = triangles.cbegin() + near;
        return {Kernel().construct_projected_point_3_object()(*triangle, p), triangle};
    }
    std::uint32_t number(Triangles::const_iterator triangle) const
    {
        return static_cast<std::uint32_t>(triangle - triangles.cbegin());
    }
};

MeshDistance::MeshDistance(const Mesh &mesh) : tree_(std::make_unique<Tree>())
{
    for (const Triangle &t : mesh.triangles) {
        const Kernel::Triangle_3 triangle(point_of(mesh.vertices[t[0]]), point_of(mesh.vertices[t[1]]),
                                          point_of(mesh.vertices[t[2]]));
        if (!triangle.is_degenerate()) tree_->triangles.push_back(triangle);
    }
    if (tree_->triangles.empty()) throw Failure(ExitCode::invalid, mesh.name, "has no triangle with an area");
    tree_->boxes.insert(tree_->triangles.cbegin(), tree_->triangles.cend());
    tree_->boxes.build();
    tree_->boxes.accelerate_distance_queries();
    for (const Kernel::Triangle_3 &t : tree_->triangles) {
        const Kernel::Vector_3 twice = CGAL::cross_product(t[1] - t[0], t[2] - t[0]);
        tree_->normals.push_back(twice / std::sqrt(twice.squared_length()));
    }
    if (is_sound(mesh)) tree_->sides = std::vector<Sides>(tree_->triangles.size());
}

MeshDistance::~MeshDistance() = default;

Nearest MeshDistance::nearest(const Point &point, std::uint32_t near) const
{
    const Kernel::Point_3 p = point_of(point);
    const auto [foot, primitive] = near == no_triangle
                                       ? tree_->boxes.closest_point_and_primitive(p)
                                       : tree_->boxes.closest_point_and_primitive(p, tree_->seed(p, near));
    const std::uint32_t number = tree_->number(primitive);
    const Kernel::Vector_3 &normal = tree_->normals[number];
    const Kernel::Vector_3 way = p - foot;
    Nearest nearest{std::sqrt(way.squared_length()), {}, 0, number};
    const Kernel::Vector_3 away = nearest.distance > 1e-12 ? way / nearest.distance : normal;
    nearest.away = {away.x(), away.y(), away.z()};
    // Nothing lies in the ball around the point up to its foot; upright over the triangle, the ball reaches
    // down to the triangle itself, also at its rim.
    const double cosine = away * normal;
    if (!tree_->sides.empty() && nearest.distance > clear && std::abs(cosine) > 1 - upright) {
        std::atomic<signed char> &known =
            cosine > 0 ? tree_->sides[number].front : tree_->sides[number].behind;
        nearest.side = known.load(std::memory_order_relaxed);
        if (nearest.side == 0) {
            nearest.side = side(point);
            known.store(static_cast<signed char>(nearest.side), std::memory_order_relaxed);
        }
    }
    return nearest;
}

int MeshDistance::side(const Point &point) const
{
    std::vector<Boxes::Primitive_id> hit;
    tree_->boxes.all_intersected_primitives(Kernel::Ray_3(point_of(point), far_away),
                                            std::back_inserter(hit));
    int leaves = 0;
    for (const auto &triangle : hit) {
        const Kernel::Triangle_3 &t = *triangle;
        leaves += CGAL::cross_product(t[1] - t[0], t[2] - t[0]) * far_away > 0 ? 1 : -1;
    }
    return leaves > 0 ? -1 : 1;
}

Point MeshDistance::foot(const Point &point) const
{
    const Kernel::Point_3 foot = tree_->boxes.closest_point(point_of(point));
    return {foot.x(), foot.y(), foot.z()};
}

} // namespace voxshell
