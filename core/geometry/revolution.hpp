#pragma once
// Solids of revolution about z: their surface as triangles, and their inertia.

#include <vector>

#include "core/geometry/triangle_soup.hpp"

namespace feltwire {

/// A point of a profile that is revolved about z.
struct Profile {
  double radius, z;  // [m]
};

/// Returns the surface of revolution of a profile that begins and ends on the axis, from the top
/// down.
TriangleSoup revolved(const std::vector<Profile>& profile, int segments);

/// Returns the profile of a capsule: half a circle about the origin, cut at its equator, with its
/// halves moved apart.
std::vector<Profile> capsule_profile(double radius, double half_length, int segments);

/// [m^5] inertia about an axis z of symmetry; `across` is that for x and y.
inline Mat3 inertia_about_z(double across, double along) {
  return Vec3(across, across, along).asDiagonal();
}

}  // namespace feltwire
