#include "protocol/wire/parameters_codec.hpp"

#include <cmath>
#include <vector>

#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/control_values.hpp"

namespace feltwire::control {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

/// Writes a damping: no numbers if it is isotropic, 3 numbers for damping along the axes, and 6
/// numbers for a matrix.
Offset<flatbuffers::Vector<double>> tensor(FlatBufferBuilder& builder, const Damping& damping) {
  if (damping.isotropic()) return 0;
  const Mat3& m = damping.matrix();
  std::vector<double> entries{m(0, 0), m(1, 1), m(2, 2)};
  if (damping.kind() == Damping::Kind::matrix)
    entries.insert(entries.end(), {m(0, 1), m(0, 2), m(1, 2)});
  return builder.CreateVector(entries);
}

bool read_damping(double isotropic, const flatbuffers::Vector<double>* entries, Damping& to) {
  constexpr flatbuffers::uoffset_t kAxes = 3, kMatrix = 6;
  if (entries != nullptr && !aligned(*entries, alignof(double))) return false;
  if (entries == nullptr) {
    to = isotropic;
  } else if (entries->size() == kAxes) {
    to = Vec3((*entries)[0], (*entries)[1], (*entries)[2]);
  } else if (entries->size() == kMatrix) {
    const auto& e = *entries;
    to = Mat3{{e[0], e[3], e[4]}, {e[3], e[1], e[5]}, {e[4], e[5], e[2]}};
  } else {
    return false;
  }
  return true;
}

/// Reads a list of bodies. An absent list means no bodies.
bool read_bodies(const flatbuffers::Vector<const wire::KeepOutBody*>* from, Workspace& to) {
  if (from == nullptr) return true;
  if (!aligned(*from, alignof(wire::KeepOutBody)) || from->size() > Workspace::kMostBodiesGiven)
    return false;
  for (const wire::KeepOutBody* sent : *from) {
    KeepOutBody body{{vector(sent->position()), turn(sent->orientation())},
                     vector(sent->half()),
                     sent->radius()};
    if (!body.valid(Workspace::kFarthest)) return false;
    body.pose.orientation.normalize();
    to.add_body(body);
  }
  return true;
}

}  // namespace

Offset<wire::DeviceSpec> build(FlatBufferBuilder& builder, const DeviceSpec& d) {
  const wire::Vector workspace = wire_vector(d.workspace);
  const auto damping = tensor(builder, d.damping);
  const auto rotational_damping = tensor(builder, d.rotational_damping);
  const auto name = builder.CreateString(d.name);
  // A peer that does not support the matrix uses the smallest damping over all directions.
  return wire::CreateDeviceSpec(builder, name, static_cast<std::uint8_t>(d.translation_dof),
                                static_cast<std::uint8_t>(d.rotation_sensed),
                                static_cast<std::uint8_t>(d.rotation_actuated), d.damping.least(),
                                d.rotational_damping.least(), d.apparent_mass, d.coulomb_friction,
                                d.position_resolution, d.max_force, d.continuous_force,
                                d.max_torque, &workspace, damping, rotational_damping);
}

Offset<wire::SessionParameters> build(FlatBufferBuilder& builder, const SessionParameters& p) {
  return wire::CreateSessionParameters(
      builder, builder.CreateString(p.mode), wire_enum<wire::Projection>(p.projection),
      wire_enum<wire::Storage>(p.storage), wire_enum<wire::BoundingSide>(p.side), p.servo_period,
      static_cast<std::uint8_t>(p.redundancy), p.operator_damping, p.velocity_cutoff, p.hold_time,
      p.c1.value_or(kNotGiven), p.c2.value_or(kNotGiven),
      wire_enum<wire::PassivityReference>(p.reference), p.coupling_stiffness.value_or(kNotGiven),
      p.coupling_damping.value_or(kNotGiven), p.tool_mass,
      static_cast<std::uint16_t>(p.packet_interval), static_cast<std::uint8_t>(p.batch),
      p.position_deadband, p.force_deadband, wire_enum<wire::Predictor>(p.predictor), p.keep_alive,
      p.local_model);
}

Offset<wire::Workspace> build(FlatBufferBuilder& builder, const Workspace& w) {
  if (!w.limits()) return 0;
  std::vector<wire::Wall> walls;
  for (const WorkspaceWall& wall : w.view())
    walls.emplace_back(wire_vector(wall.normal), wall.distance);
  std::vector<wire::KeepOutBody> bodies;
  for (const KeepOutBody& body : w.keep_out()) {
    bodies.emplace_back(wire_vector(body.pose.position), wire_turn(body.pose.orientation),
                        wire_vector(body.half), body.radius);
  }
  constexpr unsigned kTurning = 1u << 3;
  unsigned locked = w.turning_locked ? kTurning : 0;
  for (std::size_t axis = 0; axis < w.locked.size(); ++axis)
    if (w.locked[axis]) locked |= 1u << axis;
  return wire::CreateWorkspace(builder, builder.CreateVectorOfStructs(walls),
                               static_cast<std::uint8_t>(locked),
                               bodies.empty() ? 0 : builder.CreateVectorOfStructs(bodies));
}

bool read(const wire::DeviceSpec& from, DeviceSpec& to) {
  to.translation_dof = from.translation_dof();
  to.rotation_sensed = from.rotation_sensed();
  to.rotation_actuated = from.rotation_actuated();
  to.apparent_mass = from.apparent_mass();
  to.coulomb_friction = from.coulomb_friction();
  to.position_resolution = from.position_resolution();
  to.max_force = from.max_force();
  to.continuous_force = from.continuous_force();
  to.max_torque = from.max_torque();
  if (const auto* extent = from.workspace()) to.workspace = vector(*extent);
  return read_name(from.name(), to.name) &&
         read_damping(from.damping(), from.damping_tensor(), to.damping) &&
         read_damping(from.rotational_damping(), from.rotational_damping_tensor(),
                      to.rotational_damping);
}

bool read(const wire::SessionParameters& from, SessionParameters& to) {
  to.servo_period = from.servo_period();
  to.redundancy = from.redundancy();
  to.operator_damping = from.operator_damping();
  to.velocity_cutoff = from.velocity_cutoff();
  to.hold_time = from.hold_time();
  if (!std::isnan(from.c1())) to.c1 = from.c1();
  if (!std::isnan(from.c2())) to.c2 = from.c2();
  if (!std::isnan(from.coupling_stiffness())) to.coupling_stiffness = from.coupling_stiffness();
  if (!std::isnan(from.coupling_damping())) to.coupling_damping = from.coupling_damping();
  to.tool_mass = from.tool_mass();
  to.packet_interval = from.packet_interval();
  to.batch = from.batch();
  to.position_deadband = from.position_deadband();
  to.force_deadband = from.force_deadband();
  to.keep_alive = from.keep_alive();
  to.local_model = from.local_model();
  return read_enum(from.reference(), to.reference) &&
         read_name(from.mode(), to.mode, kLongestMethodName) &&
         read_enum(from.projection(), to.projection) && read_enum(from.storage(), to.storage) &&
         read_enum(from.side(), to.side) && read_enum(from.predictor(), to.predictor);
}

bool read(const wire::Workspace* from, Workspace& to) {
  if (from == nullptr) return true;
  constexpr unsigned kTurning = 1u << 3;
  to = {};
  if (from->locked() >= 2 * kTurning) return false;
  for (std::size_t axis = 0; axis < to.locked.size(); ++axis)
    to.locked[axis] = (from->locked() & 1u << axis) != 0;
  to.turning_locked = (from->locked() & kTurning) != 0;
  if (!read_bodies(from->keep_out(), to)) return false;
  const auto* walls = from->walls();
  if (walls == nullptr) return true;
  if (!aligned(*walls, alignof(wire::Wall)) || walls->size() > Workspace::kMostGiven) return false;
  for (const wire::Wall* wall : *walls) {
    const Vec3 normal = vector(wall->normal());
    // The negated comparisons also refuse NaN.
    if (!(std::abs(normal.squaredNorm() - 1.0) <= kUnitTolerance) ||
        !(std::abs(wall->distance()) <= Workspace::kFarthest))
      return false;
    to.add({normal.normalized(), wall->distance()});
  }
  return true;
}

}  // namespace feltwire::control
