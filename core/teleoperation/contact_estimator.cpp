#include "core/teleoperation/contact_estimator.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/teleoperation/low_pass.hpp"

namespace feltwire {
namespace {

constexpr double kSoftest = 50.0, kStiffest = 1e6;  // [N/m] plausible range of stiffness
constexpr double kMostFriction = 1.0;               // largest plausible friction coefficient
constexpr double kLeastSlide = 2e-3;                // [m/s] least speed of sliding
constexpr double kResting = 5e-6;                   // [m] smaller movements count as no movement
// [s] contact time for learning the stiffness
constexpr double kLearns = 0.5;
constexpr double kOther = 0.5;  // cosine of the largest angle between force and normal: 60 degrees
// [N s] impulse after which the measured normal outweighs the model's.
constexpr double kModelled = 0.02;

bool says(const SurfacePrior& prior) noexcept {
  return prior.key != 0 && prior.point.allFinite() && prior.normal.allFinite() &&
         prior.velocity.allFinite();
}

/// Returns true if the tool moves along the surface, and not mainly into it or out of it.
bool slides(const Vec3& velocity, const Vec3& normal) noexcept {
  constexpr double kSteep = 0.5;  // largest slope of a path along the surface
  const Vec3 off = along(velocity, normal);
  const double across = length(Vec3(velocity - off));
  return across > kLeastSlide && length(off) < kSteep * across;
}

}  // namespace

const RemoteContact& ContactEstimator::step(const Sample& s) noexcept {
  if (!s.position.allFinite() || !s.velocity.allFinite() || !s.force.allFinite() ||
      !(s.elapsed > 0.0))
    return told_;
  estimate(s);
  memory_.step(s.position, s.force, s.elapsed, counted_);
  tell(s.position);
  return told_;
}

void ContactEstimator::tell(const Vec3& tip) noexcept {
  told_ = surface_.contact;
  if (gap_.left && told_.surface != 0) told_.point = tip - kAway * told_.normal;
}

void ContactEstimator::estimate(const Sample& s) noexcept {
  const double force = length(s.force);
  const bool pressed = force > (pressed_ ? config_.off : config_.on);
  pressed_ = pressed;
  watch(s, force);
  if (!pressed) {
    gap_.time += s.elapsed;
    // While the tool slides, it leaves the surface for some samples. These samples belong to the
    // same contact.
    if (surface_.contact.touching && gap_.time < kApart) return;
    surface_.contact.touching = false;
    if (!expect(s)) recede(s);
    gap_.left = gap_.left || (gap_.time >= kLeft && gap_.absent >= SurfaceMemory::kAbsent);
    return;
  }
  // A force outside the friction cone belongs to another surface. A carried load is an exception,
  // because the pushing force adds to its weight. However, a load never makes a stiffness known. So
  // before the stiffness is learnt, this rule holds only after a gap without force.
  const bool other =
      (gap_.time > 0.0 || surface_.learnt) && s.force.dot(surface_.contact.normal) < kOther * force;
  if (!surface_.contact.touching || other) begin(s);
  gap_.time = 0.0;
  surface_.contact.touching = true;
  estimate_normal(s, force);
  const double along_normal = std::max(0.0, s.force.dot(surface_.contact.normal));
  touch_.time += s.elapsed;
  estimate_stiffness(s, along_normal);
  estimate_place(s, along_normal);
  if (surface_.contact.surface == expected_.surface && says(s.prior) &&
      s.prior.key == expected_.key)
    expected_.shift = (surface_.contact.point - s.prior.point).dot(s.prior.normal);
}

/// Measures for how long there has been no force although the tool is behind the touched surface.
void ContactEstimator::watch(const Sample& s, double force) noexcept {
  constexpr double kLeans = 0.5;  // largest error of the estimated plane's slope
  const Vec3 way = s.position - gap_.felt;
  const Vec3 off = along(way, surface_.contact.normal);
  const double deeper = -way.dot(surface_.contact.normal) - kLeans * length(Vec3(way - off));
  const bool missing = touch_.time > 0.0 && !pressed_ && deeper > -kResting;
  gap_.absent = missing ? gap_.absent + s.elapsed : 0.0;
  if (force > config_.on) gap_.felt = s.position;
}

/// Moves the surface back to the tip. Without a force, the tip cannot be inside the surface.
void ContactEstimator::recede(const Sample& s) noexcept {
  surface_.contact.velocity.setZero();
  const double inside = (surface_.contact.point - s.position).dot(surface_.contact.normal);
  if (surface_.contact.surface == 0 || !(inside > 0.0)) return;
  surface_.contact.point -= inside * surface_.contact.normal;
  gap_.receded += inside;
  if (gap_.receded > kSame) surface_.contact.surface = 0;
}

/// Places the surface according to the local model and the last contact, but not in front of the
/// tip. Called without a force. Returns false if the model has no valid surface here.
bool ContactEstimator::expect(const Sample& s) noexcept {
  const SurfacePrior& prior = s.prior;
  if (!says(prior)) return false;
  const bool found = surface_.contact.surface != 0 && surface_.contact.surface != expected_.surface;
  if (found && std::abs((s.position - surface_.contact.point).dot(surface_.contact.normal)) < kSame)
    return false;
  if (prior.key != expected_.key) {
    expected_.key = prior.key;
    expected_.surface = ++counted_;
    expected_.shift = gap_.receded = 0.0;
    expected_.disproved = false;
  }
  if (surface_.contact.surface != expected_.surface) {
    const bool usable = prior.stiffness >= kSoftest && prior.stiffness <= kStiffest;
    surface_.contact = {};
    surface_.contact.stiffness = usable ? prior.stiffness : config_.first_stiffness;
    surface_.contact.friction =
        prior.friction >= 0.0 ? std::min(prior.friction, kMostFriction) : 0.0;
    touch_.known = surface_.settled = surface_.learnt = gap_.left = moves_ = false;
    touch_.time = gap_.absent = 0.0;
    surface_.impulse = kModelled;
  }
  const double inside =
      std::max(0.0, (prior.point - s.position).dot(prior.normal) + expected_.shift);
  expected_.shift -= inside;
  gap_.receded += inside;
  expected_.disproved = expected_.disproved || gap_.receded > kSame;
  surface_.contact.surface = expected_.disproved ? 0 : expected_.surface;
  surface_.contact.normal = prior.normal;
  surface_.contact.velocity = prior.velocity;
  gap_.felt += s.elapsed * prior.velocity;
  surface_.contact.point =
      s.position + ((prior.point - s.position).dot(prior.normal) + expected_.shift) * prior.normal;
  return true;
}

/// Begins a contact with the last surface or with another surface.
void ContactEstimator::begin(const Sample& s) noexcept {
  constexpr double kSameWay = 0.7;  // cosine of 45 degrees
  const Vec3 normal = direction(s.force);
  const double away = std::abs((s.position - surface_.contact.point).dot(surface_.contact.normal));
  const bool last = surface_.contact.surface != 0 && away < kSame &&
                    normal.dot(surface_.contact.normal) > kSameWay;
  const bool same = last || change(s, normal);
  // If the tool bounces, this is still the same contact. Keep its samples until the stiffness is
  // known.
  if (!same || touch_.known || touch_.time == 0.0) {
    fit_.clear();
    touch_.time = 0.0;
    touch_.origin = s.position;
    touch_.known = false;
  }
  moves_ = last && (moves_ || gap_.left);
  touch_.known = touch_.known || (moves_ && surface_.learnt);
  gap_.left = false;
  gap_.receded = gap_.absent = 0.0;
  // With this height, the first sample is always used.
  touch_.last_height = s.position.dot(surface_.contact.normal) + 1.0;
  const double force = length(s.force);
  touch_.within = same ? way_within(s, force) : Vec3::Zero();
  if (same)
    surface_.contact.normal =
        direction(surface_.contact.normal - along(surface_.contact.normal, touch_.within));
  const double measured = height_of(s, force);
  place_.begin(measured, same ? surface_.contact.point.dot(surface_.contact.normal) : measured);
}

/// Returns the direction from the last contact point to this contact point. The direction lies in
/// the surface, so a force along it is friction.
Vec3 ContactEstimator::way_within(const Sample& s, double force) const noexcept {
  constexpr double kShortest = 2e-3, kLongest = 30e-3;  // [m] least and largest usable distance
  constexpr double kSteep = 0.35;  // largest error of the normal: sine of 20 degrees
  const Vec3 here = s.position + force / surface_.contact.stiffness * surface_.contact.normal;
  const Polar<double> way = polar(Vec3(here - surface_.touched));
  const bool usable = way.length > kShortest && way.length < kLongest &&
                      std::abs(way.direction.dot(surface_.contact.normal)) < kSteep;
  return usable ? way.direction : Vec3::Zero();
}

/// Begins a contact with another surface than before. Returns true if the memory has this surface.
bool ContactEstimator::change(const Sample& s, const Vec3& normal) noexcept {
  const bool found = surface_.contact.surface != 0 && surface_.contact.surface != expected_.surface;
  if (found && !gap_.left) memory_.keep(surface_, s.position);
  touch_.time = 0.0;
  if (const auto before = memory_.take(s.position, normal, kSame)) {
    surface_ = *before;
    if (!before->told) surface_.contact.surface = ++counted_;
    return true;
  }
  surface_.contact = {};
  surface_.contact.surface = ++counted_;
  surface_.contact.normal = normal;
  surface_.contact.stiffness = config_.first_stiffness;
  surface_.settled = surface_.learnt = false;
  surface_.impulse = 0.0;
  return false;
}

void ContactEstimator::estimate_normal(const Sample& s, double force) noexcept {
  constexpr double kCone = 0.7;                   // cosine of the friction cone at kMostFriction
  constexpr double kSlow = 3.0;                   // [Hz] cutoff frequency of the slow filter
  constexpr double kYoung = 0.1, kSettled = 0.5;  // [s] limits of the time in this contact
  const double speed = length(s.velocity);
  Vec3 pressing = s.force - along(s.force, touch_.within);
  if (std::abs(s.force.dot(touch_.within)) > kMostFriction * length(pressing)) {
    touch_.within.setZero();  // The force is too large for friction.
    pressing = s.force;
  }
  const Vec3 way = speed > kLeastSlide ? Vec3(s.velocity / speed) : Vec3::Zero();
  const bool sliding = slides(s.velocity, surface_.contact.normal);
  Vec3 pushes = pressing;
  bool rubs = false;
  // A negative value means that the surface springs back.
  const double against = -s.force.dot(way);
  if (sliding && against >= 0.0) {
    const Vec3 across = pressing - along(pressing, way);
    const double normal_force = length(across);
    // If the ratio is larger than kMostFriction, it is no friction. Then the tool carries a weight,
    // or the normal is wrong.
    rubs = normal_force > config_.on && against < kMostFriction * normal_force;
    if (rubs) {
      pushes = across;
      surface_.contact.friction +=
          low_pass_share(kSlow, s.elapsed) * (against / normal_force - surface_.contact.friction);
    }
  }
  surface_.settled = surface_.settled || touch_.time >= kSettled;
  if (!(force > config_.on)) return;
  // A tool that arrives, bounces or springs back also slides by some tenths of a millimetre, with
  // friction. Then the force does not show the normal, unless the force is outside every friction
  // cone.
  const bool young = !surface_.settled && touch_.time < kYoung;
  const bool bounces = touch_.time < kSettled && speed > kLeastSlide && !rubs;
  const bool springs = sliding && against < 0.0;
  if (!young && (bounces || springs) && s.force.dot(surface_.contact.normal) > kCone * force)
    return;
  // For a new contact, use the direction of its total impulse. The force of a sticking and
  // springing tool tilts to both sides, and the normal must not follow this oscillation.
  const double pushed = force * s.elapsed;
  surface_.impulse += young ? pushed : 0.0;
  const double slow = low_pass_share(kSlow, s.elapsed);
  const double share = young ? std::max(slow, pushed / surface_.impulse) : slow;
  const Vec3 turned =
      direction(surface_.contact.normal + share * (direction(pushes) - surface_.contact.normal));
  if (turned.isZero(0.0)) return;
  // place_ stores the position of the surface as a height along the normal. Adapt this height when
  // the normal turns.
  place_.carry((turned - surface_.contact.normal).dot(surface_.contact.point));
  surface_.contact.normal = turned;
}

void ContactEstimator::estimate_stiffness(const Sample& s, double force) noexcept {
  constexpr double kExcited = 0.1e-3;  // [m] least movement along the normal for a fit
  constexpr double kExplained = 0.98;
  if (touch_.known && (touch_.time > kLearns || moves_)) return;
  const double height = s.position.dot(surface_.contact.normal);
  if (std::abs(height - touch_.last_height) < kResting) return;  // The sample would only add noise.
  touch_.last_height = height;
  fit_.add(touch_.origin - s.position, -s.velocity, s.force);
  if (fit_.excitation(surface_.contact.normal) < kExcited) return;
  const LineFit::Line line = fit_.line(surface_.contact.normal);
  if (line.explained < kExplained || !(line.slope > kSoftest) || !(line.slope < kStiffest)) return;
  // On a stiffer surface, the old position would imply a larger force, so the position changes in
  // the same sample. On a softer surface, the new position may be far away, and the first fit may
  // be wrong. So the position moves there slowly.
  const bool stiffer = line.slope > surface_.contact.stiffness;
  surface_.contact.stiffness = line.slope;
  const double place = height_of(s, force);
  if (!touch_.known && stiffer)
    place_.begin(place, place);
  else if (!touch_.known)
    place_.relearn(place);
  touch_.known = surface_.learnt = true;
}

/// Returns the height [m] along the normal at which the surface would give this force.
double ContactEstimator::height_of(const Sample& s, double force) const noexcept {
  return s.position.dot(surface_.contact.normal) + force / surface_.contact.stiffness;
}

void ContactEstimator::estimate_place(const Sample& s, double force) noexcept {
  const bool unknown = !touch_.known && touch_.time < kLearns;
  place_.step(height_of(s, force), s.elapsed,
              slides(s.velocity, surface_.contact.normal) || unknown);
  surface_.contact.velocity = place_.speed() * surface_.contact.normal;
  surface_.contact.point = s.position + (place_.place() - s.position.dot(surface_.contact.normal)) *
                                            surface_.contact.normal;
  surface_.touched = surface_.contact.point;
}

}  // namespace feltwire
