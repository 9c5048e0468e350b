#include "core/local_model/body_model.hpp"

#include <algorithm>
#include <cmath>

#include "core/tool_coupling/slip_sums.hpp"

namespace feltwire {
namespace {

/// Adds the Coulomb friction and the viscous friction of the pressed patches to the contact.
void add_slip(const BodyModel& model, std::span<const SlipSums> sums, double elapsed,
              ShellContact& contact) noexcept {
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double load = sums[i].weight;
    if (!(load > 0.0)) continue;
    const BodyPatch& patch = model.patches[i];
    const Mat6 slip = sums[i].slip();
    Vec6 carried = Vec6::Zero();
    carried.head<3>() = elapsed * patch.velocity;
    if (patch.viscous_friction > 0.0) {
      double whole = 0.0;  // load on all patches of the object
      for (std::size_t k = 0; k < sums.size(); ++k)
        if (model.patches[k].object == patch.object) whole += sums[k].weight;
      contact.viscosity.add(patch.viscous_friction * load / whole * slip, carried);
    }
    if (!(patch.static_friction > 0.0)) continue;
    if (contact.grip_count == ShellContact::kFrictionPatches)
      contact.patches.back().load += load;
    else
      contact.patches[contact.grip_count++] = {
          load, patch.static_friction, patch.dynamic_friction, slip, carried, patch.object};
  }
}

/// A part of the tool, at the tool's current pose.
struct Placed {
  Vec3 arm, normal;
  Mat3 spread;
  double depth;  // [m] depth of the centre
};

/// Adds the contact of the part's points to `sum` and `slip`. Returns the force [N] of the part.
double add_part(const Placed& part, double stiffness, Mat6& resists, ShellContact& sum,
                SlipSums& slip) noexcept {
  const Vec3 along_normal = part.spread * part.normal;
  // [m^2] variance of the points' depths
  const double variance = std::max(0.0, part.normal.dot(along_normal));
  const PressedPart in = pressed_part(part.depth, std::sqrt(3.0 * variance));
  if (!(in.depth > 0.0)) return 0.0;
  // The mean arm of the points that are deeper by u is `arm` + u `lever`.
  const Vec3 lever =
      variance > kLeastSquare<double> ? Vec3(-along_normal / variance) : Vec3::Zero();
  Vec6 center, further;
  center << part.normal, part.arm.cross(part.normal);
  further << Vec3::Zero(), lever.cross(part.normal);
  sum.energy += 0.5 * stiffness * in.square;
  sum.wrench += stiffness * (in.depth * center + in.moment * further);
  resists = in.share * center * center.transpose() + in.second * further * further.transpose() +
            in.first * (center * further.transpose() + further * center.transpose());
  // The spread of the points across the normal also resists rotation.
  const Mat3 across = part.spread - variance * lever * lever.transpose();
  Mat3 cross;  // matrix of the cross product arm x normal
  const Vec3& n = part.normal;
  cross << 0.0, n.z(), -n.y(), -n.z(), 0.0, n.x(), n.y(), -n.x(), 0.0;
  resists.bottomRightCorner<3, 3>() += in.share * cross * across * cross.transpose();
  resists *= stiffness;
  const double force = stiffness * in.depth;
  slip.add(force, part.arm + in.moment / in.depth * lever, part.normal);
  const double off = in.moment / in.depth;
  slip.arms +=
      force * (across + (in.pressed_square / in.depth - off * off) * lever * lever.transpose());
  return force;
}

}  // namespace

PressedPart pressed_part(double depth, double half) noexcept {
  constexpr double kPoint = 1e-9;  // [m] A part with a smaller half width is a point.
  PressedPart in;
  if (!(half > kPoint)) {
    if (depth > 0.0) in = {1.0, 0.0, 0.0, depth, 0.0, depth * depth, 0.0};
    return in;
  }
  const double low = std::max(-depth, -half);
  if (!(low < half)) return in;
  const double density = 0.5 / half;
  in.share = density * (half - low);
  in.first = density * (half * half - low * low) / 2.0;
  in.second = density * (half * half * half - low * low * low) / 3.0;
  in.depth = depth * in.share + in.first;
  in.moment = depth * in.first + in.second;
  in.square = depth * in.depth + in.moment;
  const double third = density * (std::pow(half, 4) - std::pow(low, 4)) / 4.0;
  in.pressed_square = depth * in.second + third;
  return in;
}

ShellContact ModelledSurroundings::contact(const Pose& tool, WorkLimit* work) const noexcept {
  constexpr std::uint64_t kPlaneWork = 8;  // units of work per part
  ShellContact sum;
  if (solids_ != nullptr) sum = solids_->contact(tool, work);
  if (model_.count > 0 && may_go_on(work, kPlaneWork * static_cast<std::uint64_t>(model_.count)))
    add_planes(tool, sum);
  return sum;
}

void ModelledSurroundings::add_planes(const Pose& tool, ShellContact& sum) const noexcept {
  static_assert(kMaxBodyPatches <= ShellContact::kFrictionPatches);
  std::array<SlipSums, kMaxBodyPatches> sums;
  const Mat3 turned = tool.orientation.toRotationMatrix();
  const Mat3 before = model_.tool.orientation.toRotationMatrix();
  const Vec3 moved = tool.position - model_.tool.position;
  const Vec6 of_solids = sum.wrench;
  std::size_t touching = 0;
  for (const BodyPoint& point : model_.view()) {
    const BodyPatch& patch = model_.patches[point.patch];
    const Vec3 arm = turned * point.arm;
    const Vec3 way = moved + arm - before * point.arm - age_ * patch.velocity;
    const double distance = point.distance + point.normal.dot(way);
    const Mat3 spread = turned * point.spread * turned.transpose();
    Mat6 resists;
    const double force = add_part({arm, point.normal, spread, -distance}, point.stiffness, resists,
                                  sum, sums[point.patch]);
    if (!(force > 0.0)) {
      const double half = std::sqrt(3.0 * std::max(0.0, point.normal.dot(spread * point.normal)));
      sum.clearance = std::min(sum.clearance, std::max(0.0, distance - half));
      continue;
    }
    sum.stiffness += resists;
    if (patch.damping_time > 0.0) {
      Vec6 carried = Vec6::Zero();
      carried.head<3>() = elapsed_ * patch.velocity;
      sum.damping.add(patch.damping_time * resists, carried);
    }
    ++touching;
  }
  sum.looked_at += static_cast<std::size_t>(model_.count);
  if (touching == 0) return;
  sum.touching += touching;
  const Vec6 wrench = sum.wrench - of_solids;
  if (sum.part_count < ShellContact::kFrictionPatches)
    sum.parts[sum.part_count++] = {0, wrench};
  else
    sum.parts.back().wrench += wrench;
  add_slip(model_, std::span(sums).first(static_cast<std::size_t>(model_.patch_count)), elapsed_,
           sum);
}

}  // namespace feltwire
