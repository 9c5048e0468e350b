#pragma once
// Volume, centre and inertia of solids, in closed form. Those of a mesh are exactly its
// polyhedron's.

#include "core/geometry/shapes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// The mass properties in the shape's own frame. The volume is zero for a plane, for a grid, and
/// for a mesh that is not closed or whose normals point inwards.
MassProperties mass_properties(const Shape& shape);

/// Precondition: the mesh is closed.
MassProperties mass_properties(const TriangleMesh& mesh);

/// The solid's properties in the frame that `pose` places it in.
MassProperties placed(const MassProperties& solid, const Pose& pose);
/// Two solids as one body; their overlap counts twice.
MassProperties together(const MassProperties& a, const MassProperties& b);

/// Whether a closed mesh is its own convex hull: it is one piece, and every edge bends outwards.
bool is_convex(const TriangleMesh& mesh);

}  // namespace feltwire
