#include "sim/hands/adversarial_hand.hpp"

namespace feltwire {
namespace {

constexpr double kGone = 1e-6;  // [N] a smaller force counts as zero

}  // namespace

/// Makes a step of at most `step` [m]. Returns true at the goal.
bool AdversarialHand::go_to(const Vec3& goal, double step) noexcept {
  const Vec3 way = goal - position_;
  const double length = way.norm();
  if (length <= step) {
    position_ = goal;
    return true;
  }
  position_ += step / length * way;
  return false;
}

DeviceReading AdversarialHand::read(Nanoseconds now) noexcept {
  const double hold = started_ ? std::chrono::duration<double>(now - last_).count() : 0.0;
  started_ = true;
  last_ = now;
  switch (phase_) {
    case Phase::in:
      if (go_to(task_.start + task_.depth * task_.inward, task_.speed * hold))
        phase_ = Phase::taking;
      break;
    case Phase::taking:
      position_ += 0.5 * hold * spec_.damping.matrix().inverse() * force_;
      if (force_.norm() < kGone) phase_ = Phase::back;
      break;
    case Phase::back:
      if (go_to(task_.start, task_.speed * hold)) phase_ = Phase::in;
      break;
  }
  DeviceReading reading;
  reading.pose.position = position_;
  reading.jumped = false;  // this test hand may be faster than any real hand
  return reading;
}

Command AdversarialHand::write(const Command& on_hand) noexcept {
  Command held = actuated(spec_, on_hand);
  if (released_.load() || !held.finite()) held = {};
  const double magnitude = held.force().norm();
  if (magnitude > spec_.max_force) {
    held.elastic *= spec_.max_force / magnitude;
    held.frictional *= spec_.max_force / magnitude;
  }
  force_ = held.force();
  return held;
}

}  // namespace feltwire
