#pragma once
// Chooses where contact with fetched geometry is tried: where it is likely to cost the most.

#include <vector>

#include "core/contact/contact.hpp"
#include "core/local_model/prefetched_tool.hpp"
#include "core/local_model/trial_way.hpp"

namespace feltwire {

/// The largest number of ways on one mesh.
inline constexpr std::size_t kMostMeshWays = 12;
/// The largest number of ways of a body.
inline constexpr std::size_t kMostBodyWays = 32;

/// At the places of a mesh at which most triangles are near each other, and evenly over it.
/// Precondition: the object is a mesh.
std::vector<TrialWay> mesh_ways(const Object& object, std::uint16_t index);

/// For a tool whose farthest point is `radius` [m] from its origin: towards some solids, and
/// towards the middle of them all. The way begins where nothing of the solid is.
std::vector<TrialWay> body_ways(const std::vector<SolidData>& solids, double radius);

}  // namespace feltwire
