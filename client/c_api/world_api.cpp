// The functions of feltwire.h for a hand whose surroundings the program computes.

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#include "client/c_api/c_call.hpp"
#include "client/c_api/c_values.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/hand_opening.hpp"
#include "core/local_model/local_model.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {
namespace {

constexpr double kLongestReach = 1.0;  // [m]
constexpr double kFarthest = 1e3;      // [m]
constexpr double kMostFriction = 1e3;
constexpr double kMostForce = 1e4;  // [N], [N m]
constexpr double kUnitError = 1e-3;
constexpr double kAcross = 1e-2;   // largest cosine of an axis and a normal
constexpr double kSharpest = 1e6;  // [1/m]
constexpr double kSoftest = 1e-3;  // [N/m]

fw_world_options usual_world() noexcept {
  fw_world_options options{};
  options.struct_size = sizeof options;
  options.name = "libfeltwire";
  options.device = "simulated";
  options.stale_after = 0.02;
  options.start_normal[2] = 1.0;
  return options;
}

fw_patch usual_patch() noexcept {
  fw_patch patch{};
  patch.struct_size = sizeof patch;
  patch.normal[2] = 1.0;
  patch.stiffness = 1000.0;
  return patch;
}

fw_wrench usual_wrench() noexcept {
  fw_wrench wrench{};
  wrench.struct_size = sizeof wrench;
  return wrench;
}

/// A text is made only where something is wrong: these functions allocate nothing else.
void require_call(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}
/// Does so for a field of a struct. `name`: of the struct.
void require_part(bool holds, const std::string& name, const char* what) {
  if (!holds) throw std::invalid_argument(name + "." + what);
}

bool is_unit(const Vec3& v) { return std::abs(v.norm() - 1.0) < kUnitError; }
bool is_within(double value, double least, double most) { return value >= least && value <= most; }

/// Returns the patch with numbers that the hand's side takes as they are. Throws
/// std::invalid_argument that names the field.
SurfacePatch to_patch(const fw_patch& from, double reach, const std::string& name) {
  SurfacePatch to;
  to.point = vector(from.point);
  to.normal = vector(from.normal);
  to.axis = vector(from.axis);
  to.velocity = vector(from.velocity);
  to.curvature = from.curvature;
  to.radius = from.radius == 0.0 ? reach : from.radius;
  to.material = {from.stiffness, from.damping, from.static_friction, from.dynamic_friction,
                 from.viscous_friction};
  to.object = static_cast<std::uint16_t>(from.object);
  require_part(to.point.norm() < kFarthest, name,
               "point is not a number, or farther than 1 km away");
  require_part(is_unit(to.normal), name, "normal is no unit vector");
  to.normal.normalize();
  if (!to.axis.isZero(0.0)) {
    require_part(is_unit(to.axis), name, "axis is neither zero nor a unit vector");
    to.axis.normalize();
    require_part(std::abs(to.axis.dot(to.normal)) < kAcross, name, "axis is not across the normal");
  }
  require_part(to.velocity.norm() < kFarthest, name, "velocity is not a number, or above 1 km/s");
  require_part(std::abs(to.curvature) <= kSharpest, name, "curvature must be -1e6 to 1e6 1/m");
  require_part(is_within(to.radius, 0.0, kFarthest), name, "radius must be 0 to 1000 m");
  require_part(is_within(to.material.stiffness, kSoftest, kStiffest), name,
               "stiffness must be 1e-3 to 1e9 N/m");
  require_part(is_within(to.material.damping, 0.0, kStiffest), name, "damping must be 0 or more");
  require_part(is_within(to.material.dynamic_friction, 0.0, to.material.static_friction) &&
                   to.material.static_friction <= kMostFriction,
               name, "dynamic_friction must be 0 to static_friction");
  require_part(is_within(to.material.viscous_friction, 0.0, kStiffest), name,
               "viscous_friction must be 0 or more");
  require_part(from.object <= 0xFFFF, name, "object must be below 65536");
  to.anchor = to.point;
  return to;
}

/// Throws std::invalid_argument if the hand has no simulator.
OpenHand& with_simulator(fw_hand* hand) {
  require_call(hand->object->meets_simulator(),
               "the hand is in a scene of a server: open it by fw_hand_open_world()");
  return *hand->object;
}

/// Throws std::invalid_argument if a surface is stiffer than the hand was opened for: its bounding
/// reckons with that stiffness.
void require_stated(const OpenHand& hand, double stiffness, const std::string& name) {
  const double stated = hand.accepted().stiffness;
  if (stiffness <= stated) return;
  throw std::invalid_argument(name + ".stiffness is " + std::to_string(std::lround(stiffness)) +
                              " N/m, above the stiffness of the world, " +
                              std::to_string(std::lround(stated)) +
                              " N/m; open the hand with that of the stiffest surface");
}

std::int32_t give(OpenHand& hand, const SimulatorContact& contact, double time) {
  require_call(time >= 0.0,
               "time must be fw_tick.time of the pose that the physics used, 0 or more");
  if (hand.over().is_set()) return FW_ENDED;
  return hand.touch(contact, time) ? FW_OK : FW_NOTHING;
}

}  // namespace
}  // namespace feltwire

using namespace feltwire;

void fw_world_options_default(fw_world_options* options, std::uint32_t struct_size) {
  if (options != nullptr) write_struct(usual_world(), options, struct_size);
}

void fw_patch_default(fw_patch* patch, std::uint32_t struct_size) {
  if (patch != nullptr) write_struct(usual_patch(), patch, struct_size);
}

void fw_wrench_default(fw_wrench* wrench, std::uint32_t struct_size) {
  if (wrench != nullptr) write_struct(usual_wrench(), wrench, struct_size);
}

std::int32_t fw_hand_open_world(const fw_world_options* options, fw_hand** hand) {
  return open_handle(hand, "hand", [&] {
    const fw_world_options given = read_struct(options, usual_world(), "world_options");
    require_call(vector(given.start_position).norm() < kFarthest,
                 "world_options.start_position is not a number, or farther than 1 km away");
    const SimulatorScene scene{.stiffness = given.stiffness,
                               .start_position = vector(given.start_position),
                               .start_normal = vector(given.start_normal)};
    return open_hand(HandRequest("world_options", {}, given), &scene);
  });
}

std::int32_t fw_hand_touch(fw_hand* hand, double time, double reach, const fw_patch* patches,
                           std::uint32_t struct_size, std::uint32_t count) {
  if (!is_open(hand)) return not_open("hand");
  return guarded([&] {
    OpenHand& open = with_simulator(hand);
    require_call(reach > 0.0 && reach <= kLongestReach, "reach must be above 0 and at most 1 m");
    require_call(count <= kMaxPatches,
                 "count must be at most 3: give the nearest patches, and a shorter reach");
    require_call(count == 0 || (patches != nullptr && is_size(struct_size)),
                 "patches is null, or struct_size is not the size of one");
    SimulatorContact contact;
    contact.modelled = true;
    contact.model.reach = reach;
    contact.model.count = static_cast<int>(count);
    const auto* at = reinterpret_cast<const unsigned char*>(patches);
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::string name = "patches[" + std::to_string(i) + "]";
      const fw_patch given =
          read_fields(at + std::size_t{i} * struct_size, struct_size, usual_patch(), name);
      contact.model.patches[i] = to_patch(given, reach, name);
      require_stated(open, given.stiffness, name);
    }
    return give(open, contact, time);
  });
}

std::int32_t fw_hand_push(fw_hand* hand, const fw_wrench* wrench) {
  if (!is_open(hand)) return not_open("hand");
  return guarded([&] {
    OpenHand& open = with_simulator(hand);
    const fw_wrench given = read_struct(wrench, usual_wrench(), "wrench");
    SimulatorContact contact;
    contact.command.elastic = vector(given.force);
    contact.command.torque = vector(given.torque);
    contact.stiffness = given.stiffness;
    require_call(contact.command.elastic.norm() < kMostForce,
                 "wrench.force is not a number, or above 10 kN");
    require_call(contact.command.torque.norm() < kMostForce,
                 "wrench.torque is not a number, or above 10 kN m");
    require_call(given.stiffness == 0.0 || is_within(given.stiffness, kSoftest, kStiffest),
                 "wrench.stiffness must be 0, or 1e-3 to 1e9 N/m");
    require_stated(open, given.stiffness, "wrench");
    return give(open, contact, given.time);
  });
}
