#pragma once
// Volume, centre and inertia of solids, in closed form; of meshes exactly that of their polyhedron.

#include "core/geometry/shapes.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// In the shape's own frame. Volume zero: a plane, a grid, or a mesh that is not closed or has its
/// normals inwards.
MassProperties mass_properties(const Shape& shape);

/// Of a closed surface.
MassProperties mass_properties(const TriangleMesh& mesh);

/// The same solid seen from the frame that `pose` places it in.
MassProperties placed(const MassProperties& solid, const Pose& pose);
/// Two solids as one body; where they overlap it counts twice.
MassProperties together(const MassProperties& a, const MassProperties& b);

/// Every edge of the closed mesh bends outwards, and it is one piece: it is its own convex hull.
bool is_convex(const TriangleMesh& mesh);

}  // namespace feltwire
