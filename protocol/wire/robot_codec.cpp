#include "protocol/wire/robot_codec.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/payload.hpp"
#include "protocol/wire/wire_values.hpp"

namespace feltwire {
namespace {

constexpr std::uint32_t kFlagDeadman = 1u << 0;
constexpr std::uint32_t kRobotTouches = 1u << 0;
constexpr std::uint32_t kFlagSensed = 1u << 0, kFlagOk = 1u << 1, kFlagStopped = 1u << 2;
constexpr double kFastest = 100.0;  // [m/s] upper limit for surfaces and robots
constexpr double kStiffest = 1e9;   // [N/m]
constexpr double kMostForce = 1e6;  // [N], [N m]
constexpr double kDeepest = 0.1f;   // [m] depth of a felt wall, rounded as float32

// All written so that NaN fails.
bool within(double value, double most) { return std::abs(value) <= most; }
bool within(const Vec3& v, double most) {
  return within(v.x(), most) && within(v.y(), most) && within(v.z(), most);
}
bool unit(const Quaternion& q) { return within(q.squaredNorm() - 1.0, kUnitTolerance); }
bool plausible(const Pose& pose) {
  return within(pose.position, kMaxPosition) && unit(pose.orientation);
}

/// Without a contact (surface 0) its numbers do not matter.
bool plausible(const RemoteContact& c) {
  if (c.surface == 0) return !c.touching;
  return within(c.point, kMaxPosition) && within(c.normal.squaredNorm() - 1.0, kUnitTolerance) &&
         within(c.velocity, kFastest) && c.stiffness > 0.0 && c.stiffness <= kStiffest &&
         c.friction >= 0.0 && within(c.friction, kMostForce);
}

bool plausible(const wire::RobotWall& w) {
  return within(value(w.normal()).squaredNorm() - 1.0, kUnitTolerance) &&
         within(w.distance(), kMaxPosition) && w.stiffness() > 0.0 && w.stiffness() <= kStiffest &&
         w.depth() > 0.0 && w.depth() <= kDeepest;
}

bool plausible(const EnergyCounters& e) {
  return e.given >= 0.0 && std::isfinite(e.given) && e.taken >= 0.0 && std::isfinite(e.taken) &&
         e.pushed >= 0.0 && std::isfinite(e.pushed);
}

wire::RobotContact wire_contact(const RemoteContact& c) {
  return {wire_double(c.point),          wire_float(c.normal),
          wire_float(c.velocity),        float32_above_zero(c.stiffness),
          float32(c.friction),           c.surface,
          c.touching ? kRobotTouches : 0};
}

RemoteContact contact_of(const wire::RobotContact& from) {
  if (from.surface() == 0) return {.touching = (from.flags() & kRobotTouches) != 0};
  return {.surface = from.surface(),
          .touching = (from.flags() & kRobotTouches) != 0,
          .point = value(from.point()),
          .normal = value(from.normal()),
          .stiffness = from.stiffness(),
          .friction = from.friction(),
          .velocity = value(from.velocity())};
}

wire::RobotEnergy wire_energy(const EnergyCounters& e) { return {e.given, e.taken, e.pushed}; }
EnergyCounters energy_of(const wire::RobotEnergy& e) { return {e.given(), e.taken(), e.pushed()}; }

constexpr std::uint32_t kOtherMeets = 1u << 8;  // bit of Remote.state
constexpr int kLeadSeat = 8, kRemoteSeat = 16;  // the first bit of each seat
std::uint8_t seat_in(std::uint32_t word, int first) {
  return static_cast<std::uint8_t>(word >> first & 0xff);
}
bool known(std::uint32_t state) { return state <= static_cast<std::uint32_t>(kLastLinkState); }

DropReason check(const RobotState& s) {
  if (s.index == 0) return DropReason::order;
  const bool good = plausible(s.pose) && plausible(s.commanded) && within(s.velocity, kFastest) &&
                    within(s.angular_velocity, kFastest) &&
                    (!s.force || within(*s.force, kMostForce)) && within(s.torque, kMostForce) &&
                    plausible(s.contact) && plausible(s.energy) && std::isfinite(s.gripper) &&
                    std::isfinite(s.gripper_force);
  return good ? DropReason::none : DropReason::not_finite;
}

}  // namespace

wire::Lead wire_lead(const Lead& lead) {
  return {wire_float(lead.offset), lead.known_surface, lead.hand_work, float32(lead.gripper),
          (lead.deadman ? kFlagDeadman : 0) | std::uint32_t{lead.seat} << kLeadSeat};
}

Lead value(const wire::Lead& from) {
  return {.deadman = (from.flags() & kFlagDeadman) != 0,
          .known_surface = from.known_surface(),
          .offset = value(from.offset()),
          .hand_work = from.hand_work(),
          .gripper = from.gripper(),
          .seat = seat_in(from.flags(), kLeadSeat)};
}

bool plausible(const Lead& lead) noexcept {
  return within(lead.offset, 2.0 * kMaxPosition) && std::isfinite(lead.hand_work) &&
         std::isfinite(lead.gripper);
}

wire::Remote wire_remote(const Remote& r) {
  return {wire_double(r.pose.position),
          wire_double(r.pose.orientation),
          wire_contact(r.contact),
          wire_energy(r.energy),
          float32(r.gripper),
          float32(r.age),
          static_cast<std::uint32_t>(r.state) | (r.meets_surfaces ? 0 : kOtherMeets) |
              std::uint32_t{r.seat} << kRemoteSeat,
          float32(r.gripper_force)};
}

bool read(const wire::Remote& from, Remote& to) noexcept {
  to.pose = {value(from.position()), value(from.orientation())};
  to.contact = contact_of(from.contact());
  to.energy = energy_of(from.energy());
  to.gripper = from.gripper();
  to.gripper_force = from.gripper_force();
  to.age = from.age();
  to.seat = seat_in(from.state(), kRemoteSeat);
  to.meets_surfaces = (from.state() & kOtherMeets) == 0;
  const std::uint32_t state = from.state() & ~(kOtherMeets | 0xffu << kRemoteSeat);
  if (!known(state)) return false;
  to.state = static_cast<LinkState>(state);
  return plausible(to.pose) && plausible(to.contact) && plausible(to.energy) &&
         std::isfinite(to.gripper) && std::isfinite(to.gripper_force) && to.age >= 0.0 &&
         std::isfinite(to.age);
}

flatbuffers::Offset<flatbuffers::Vector<const wire::RobotWall*>> build_walls(
    flatbuffers::FlatBufferBuilder& builder, const std::optional<Remote>& remote) {
  if (!remote || remote->wall_count == 0) return {};
  std::array<wire::RobotWall, kMostRemoteWalls> walls;
  const auto count = static_cast<std::size_t>(std::min(remote->wall_count, kMostRemoteWalls));
  for (std::size_t i = 0; i < count; ++i) {
    const RemoteWall& w = remote->walls[i];
    walls[i] = {w.wall.distance, wire_float(w.wall.normal), float32_above_zero(w.stiffness),
                float32_above_zero(w.depth), w.number};
  }
  return builder.CreateVectorOfStructs(walls.data(), count);
}

bool read(const flatbuffers::Vector<const wire::RobotWall*>& from, Remote& to) noexcept {
  bool good = true;
  to.wall_count = static_cast<int>(from.size());
  for (flatbuffers::uoffset_t i = 0; i < from.size(); ++i) {
    const wire::RobotWall& w = *from[i];
    to.walls[i] = {
        {value(w.normal()).normalized(), w.distance()}, w.stiffness(), w.depth(), w.wall()};
    good = good && plausible(w);
  }
  return good;
}

flatbuffers::Offset<WireSurfaces> build_others(flatbuffers::FlatBufferBuilder& builder,
                                               const OtherSurfaces& others) {
  if (others.count == 0) return {};
  std::array<wire::RobotContact, OtherSurfaces::kMost> surfaces;
  const auto told = others.view();
  std::ranges::transform(told, surfaces.begin(), wire_contact);
  return builder.CreateVectorOfStructs(surfaces.data(), told.size());
}

DropReason read(const WireSurfaces* from, OtherSurfaces& to) noexcept {
  to = {};
  if (from == nullptr) return DropReason::none;
  if (!aligned(*from, alignof(wire::RobotContact))) return DropReason::malformed;
  if (from->size() > OtherSurfaces::kMost) return DropReason::count;
  bool good = true;
  for (const wire::RobotContact* surface : *from) {
    const RemoteContact& other = to.surfaces[static_cast<std::size_t>(to.count++)] =
        contact_of(*surface);
    good = good && other.surface != 0 && !other.touching && plausible(other);
  }
  return good ? DropReason::none : DropReason::not_finite;
}

bool read(const wire::Vec3f& turn, Remote& to) noexcept {
  constexpr double kMost = 3.1416;  // [rad] just above pi
  to.turn = value(turn);
  return within(to.turn->norm(), kMost);
}

flatbuffers::Offset<wire::FollowerState> build(flatbuffers::FlatBufferBuilder& builder,
                                               const RobotState& s) {
  const std::uint32_t flags =
      (s.force ? kFlagSensed : 0) | (s.ok ? kFlagOk : 0) | (s.stopped ? kFlagStopped : 0);
  const wire::RobotState state(
      s.index, s.time.count(), wire_double(s.pose.position), wire_double(s.pose.orientation),
      wire_double(s.commanded.position), wire_double(s.commanded.orientation),
      wire_float(s.velocity), wire_float(s.angular_velocity),
      wire_float(s.force.value_or(Vec3::Zero())), wire_float(s.torque), wire_contact(s.contact),
      wire_energy(s.energy), float32(s.gripper), float32(s.gripper_force), flags, 0);
  const auto others = build_others(builder, s.others);
  return wire::CreateFollowerState(builder, &state, others);
}

flatbuffers::Offset<wire::FollowerTarget> build(flatbuffers::FlatBufferBuilder& builder,
                                                const RobotTarget& t) {
  const wire::RobotTarget target(t.index, t.sample_index, wire_double(t.pose.position),
                                 wire_double(t.pose.orientation), t.hand_work, t.known_surface,
                                 float32(t.gripper), static_cast<std::uint32_t>(t.state), 0);
  return wire::CreateFollowerTarget(builder, &target);
}

DropReason decode(Bytes payload, RobotState& out) noexcept {
  const Aligned bytes(payload);
  const auto* root = bytes.root<wire::FollowerState>();
  if (root == nullptr) return DropReason::malformed;
  const wire::RobotState& from = *root->state();
  out = {.index = from.index(),
         .time = Nanoseconds(from.time()),
         .pose = {value(from.position()), value(from.orientation())},
         .commanded = {value(from.commanded()), value(from.commanded_turn())},
         .velocity = value(from.velocity()),
         .angular_velocity = value(from.angular_velocity()),
         .force = std::nullopt,
         .torque = value(from.torque()),
         .contact = contact_of(from.contact()),
         .others = {},
         .energy = energy_of(from.energy()),
         .gripper = from.gripper(),
         .gripper_force = from.gripper_force(),
         .ok = (from.flags() & kFlagOk) != 0,
         .stopped = (from.flags() & kFlagStopped) != 0};
  if ((from.flags() & kFlagSensed) != 0) out.force = value(from.force());
  const DropReason others = read(root->others(), out.others);
  if (others == DropReason::malformed || others == DropReason::count) return others;
  const DropReason rest = check(out);
  return rest != DropReason::none ? rest : others;
}

DropReason decode(Bytes payload, RobotTarget& out) noexcept {
  const Aligned bytes(payload);
  const auto* root = bytes.root<wire::FollowerTarget>();
  if (root == nullptr) return DropReason::malformed;
  const wire::RobotTarget& from = *root->target();
  if (!known(from.state())) return DropReason::malformed;
  out = {.index = from.index(),
         .sample_index = from.sample_index(),
         .state = static_cast<LinkState>(from.state()),
         .pose = {value(from.position()), value(from.orientation())},
         .gripper = from.gripper(),
         .known_surface = from.known_surface(),
         .hand_work = from.hand_work()};
  if (out.index == 0) return DropReason::order;
  const bool good =
      plausible(out.pose) && std::isfinite(out.gripper) && std::isfinite(out.hand_work);
  return good ? DropReason::none : DropReason::not_finite;
}

}  // namespace feltwire
