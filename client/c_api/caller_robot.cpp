#include "client/c_api/caller_robot.hpp"

#include <cmath>
#include <span>
#include <stdexcept>

#include "client/c_api/c_values.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {
namespace {

constexpr double kLargest = 1e6;  // a larger number is invalid, as in the lines of a driver
constexpr std::uint32_t kWell = 0, kStopped = 1, kFaulty = 2;

void require_state(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(std::string("robot_state.") + what);
}

bool are_numbers(std::span<const double> values) {
  for (const double value : values)
    if (!(std::abs(value) <= kLargest)) return false;
  return true;
}

bool is_place(const double (&position)[3]) {
  for (const double value : position)
    if (!(std::abs(value) <= kMaxPosition)) return false;
  return true;
}

bool is_unit_turn(const double (&q)[4]) {
  return std::abs(quaternion(q).squaredNorm() - 1.0) <= kUnitTolerance;
}

FollowerReading reading_of(const fw_robot_state& state) {
  FollowerReading reading;
  reading.pose = {vector(state.position), quaternion(state.orientation).normalized()};
  reading.velocity = vector(state.velocity);
  reading.angular_velocity = vector(state.turning);
  if (state.has_force != 0) reading.force = vector(state.force);
  reading.torque = vector(state.torque);
  reading.commanded = {vector(state.commanded_position),
                       quaternion(state.commanded_orientation).normalized()};
  reading.gripper = state.gripper;
  reading.gripper_force = state.gripper_force;
  reading.ok = state.condition != kFaulty;
  reading.stopped = state.condition == kStopped;
  return reading;
}

}  // namespace

void CallerRobot::report(const fw_robot_state& state, Nanoseconds now) {
  require_state(is_place(state.position), "position is not three numbers within 1000 m");
  require_state(is_place(state.commanded_position),
                "commanded_position is not three numbers within 1000 m");
  require_state(is_unit_turn(state.orientation), "orientation is no unit quaternion w, x, y, z");
  require_state(is_unit_turn(state.commanded_orientation),
                "commanded_orientation is no unit quaternion w, x, y, z");
  require_state(are_numbers(state.velocity) && are_numbers(state.turning),
                "velocity or turning is not three numbers below 1e6");
  require_state(state.has_force == 0 || are_numbers(state.force),
                "force is not three numbers below 1e6");
  require_state(are_numbers(state.torque), "torque is not three numbers below 1e6");
  require_state(state.gripper >= 0.0 && state.gripper <= kLargest, "gripper must be 0 or more [m]");
  require_state(std::abs(state.gripper_force) <= kLargest,
                "gripper_force is not a number below 1e6");
  require_state(
      state.condition == kWell || state.condition == kStopped || state.condition == kFaulty,
      "condition must be 0 (well), 1 (stopped) or 2 (fault)");
  reports_.put({state, now.count()});
}

FollowerReading CallerRobot::read(Nanoseconds now) noexcept {
  Report newest{};
  if (const std::uint64_t number = reports_.get(newest); number != reports_read_) {
    reports_read_ = number;
    robot_.report(reading_of(newest.state), Nanoseconds(newest.clock));
  }
  return robot_.read(now, true);
}

FollowerTarget CallerRobot::write(const FollowerTarget& target) noexcept {
  FollowerTarget held = robot_.write(target, held_.load());
  gripper_ = held.gripper;
  return held;
}

void CallerRobot::publish(const RobotState& said, const RobotTarget& newest,
                          bool connected) noexcept {
  if (newest.index != newest_command_) {
    newest_command_ = newest.index;
    commanded_at_ = newest.index != 0 ? said.time.count() : 0;
  }
  if (!robot_.has_reported()) return;
  Target next{};
  next.target.number = said.index;
  next.target.sample = newest.sample_index;
  put(said.commanded, next.target.position, next.target.orientation);
  next.target.gripper = gripper_;
  next.target.state = static_cast<std::uint32_t>(newest.state);
  next.target.connected = connected ? 1 : 0;
  next.commanded_at = commanded_at_;
  targets_.put(next);
}

bool CallerRobot::latest(fw_robot_target& target, Nanoseconds now) const noexcept {
  Target newest{};
  if (targets_.get(newest) == 0) return false;
  target = newest.target;
  target.age = newest.commanded_at != 0 ? seconds(now - Nanoseconds(newest.commanded_at)) : -1.0;
  return true;
}

}  // namespace feltwire
