#pragma once
// Solids of revolution about z: their surface as triangles, their inertia.

#include <vector>

#include "core/geometry/triangle_soup.hpp"

namespace feltwire {

/// A point of a profile that is turned about z.
struct Profile {
  double radius, z;  // [m]
};

/// The surface of revolution of a profile that begins and ends on the axis, from the top down.
TriangleSoup revolved(const std::vector<Profile>& profile, int segments);

/// The profile of a capsule: half a circle about the origin cut at its equator, its halves moved
/// apart.
std::vector<Profile> capsule_profile(double radius, double half_length, int segments);

/// [m^5] About an axis z of symmetry: `across` for x and y.
inline Mat3 inertia_about_z(double across, double along) {
  return Vec3(across, across, along).asDiagonal();
}

}  // namespace feltwire
