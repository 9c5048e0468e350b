#include "core/tool/polygon_body.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/polyhedra/depth_integrals.hpp"
#include "core/tool/placed_tool.hpp"

namespace feltwire {
namespace {

/// Adds the friction patches of an object to `sum`. `load` [N] is the force per unit of the sides'
/// weight.
void add_friction(const Material& material, const Mat3& to_world, const DepthSums& sums,
                  double load, const ObjectInStep& in, ShellContact& sum) {
  double whole = 0.0;
  for (const SlipSums& side : sums.sides) whole += side.weight;
  for (const SlipSums& side : sums.sides) {
    if (!(side.weight > 0.0)) continue;
    const Mat6 slip = turned_by(to_world, side.slip());
    sum.viscosity.add(in.share * material.viscous_friction * side.weight / whole * slip,
                      in.carried);
    if (!(material.static_friction > 0.0)) continue;
    if (sum.grip_count == ShellContact::kFrictionPatches)
      sum.patches.back().load += load * side.weight;
    else
      sum.patches[sum.grip_count++] = {load * side.weight,
                                       material.static_friction,
                                       material.dynamic_friction,
                                       slip,
                                       in.carried,
                                       in.index};
  }
}

bool slides(const Material& material) {
  return material.static_friction > 0.0 || material.viscous_friction > 0.0;
}

/// Computes the energy, force and stiffness from the depth sums of an object, and adds them to
/// `sum`.
void add_object(const Object& object, const DepthSums& sums, double contact_area,
                const ObjectInStep& in, ShellContact& sum) {
  const double root = std::sqrt(sums.cubes);
  if (!(root > 0.0)) return;
  const Material& material = object.material;
  const Mat3 to_world = object.pose.orientation.toRotationMatrix();
  // Compute the constant C of the contact law, and C / (2 sqrt V).
  const double constant = in.share * material.stiffness / std::sqrt(contact_area);
  const double scale = 0.5 * constant / root;
  sum.energy += constant * root;
  const Vec6 wrench = turned_by(to_world, Vec6(-scale * sums.slope));
  sum.wrench += wrench;
  const Mat6 stiffness = turned_by(
      to_world,
      Mat6(scale * (sums.curvature - sums.pushed * sums.pushed.transpose() / (2.0 * sums.cubes))));
  sum.stiffness += stiffness;
  sum.softening += turned_by(to_world, Mat6(scale * sums.ridges));
  sum.touching += sums.cells;
  if (sum.part_count < ShellContact::kFrictionPatches)
    sum.parts[sum.part_count++] = {in.index, wrench};
  else
    sum.parts.back().wrench += wrench;
  if (material.damping > 0.0)
    sum.damping.add(material.damping / material.stiffness * stiffness, in.carried);
  if (slides(material)) add_friction(material, to_world, sums, 3.0 * scale, in, sum);
}

}  // namespace

PolygonBody polygon_body(const std::vector<std::vector<Vec3>>& corners,
                         std::vector<SolidParts> solids) {
  PolygonBody body;
  body.solids = std::move(solids);
  for (const auto& part : corners) {
    body.parts.push_back(polyhedron(part));
    for (const Vec3& v : body.parts.back().vertices) body.radius = std::max(body.radius, v.norm());
  }
  return body;
}

ShellContact polygon_contact(const PolygonBody& body, std::span<const Object> objects,
                             double contact_area, const PartPairs& near, const Pose& tool,
                             std::span<const ObjectMotion> motions, PairPush* push) noexcept {
  ShellContact sum;
  if (push != nullptr) push->known = false;
  sum.clearance = near.free - travel(near.from, tool, body.radius) - kToolAdvance - kStayAway;
  for (std::size_t i = 0; i < near.count;) {
    const std::uint32_t index = near.pairs[i].object;
    const Object& object = objects[index];
    const SolidParts& solid = body.solids[index];
    const PlacedTool placed(tool, object.pose);
    DepthSums sums;
    for (; i < near.count && near.pairs[i].object == index; ++i) {
      const PartPair& pair = near.pairs[i];
      const double gap = placed.gap(body, solid, pair);
      if (gap > 0.0) {
        sum.clearance = std::min(sum.clearance, gap);
        continue;
      }
      const std::size_t before = sums.cells;
      if (push != nullptr && i == near.next_turn()) {
        DepthSums own;
        placed.add(body, solid, pair, slides(object.material), own);
        *push = {true, pair, tool, own.cubes, own.slope.head<3>()};
        sums += own;
      } else {
        placed.add(body, solid, pair, slides(object.material), sums);
      }
      ++sum.looked_at;
      if (sums.cells == before) sum.clearance = std::min(sum.clearance, 0.0);
    }
    add_object(object, sums, contact_area, in_step(index, object, motions, tool), sum);
  }
  return sum;
}

}  // namespace feltwire
