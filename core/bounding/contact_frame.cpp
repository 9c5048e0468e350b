#include "core/bounding/contact_frame.hpp"

namespace feltwire {
namespace {

double factor(double allowed, double wanted) { return wanted > allowed ? allowed / wanted : 1.0; }

}  // namespace

Command ContactFrameBound::step(const BoundingStep& s) noexcept {
  const double c = translation_.c;

  // The command in its channels: e u and friction orthogonal to u. What friction has along u (contact damping) counts
  // as elastic, and a contact never pulls: e >= 0.
  const Vec3 u = direction(s.command.elastic);
  const double along_normal = s.command.frictional.dot(u);
  const double elastic = std::max(0.0, length(s.command.elastic) + along_normal);
  const Vec3 frictional = s.command.frictional - along_normal * u;
  const double friction = length(frictional);

  // How the device moved in the frame that was held: dx = dx_el + dx_fr. When no elastic force was held the split is
  // free, so it is made in the new frame.
  const Vec3& u_p = elastic_ > 0.0 ? normal_ : u;
  const double dx_el = s.displacement.dot(u_p);
  const Vec3 dx_fr = s.displacement - dx_el * u_p;

  // (C), channel by channel; f = -F turns the sum into a difference.
  const double allowed_elastic = allowed_magnitude(std::abs(elastic_ - c * dx_el), 0.0, c * std::abs(dx_el),
                                                   s.hold_time, translation_, elastic_debt_);
  // The held friction is orthogonal to u_p but when the frame is new: then it worked along u_p too.
  const double foreign = -2.0 * c * frictional_.dot(u_p) * dx_el;
  const double allowed_friction = allowed_magnitude(length(frictional_ - c * dx_fr), foreign, c * length(dx_fr),
                                                    s.hold_time, translation_, frictional_debt_);

  double elastic_scale = factor(allowed_elastic, elastic);
  const double friction_scale = std::min(elastic_scale, factor(allowed_friction, friction));
  if (projection_ == Projection::joint) elastic_scale = friction_scale;

  Command rendered;
  rendered.elastic = elastic_scale * elastic * u;
  rendered.frictional = friction_scale * frictional;
  if (torque_) {
    const double allowed = allowed_magnitude(length(held_torque_ - rotation_.c * s.rotation), 0.0,
                                             rotation_.c * length(s.rotation), s.hold_time, rotation_, torque_debt_);
    rendered.torque = factor(allowed, length(s.command.torque)) * s.command.torque;
  }
  return rendered;
}

void ContactFrameBound::set_held(const Command& held) noexcept {
  // The channels of what was held are found anew: whatever reports it may have bent it.
  normal_ = direction(held.elastic);
  const double along_normal = held.frictional.dot(normal_);
  elastic_ = length(held.elastic) + along_normal;
  frictional_ = held.frictional - along_normal * normal_;
  if (elastic_ < 0.0) {  // a pull: an elastic channel opposite to its normal
    elastic_ = -elastic_;
    normal_ = -normal_;
  }
  held_torque_ = held.torque;
}

}  // namespace feltwire
