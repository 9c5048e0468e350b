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
  told_ = contact_;
  if (left_ && told_.surface != 0) told_.point = tip - kAway * told_.normal;
}

void ContactEstimator::estimate(const Sample& s) noexcept {
  const double force = length(s.force);
  const bool pressed = force > (pressed_ ? config_.off : config_.on);
  pressed_ = pressed;
  watch(s, force);
  if (!pressed) {
    apart_ += s.elapsed;
    // While the tool slides, it leaves the surface for some samples. These samples belong to the
    // same contact.
    if (contact_.touching && apart_ < kApart) return;
    contact_.touching = false;
    if (!expect(s)) recede(s);
    left_ = left_ || (apart_ >= kLeft && absent_ >= SurfaceMemory::kAbsent);
    return;
  }
  // A force outside the friction cone belongs to another surface. A carried load is an exception,
  // because the pushing force adds to its weight. However, a load never makes a stiffness known. So
  // before the stiffness is learnt, this rule holds only after a gap without force.
  const bool other = (apart_ > 0.0 || learnt_) && s.force.dot(contact_.normal) < kOther * force;
  if (!contact_.touching || other) begin(s);
  apart_ = 0.0;
  contact_.touching = true;
  estimate_normal(s, force);
  const double along_normal = std::max(0.0, s.force.dot(contact_.normal));
  touched_ += s.elapsed;
  estimate_stiffness(s, along_normal);
  estimate_place(s, along_normal);
  if (contact_.surface == expected_ && says(s.prior) && s.prior.key == expected_key_)
    shift_ = (contact_.point - s.prior.point).dot(s.prior.normal);
}

/// Measures for how long there has been no force although the tool is behind the touched surface.
void ContactEstimator::watch(const Sample& s, double force) noexcept {
  constexpr double kLeans = 0.5;  // largest error of the estimated plane's slope
  const Vec3 way = s.position - felt_;
  const Vec3 off = along(way, contact_.normal);
  const double deeper = -way.dot(contact_.normal) - kLeans * length(Vec3(way - off));
  const bool missing = touched_ > 0.0 && !pressed_ && deeper > -kResting;
  absent_ = missing ? absent_ + s.elapsed : 0.0;
  if (force > config_.on) felt_ = s.position;
}

/// Moves the surface back to the tip. Without a force, the tip cannot be inside the surface.
void ContactEstimator::recede(const Sample& s) noexcept {
  contact_.velocity.setZero();
  const double inside = (contact_.point - s.position).dot(contact_.normal);
  if (contact_.surface == 0 || !(inside > 0.0)) return;
  contact_.point -= inside * contact_.normal;
  receded_ += inside;
  if (receded_ > kSame) contact_.surface = 0;
}

/// Places the surface according to the local model and the last contact, but not in front of the
/// tip. Called without a force. Returns false if the model has no valid surface here.
bool ContactEstimator::expect(const Sample& s) noexcept {
  const SurfacePrior& prior = s.prior;
  if (!says(prior)) return false;
  const bool found = contact_.surface != 0 && contact_.surface != expected_;
  if (found && std::abs((s.position - contact_.point).dot(contact_.normal)) < kSame) return false;
  if (prior.key != expected_key_) {
    expected_key_ = prior.key;
    expected_ = ++counted_;
    shift_ = receded_ = 0.0;
    disproved_ = false;
  }
  if (contact_.surface != expected_) {
    const bool usable = prior.stiffness >= kSoftest && prior.stiffness <= kStiffest;
    contact_ = {};
    contact_.stiffness = usable ? prior.stiffness : config_.first_stiffness;
    contact_.friction = prior.friction >= 0.0 ? std::min(prior.friction, kMostFriction) : 0.0;
    known_ = settled_ = learnt_ = left_ = moves_ = false;
    touched_ = absent_ = 0.0;
    impulse_ = kModelled;
  }
  const double inside = std::max(0.0, (prior.point - s.position).dot(prior.normal) + shift_);
  shift_ -= inside;
  receded_ += inside;
  disproved_ = disproved_ || receded_ > kSame;
  contact_.surface = disproved_ ? 0 : expected_;
  contact_.normal = prior.normal;
  contact_.velocity = prior.velocity;
  felt_ += s.elapsed * prior.velocity;
  contact_.point =
      s.position + ((prior.point - s.position).dot(prior.normal) + shift_) * prior.normal;
  return true;
}

/// Begins a contact with the last surface or with another surface.
void ContactEstimator::begin(const Sample& s) noexcept {
  constexpr double kSameWay = 0.7;  // cosine of 45 degrees
  const Vec3 normal = direction(s.force);
  const double away = std::abs((s.position - contact_.point).dot(contact_.normal));
  const bool last = contact_.surface != 0 && away < kSame && normal.dot(contact_.normal) > kSameWay;
  const bool same = last || change(s, normal);
  // If the tool bounces, this is still the same contact. Keep its samples until the stiffness is
  // known.
  if (!same || known_ || touched_ == 0.0) {
    fit_.clear();
    touched_ = 0.0;
    origin_ = s.position;
    known_ = false;
  }
  moves_ = last && (moves_ || left_);
  known_ = known_ || (moves_ && learnt_);
  left_ = false;
  receded_ = absent_ = 0.0;
  // With this height, the first sample is always used.
  last_height_ = s.position.dot(contact_.normal) + 1.0;
  const double force = length(s.force);
  within_ = same ? way_within(s, force) : Vec3::Zero();
  if (same) contact_.normal = direction(contact_.normal - along(contact_.normal, within_));
  const double measured = height_of(s, force);
  place_.begin(measured, same ? contact_.point.dot(contact_.normal) : measured);
}

/// Returns the direction from the last contact point to this contact point. The direction lies in
/// the surface, so a force along it is friction.
Vec3 ContactEstimator::way_within(const Sample& s, double force) const noexcept {
  constexpr double kShortest = 2e-3, kLongest = 30e-3;  // [m] least and largest usable distance
  constexpr double kSteep = 0.35;  // largest error of the normal: sine of 20 degrees
  const Vec3 here = s.position + force / contact_.stiffness * contact_.normal;
  const Polar<double> way = polar(Vec3(here - last_));
  const bool usable = way.length > kShortest && way.length < kLongest &&
                      std::abs(way.direction.dot(contact_.normal)) < kSteep;
  return usable ? way.direction : Vec3::Zero();
}

/// Begins a contact with another surface than before. Returns true if the memory has this surface.
bool ContactEstimator::change(const Sample& s, const Vec3& normal) noexcept {
  const bool found = contact_.surface != 0 && contact_.surface != expected_;
  if (found && !left_)
    memory_.keep({.contact = contact_,
                  .settled = settled_,
                  .learnt = learnt_,
                  .impulse = impulse_,
                  .touched = last_},
                 s.position);
  touched_ = 0.0;
  if (const auto before = memory_.take(s.position, normal, kSame)) {
    contact_ = before->contact;
    if (!before->told) contact_.surface = ++counted_;
    settled_ = before->settled;
    learnt_ = before->learnt;
    impulse_ = before->impulse;
    last_ = before->touched;
    return true;
  }
  contact_ = {};
  contact_.surface = ++counted_;
  contact_.normal = normal;
  contact_.stiffness = config_.first_stiffness;
  settled_ = learnt_ = false;
  impulse_ = 0.0;
  return false;
}

void ContactEstimator::estimate_normal(const Sample& s, double force) noexcept {
  constexpr double kCone = 0.7;                   // cosine of the friction cone at kMostFriction
  constexpr double kSlow = 3.0;                   // [Hz] cutoff frequency of the slow filter
  constexpr double kYoung = 0.1, kSettled = 0.5;  // [s] limits of the time in this contact
  const double speed = length(s.velocity);
  Vec3 pressing = s.force - along(s.force, within_);
  if (std::abs(s.force.dot(within_)) > kMostFriction * length(pressing)) {
    within_.setZero();  // The force is too large for friction.
    pressing = s.force;
  }
  const Vec3 way = speed > kLeastSlide ? Vec3(s.velocity / speed) : Vec3::Zero();
  const bool sliding = slides(s.velocity, contact_.normal);
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
      contact_.friction +=
          low_pass_share(kSlow, s.elapsed) * (against / normal_force - contact_.friction);
    }
  }
  settled_ = settled_ || touched_ >= kSettled;
  if (!(force > config_.on)) return;
  // A tool that arrives, bounces or springs back also slides by some tenths of a millimetre, with
  // friction. Then the force does not show the normal, unless the force is outside every friction
  // cone.
  const bool young = !settled_ && touched_ < kYoung;
  const bool bounces = touched_ < kSettled && speed > kLeastSlide && !rubs;
  const bool springs = sliding && against < 0.0;
  if (!young && (bounces || springs) && s.force.dot(contact_.normal) > kCone * force) return;
  // For a new contact, use the direction of its total impulse. The force of a sticking and
  // springing tool tilts to both sides, and the normal must not follow this oscillation.
  const double pushed = force * s.elapsed;
  impulse_ += young ? pushed : 0.0;
  const double slow = low_pass_share(kSlow, s.elapsed);
  const double share = young ? std::max(slow, pushed / impulse_) : slow;
  const Vec3 turned = direction(contact_.normal + share * (direction(pushes) - contact_.normal));
  if (turned.isZero(0.0)) return;
  // place_ stores the position of the surface as a height along the normal. Adapt this height when
  // the normal turns.
  place_.carry((turned - contact_.normal).dot(contact_.point));
  contact_.normal = turned;
}

void ContactEstimator::estimate_stiffness(const Sample& s, double force) noexcept {
  constexpr double kExcited = 0.1e-3;  // [m] least movement along the normal for a fit
  constexpr double kExplained = 0.98;
  if (known_ && (touched_ > kLearns || moves_)) return;
  const double height = s.position.dot(contact_.normal);
  if (std::abs(height - last_height_) < kResting) return;  // The sample would only add noise.
  last_height_ = height;
  fit_.add(origin_ - s.position, -s.velocity, s.force);
  if (fit_.excitation(contact_.normal) < kExcited) return;
  const LineFit::Line line = fit_.line(contact_.normal);
  if (line.explained < kExplained || !(line.slope > kSoftest) || !(line.slope < kStiffest)) return;
  // On a stiffer surface, the old position would imply a larger force, so the position changes in
  // the same sample. On a softer surface, the new position may be far away, and the first fit may
  // be wrong. So the position moves there slowly.
  const bool stiffer = line.slope > contact_.stiffness;
  contact_.stiffness = line.slope;
  const double place = height_of(s, force);
  if (!known_ && stiffer)
    place_.begin(place, place);
  else if (!known_)
    place_.relearn(place);
  known_ = learnt_ = true;
}

/// Returns the height [m] along the normal at which the surface would give this force.
double ContactEstimator::height_of(const Sample& s, double force) const noexcept {
  return s.position.dot(contact_.normal) + force / contact_.stiffness;
}

void ContactEstimator::estimate_place(const Sample& s, double force) noexcept {
  const bool unknown = !known_ && touched_ < kLearns;
  place_.step(height_of(s, force), s.elapsed, slides(s.velocity, contact_.normal) || unknown);
  contact_.velocity = place_.speed() * contact_.normal;
  contact_.point =
      s.position + (place_.place() - s.position.dot(contact_.normal)) * contact_.normal;
  last_ = contact_.point;
}

}  // namespace feltwire
