#include "core/bounding/contact_frame.hpp"

namespace feltwire {
namespace {

constexpr double kRounding = 1e-14;

double factor(double allowed, double wanted) { return wanted > allowed ? allowed / wanted : 1.0; }

}  // namespace

Command ContactFrameBound::step(const BoundingStep& s) noexcept {
  const double c = translation_.c;

  // The command in its channels: e u and friction orthogonal to u. What friction has along u
  // (contact damping) counts as elastic, and a contact never pulls: e >= 0.
  const Vec3 u = direction(s.command.elastic);
  const double spring = length(s.command.elastic);
  const double along_normal = s.command.frictional.dot(u);
  const double elastic = std::max(0.0, spring + along_normal);
  Vec3 frictional = s.command.frictional - along_normal * u;
  // What the subtraction leaves by rounding is no friction; bounded, it could take the elastic
  // force with it.
  if (length(frictional) <= kRounding * length(s.command.frictional)) frictional.setZero();
  const double friction = length(frictional);

  // The frame u_p that was held. When no elastic force was held the frame is free: the new one is
  // taken, and the held force is split in it. |F|^2 is the sum of both parts' squares in every
  // frame, so no storage is made or lost.
  const bool framed = elastic_ > 0.0;
  const Vec3 u_p = framed ? normal_ : u;
  const double held_elastic = framed ? elastic_ : frictional_.dot(u_p);
  const Vec3 held_friction = framed ? frictional_ : Vec3(frictional_ - held_elastic * u_p);

  // How the device moved in it: dx = dx_el + dx_fr.
  const double dx_el = s.displacement.dot(u_p);
  const Vec3 dx_fr = s.displacement - dx_el * u_p;

  // (C), channel by channel; f = -F turns the sum into a difference.
  Debt debt = force_debt_;
  debt.add(force_excess_);
  double allowed_elastic = allowed_magnitude(hypotenuse(held_elastic - c * dx_el, spare_),
                                             c * std::abs(dx_el), s.hold_time, translation_, debt);
  double allowed_friction = allowed_magnitude(length(held_friction - c * dx_fr), c * length(dx_fr),
                                              s.hold_time, translation_, debt);
  allowed_friction =
      debt.repay(allowed_friction);  // friction first: the normal force is missed more
  allowed_elastic = debt.repay(allowed_elastic);
  force_debt_ = debt;
  allowed_force_ = hypotenuse(allowed_elastic, allowed_friction);

  double elastic_scale = factor(allowed_elastic, elastic);
  const double friction_scale = std::min(elastic_scale, factor(allowed_friction, friction));
  if (projection_ == Projection::joint) elastic_scale = friction_scale;

  last_ = {.stored = hypotenuse(elastic_, spare_),
           .spring = spring_,
           .pressed = -c * dx_el,
           .allowed = allowed_elastic,
           .rendered = elastic_scale * elastic,
           .rendered_spring = elastic_scale * spring};

  Command rendered;
  rendered.elastic = last_.rendered * u;
  rendered.frictional = friction_scale * frictional;
  if (torque_) {
    torque_debt_.add(torque_excess_);
    allowed_torque_ = torque_debt_.repay(
        allowed_magnitude(length(held_torque_ - rotation_.c * s.rotation),
                          rotation_.c * length(s.rotation), s.hold_time, rotation_, torque_debt_));
    rendered.torque = factor(allowed_torque_, length(s.command.torque)) * s.command.torque;
  }
  return rendered;
}

/// 2 c E(n) = 2 c E(n-1) + c (F(n-1) + F(n)) dx, F the spring's part; never more than the port took
/// in (`allowed`) nor than is left beside the friction's storage; never less than S(F(n)).
void ContactFrameBound::store(double held_friction) noexcept {
  const double spring_share = last_.rendered > 0.0 ? std::min(1.0, elastic_ / last_.rendered) : 0.0;
  spring_ = spring_share * last_.rendered_spring;
  spare_ = 0.0;
  if (!(elastic_ > 0.0) || held_friction >= allowed_force_) return;  // no contact, nothing kept
  const double work = last_.stored * last_.stored + (last_.spring + spring_) * last_.pressed;
  const double most = std::min(last_.allowed, root_difference(allowed_force_, held_friction));
  const double stored = std::min(std::sqrt(std::max(0.0, work)), most);
  if (stored > elastic_) spare_ = root_difference(stored, elastic_);
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
  if (storage_ == Storage::elastic) store(length(frictional_));
  force_excess_ = excess(hypotenuse(elastic_, length(frictional_)), allowed_force_);
  torque_excess_ = excess(length(held_torque_), allowed_torque_);
}

}  // namespace feltwire
