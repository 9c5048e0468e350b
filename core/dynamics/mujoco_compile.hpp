#pragma once
// Makes the moving part of a scene from bodies and their objects.

#include <memory>
#include <vector>

#include "core/scene/mechanism.hpp"

namespace feltwire {

/// Convex solids, each as the points [m] that it is the hull of.
using ConvexSolids = std::vector<std::vector<Vec3>>;

/// Compiles the bodies and the static objects that they may collide with. `body_of` gives the body
/// of each object; -1: none. Object poses are those at the start, world frame. Moves the objects
/// that belong to bodies behind the others and keeps their order, because a scene stores them so.
/// `solids`: for each object that is a closed mesh the solids that bodies collide with, relative to
/// the mesh's origin; null, or no list: its convex hull. Mass and inertia are those of the mesh.
/// Throws std::invalid_argument that names body or object, field, value and remedy.
std::shared_ptr<const Mechanism> compile(
    std::vector<Object>& objects, std::vector<int> body_of, const std::vector<Body>& bodies,
    const MechanismOptions& options, std::vector<std::shared_ptr<const ConvexSolids>> solids = {});

}  // namespace feltwire
