#include "core/local_model_extraction/body_solids.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/numeric.hpp"
#include "core/grid/signed_distance.hpp"

namespace feltwire {
namespace {

constexpr double kTooNear = 1e-2;  // [m] what is left out must be farther away
/// [m] Larger numbers are told by less than 1 um in 32 bits.
constexpr double kExact = 16.0;

struct NearObject {
  std::size_t index = 0;
  double distance = 0.0;  // [m] no point of the tool is nearer
};

std::optional<Primitives::And<>> with_formula(const Shape& shape) {
  std::optional<Primitives::And<>> found;
  on_primitive(
      shape, [&](const auto& solid) { found.emplace(solid); }, [] {});
  return found;
}

/// One as a datagram tells it.
std::optional<BodySolid> solid_of(const Object& object, std::size_t index, const World* world,
                                  const Vec3& tool) {
  const auto shape = with_formula(object.shape);
  if (!shape || index > std::numeric_limits<std::uint16_t>::max()) return std::nullopt;
  BodySolid solid{.shape = *shape,
                  .felt_from = object.felt_from,
                  .pose = object.pose,
                  .material = object.material,
                  .object = static_cast<std::uint16_t>(index)};
  // A plane is the same about any of its points.
  if (std::holds_alternative<Plane>(*shape)) {
    const Vec3 normal = object.pose.orientation * Vec3::UnitZ();
    const Vec3 off = tool - object.pose.position;
    solid.pose.position = tool - normal.dot(off) * normal;
  }
  if (world != nullptr) {
    const double trust = world->trust(index);
    solid.material.stiffness *= trust;
    solid.material.damping *= trust;
    solid.material.viscous_friction *= trust;
    solid.velocity = world->velocity_at(index, solid.pose.position);
    solid.turning = world->turning_of(index);
  }
  bool exact = (solid.pose.position - tool).cwiseAbs().maxCoeff() <= kExact;
  on_primitive(
      *shape,
      [&](const auto& s) {
        s.lengths(s, [&](const Length&, double number) { exact &= number <= kExact; });
      },
      [] {});
  if (!exact) return std::nullopt;
  return solid;
}

}  // namespace

bool add_solids(const BodyTool& tool, const std::vector<Object>& objects, const World* world,
                BodyModel& model) noexcept {
  const ShellNode& whole = tool.shell().nodes.front();
  const Vec3 middle = model.tool.position + model.tool.orientation * whole.center;
  // The nearest ones, one more than there are places.
  std::array<NearObject, kMaxBodySolids + 1> nearest;
  std::size_t count = 0;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Object& o = objects[i];
    const Vec3 place = o.pose.orientation.conjugate() * (middle - o.pose.position);
    const double distance =
        distance_at_least(o.shape, o.felt_from, place, whole.radius + model.reach) - whole.radius;
    if (!(distance < model.reach)) continue;
    if (count == nearest.size() && !(distance < nearest.back().distance)) continue;
    if (count < nearest.size()) ++count;
    std::size_t at = count - 1;
    for (; at > 0 && nearest[at - 1].distance > distance; --at) nearest[at] = nearest[at - 1];
    nearest[at] = {i, distance};
  }
  BodyModel with = model;
  for (const NearObject& object : std::span(nearest).first(count)) {
    const auto solid = solid_of(objects[object.index], object.index, world, model.tool.position);
    if (solid && with.solid_count < kMaxBodySolids) {
      with.solids[static_cast<std::size_t>(with.solid_count++)] = *solid;
      continue;
    }
    if (object.distance < kTooNear) return false;
    with.reach = std::min(with.reach, object.distance);
    break;  // the others are farther away
  }
  with.body = tool.id();
  model = with;
  return true;
}

}  // namespace feltwire
