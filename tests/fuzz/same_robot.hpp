#pragma once
// Compares a robot's data in two datagrams to the bit.

#include <algorithm>

#include "core/teleoperation/robot.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {

inline bool same(const EnergyCounters& a, const EnergyCounters& b) {
  return same(a.given, b.given) && same(a.taken, b.taken) && same(a.pushed, b.pushed);
}
inline bool same(const RemoteContact& a, const RemoteContact& b) {
  return a.surface == b.surface && a.touching == b.touching && same(a.point, b.point) &&
         same(a.normal, b.normal) && same(a.stiffness, b.stiffness) &&
         same(a.friction, b.friction) && same(a.velocity, b.velocity);
}
inline bool same(const OtherSurfaces& a, const OtherSurfaces& b) {
  return std::ranges::equal(a.view(), b.view(), [](const RemoteContact& x, const RemoteContact& y) {
    return same(x, y);
  });
}
inline bool same_pose(const Pose& a, const Pose& b) {
  return same(a.position, b.position) && same(a.orientation, b.orientation);
}
inline bool same(const Lead& a, const Lead& b) {
  return a.deadman == b.deadman && a.known_surface == b.known_surface && same(a.offset, b.offset) &&
         same(a.hand_work, b.hand_work) && same(a.gripper, b.gripper) && a.seat == b.seat;
}
inline bool same(const Remote& a, const Remote& b) {
  return a.state == b.state && a.seat == b.seat && same_pose(a.pose, b.pose) &&
         same(a.contact, b.contact) && same(a.others, b.others) && same(a.energy, b.energy) &&
         same(a.gripper, b.gripper) && same(a.gripper_force, b.gripper_force) &&
         same(a.age, b.age) && a.meets_surfaces == b.meets_surfaces;
}
inline bool same(const RobotState& a, const RobotState& b) {
  return a.index == b.index && a.time == b.time && same_pose(a.pose, b.pose) &&
         same_pose(a.commanded, b.commanded) && same(a.velocity, b.velocity) &&
         same(a.angular_velocity, b.angular_velocity) &&
         a.force.has_value() == b.force.has_value() && (!a.force || same(*a.force, *b.force)) &&
         same(a.torque, b.torque) && same(a.contact, b.contact) && same(a.others, b.others) &&
         same(a.energy, b.energy) && same(a.gripper, b.gripper) &&
         same(a.gripper_force, b.gripper_force) && a.ok == b.ok && a.stopped == b.stopped;
}
inline bool same(const RobotTarget& a, const RobotTarget& b) {
  return a.index == b.index && a.sample_index == b.sample_index && a.state == b.state &&
         same_pose(a.pose, b.pose) && same(a.gripper, b.gripper) &&
         a.known_surface == b.known_surface && same(a.hand_work, b.hand_work);
}
template <class Said>
bool same(const std::optional<Said>& a, const std::optional<Said>& b) {
  return a.has_value() == b.has_value() && (!a || same(*a, *b));
}

}  // namespace feltwire::fuzz
