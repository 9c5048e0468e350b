#include "client/servo/device_input.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

bool good(const DeviceReading& reading) {
  const Quaternion& q = reading.pose.orientation;
  return reading.ok && reading.fresh && !reading.clutched &&
         reading.withheld == Withheld::nothing && (!reading.held || reading.held->finite()) &&
         reading.pose.position.allFinite() && q.coeffs().allFinite() && q.squaredNorm() > 0.0;
}

/// Returns whether the pose is valid although the device gives no force.
bool only_shown(const DeviceReading& reading) {
  if (reading.withheld == Withheld::nothing || reading.withheld == Withheld::not_homed)
    return false;
  DeviceReading shown = reading;
  shown.withheld = Withheld::nothing;
  return good(shown);
}

/// Returns whether the device reports why it gives no force.
bool explained(const DeviceReading& reading) {
  return reading.ok && (reading.clutched || reading.withheld != Withheld::nothing);
}

}  // namespace

bool DeviceInput::waits(const DeviceReading& reading, double since, double patience,
                        DeviceCounts& counts) const noexcept {
  if (reading.fresh || !reading.ok || reading.ended || !position_known_) return false;
  ++counts.stale_readings;
  return since < patience;
}

DeviceMovement DeviceInput::take(const DeviceReading& reading, double elapsed,
                                 DeviceCounts& counts) noexcept {
  ended_ = ended_ || reading.ended;
  DeviceMovement movement;
  movement.jumped = good(reading) && jumps(reading, elapsed);
  movement.read = good(reading) && !movement.jumped;
  if (movement.read) {
    move_to(reading, movement);
    no_position_for_ = 0.0;
    return movement;
  }
  movement.fault = !ended_ && !explained(reading);
  if (movement.fault) {
    ++counts.faults;
    no_position_for_ += elapsed;
  }
  counts.jumps += movement.jumped ? 1 : 0;
  if (only_shown(reading)) {
    DeviceMovement shown;
    move_to(reading, shown);
  }
  position_known_ = false;
  return movement;
}

/// Returns whether the position jumped farther than a hand can move between two readings. The test
/// tolerates irregular ticks: a short tick may show the movement of a whole period.
bool DeviceInput::jumps(const DeviceReading& reading, double elapsed) noexcept {
  if (reading.jumped) return *reading.jumped;
  if (!position_known_) {
    moves_.forget();
    turns_.forget();
    return false;
  }
  const double time = std::max(elapsed, period_);
  const bool moved = moves_.made(reading.pose.position - pose_.position, time);
  if (!senses_rotation_) return !moved;
  const Quaternion now = reading.pose.orientation.normalized();
  return !turns_.made(rotation_between(pose_.orientation, now), time) || !moved;
}

/// Sets the movement since the last tick. The movement across a fault is unknown, so the force
/// bound gets no movement. The bound has reserved the energy that the held force can release during
/// the fault (docs/bounding.md). The force is zero after the fault.
void DeviceInput::move_to(const DeviceReading& reading, DeviceMovement& movement) noexcept {
  movement.known = position_known_;
  if (position_known_) {
    movement.displacement = reading.pose.position - pose_.position;
    if (rotation_)
      movement.rotation = rotation_between(pose_.orientation, reading.pose.orientation);
  }
  pose_ = reading.pose;
  pose_.orientation.normalize();
  position_known_ = posed_ = true;
}

}  // namespace feltwire
