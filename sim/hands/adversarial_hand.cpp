#include "sim/hands/adversarial_hand.hpp"

namespace feltwire {
namespace {

constexpr double kGone = 1e-6;  // [N] smaller forces count as zero

}  // namespace

/// Moves the hand by at most `step` [m] towards `goal`. Returns true if it is then at `goal`.
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
  reading.jumped = false;  // this hand may move fast, but its position is exact
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
