// SPDX-License-Identifier: GPL-3.0-or-later
// What a solid weighs, where its centre of mass is, and how hard it is to turn: exact integrals over the
// polyhedron.
#pragma once

#include "import/scene.hpp"

#include <array>

namespace voxshell {

/// In the mesh's frame.
struct MassProperties {
    double volume; ///< [m^3] > 0
    double mass;   ///< [kg]
    Point com;     ///< centre of mass [m]
    std::array<double, 6>
        inertia; ///< about it: xx yy zz xy xz yz of the tensor, xy = -sum m x y [kg m^2] (effect.h)
};

/// Of a homogeneous solid of this density [kg/m^3] > 0: the mesh's triangles seen from the middle of its box
/// are tetrahedra with a sign, and a polynomial's integral over each is one of its corners (Mirtich, "Fast
/// and accurate computation of polyhedral mass properties", J. Graphics Tools 1 (1996), by the divergence
/// theorem; the tetrahedra as in Tonon, "Explicit exact formulas for the 3-D tetrahedron inertia tensor", J.
/// Mathematics and Statistics 1 (2004)). An inside-out mesh is the solid that it is the inside of; what
/// several shells of a mesh overlap in counts several times, and a cavity's wall, which faces it, takes its
/// inside away.
/// Throws Failure: requirement for a mesh that is not closed, not wound in one sense or without a volume;
/// invalid for a density.
MassProperties mass_properties(const Mesh &mesh, double density);

} // namespace voxshell
