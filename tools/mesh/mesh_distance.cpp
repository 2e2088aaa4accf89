// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh_distance.hpp"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

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

} // namespace

struct MeshDistance::Tree {
    Triangles triangles;
    Boxes boxes;
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
}

MeshDistance::~MeshDistance() = default;

Nearest MeshDistance::nearest(const Point &point) const
{
    const Kernel::Point_3 p = point_of(point);
    const auto [foot, primitive] = tree_->boxes.closest_point_and_primitive(p);
    Kernel::Vector_3 away = p - foot;
    double size = std::sqrt(away.squared_length());
    Nearest nearest{size, {}};
    if (!(size > 1e-12)) {
        const Kernel::Triangle_3 &t = *primitive;
        away = CGAL::cross_product(t[1] - t[0], t[2] - t[0]);
        size = std::sqrt(away.squared_length());
    }
    if (size > 0) nearest.away = {away.x() / size, away.y() / size, away.z() / size};
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
