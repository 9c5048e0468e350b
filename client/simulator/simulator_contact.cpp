#include "client/simulator/simulator_contact.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"

namespace feltwire {

LocalModel plane_of(const Vec3& position, const Vec3& force, double stiffness, double least_reach) {
  const double push = length(force);
  const double depth = push / stiffness;
  LocalModel model;
  model.center = position;
  model.reach = std::max(2.0 * depth, least_reach);
  model.count = 1;
  SurfacePatch& plane = model.patches.front();
  plane.normal = force / push;
  plane.point = position + depth * plane.normal;
  plane.radius = model.reach + depth;
  plane.material.stiffness = stiffness;
  return model;
}

}  // namespace feltwire
