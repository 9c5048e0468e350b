#include "protocol/wire/control.hpp"

#include <sodium.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/base/little_endian.hpp"
#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/control_generated.h"

namespace feltwire::control {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

constexpr flatbuffers::uoffset_t kMaxDepth = 8;
// Tables of one message. Each entry of a list may point at the same bytes, so this also limits what
// a hostile frame can make grow.
constexpr flatbuffers::uoffset_t kMaxTables = kMaxScenes + 8;
constexpr std::size_t kSmallestBuffer = 8;  // [bytes] a root offset and an empty table

constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

// The values' enums are the wire's: same order, checked when read.
template <class Wire, class Enum>
Wire wire_enum(Enum value) {
  return static_cast<Wire>(value);
}

/// False when there is no such enumerator.
template <class Enum, class Wire>
bool read_enum(Wire wire, Enum& out) {
  if (wire > Wire::MAX) return false;
  out = static_cast<Enum>(wire);
  return true;
}

/// One that may be left out stays what it was where it is not there.
bool read_name(const flatbuffers::String* text, std::string& out, std::size_t longest = kMaxName) {
  if (text == nullptr) return true;
  if (text->size() > longest) return false;
  out.assign(text->c_str(), text->size());
  return true;
}

Offset<flatbuffers::String> name_if_any(FlatBufferBuilder& builder, const std::string& text) {
  return text.empty() ? 0 : builder.CreateString(text);
}

wire::Vector vector(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
Vec3 vector(const wire::Vector& v) { return {v.x(), v.y(), v.z()}; }

/// Nothing for an isotropic damping, 3 numbers along the axes, 6 for a matrix.
Offset<flatbuffers::Vector<double>> tensor(FlatBufferBuilder& builder, const Damping& damping) {
  if (damping.isotropic()) return 0;
  const Mat3& m = damping.matrix();
  std::vector<double> entries{m(0, 0), m(1, 1), m(2, 2)};
  if (damping.kind() == Damping::Kind::matrix)
    entries.insert(entries.end(), {m(0, 1), m(0, 2), m(1, 2)});
  return builder.CreateVector(entries);
}

bool read(double isotropic, const flatbuffers::Vector<double>* entries, Damping& to) {
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

Offset<wire::DeviceSpec> build(FlatBufferBuilder& builder, const DeviceSpec& d) {
  const wire::Vector workspace = vector(d.workspace);
  const auto damping = tensor(builder, d.damping);
  const auto rotational_damping = tensor(builder, d.rotational_damping);
  const auto name = builder.CreateString(d.name);
  // A peer that does not know the tensor uses the smallest damping of all directions.
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

/// The union's member of each message.
struct BodyBuilder {
  FlatBufferBuilder& builder;

  Offset<wire::JoinRequest> operator()(const JoinRequest& m) {
    const auto device = build(builder, m.device);
    const auto parameters = build(builder, m.parameters);
    // By length, here and below: a name may hold a zero byte, and is then no shorter.
    const auto client = builder.CreateString(m.client), scene = builder.CreateString(m.scene);
    const auto tool = name_if_any(builder, m.tool), version = name_if_any(builder, m.version);
    return wire::CreateJoinRequest(builder, client, scene, device, parameters,
                                   wire_enum<wire::Role>(m.role), m.aes_256_gcm, tool, version);
  }
  Offset<wire::JoinAccepted> operator()(const JoinAccepted& m) {
    const wire::Vector position = vector(m.start_position), normal = vector(m.start_normal);
    const auto parameters = build(builder, m.parameters);
    const auto tool = name_if_any(builder, m.tool), version = name_if_any(builder, m.version);
    return wire::CreateJoinAccepted(
        builder, m.session, m.port_offset, parameters, m.silence_timeout, m.friction, m.rotation,
        &position, &normal, m.stiffness, wire_enum<wire::CipherSuite>(m.suite), tool, version);
  }
  Offset<wire::LeaveRequest> operator()(const LeaveRequest& m) {
    return wire::CreateLeaveRequest(builder, m.session);
  }
  Offset<wire::Left> operator()(const Left& m) { return wire::CreateLeft(builder, m.session); }
  Offset<wire::ListScenes> operator()(const ListScenes&) { return wire::CreateListScenes(builder); }
  Offset<wire::SceneList> operator()(const SceneList& m) {
    std::vector<Offset<wire::SceneEntry>> entries;
    for (const SceneEntry& scene : m.scenes)
      entries.push_back(wire::CreateSceneEntry(builder, builder.CreateString(scene.name),
                                               scene.port_offset, scene.objects, scene.sessions));
    return wire::CreateSceneList(builder, builder.CreateVector(entries));
  }
  Offset<wire::SetParameters> operator()(const SetParameters& m) {
    return wire::CreateSetParameters(builder, m.session, build(builder, m.parameters));
  }
  Offset<wire::ParametersSet> operator()(const ParametersSet& m) {
    return wire::CreateParametersSet(builder, m.session, build(builder, m.parameters));
  }
  Offset<wire::Refused> operator()(const Refused& m) {
    return wire::CreateRefused(builder, wire_enum<wire::RefusalCode>(m.code),
                               builder.CreateString(shortened(m.reason, kMaxReason)));
  }
  Offset<wire::Authenticate> operator()(const Authenticate& m) {
    const std::string_view token = m.token.text();
    return wire::CreateAuthenticate(builder, builder.CreateString(token.data(), token.size()));
  }
  Offset<wire::Authenticated> operator()(const Authenticated& m) {
    return wire::CreateAuthenticatedDirect(builder, m.client.c_str(), m.scene.c_str(),
                                           wire_enum<wire::Role>(m.role));
  }
  Offset<wire::Evict> operator()(const Evict& m) { return wire::CreateEvict(builder, m.session); }
  Offset<wire::Evicted> operator()(const Evicted& m) {
    return wire::CreateEvicted(builder, m.session);
  }
  Offset<wire::ListSessions> operator()(const ListSessions& m) {
    return wire::CreateListSessions(builder, m.after);
  }
  Offset<wire::SessionList> operator()(const SessionList& m) {
    std::vector<Offset<wire::SessionEntry>> entries;
    for (const SessionEntry& entry : m.sessions)
      entries.push_back(wire::CreateSessionEntryDirect(builder, entry.session, entry.client.c_str(),
                                                       entry.scene.c_str(),
                                                       wire_enum<wire::Role>(entry.role)));
    return wire::CreateSessionList(builder, builder.CreateVector(entries), m.more);
  }
  Offset<wire::ReloadScene> operator()(const ReloadScene& m) {
    return wire::CreateReloadSceneDirect(builder, m.scene.c_str());
  }
  Offset<wire::SceneReloaded> operator()(const SceneReloaded& m) {
    return wire::CreateSceneReloadedDirect(builder, m.scene.c_str());
  }
};

/// The union counts from 1 in the order of Message.
wire::Body body_type(const Message& message) {
  return static_cast<wire::Body>(message.index() + 1);
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
         read(from.damping(), from.damping_tensor(), to.damping) &&
         read(from.rotational_damping(), from.rotational_damping_tensor(), to.rotational_damping);
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

bool read(const wire::JoinRequest& from, JoinRequest& to) {
  to.aes_256_gcm = from.aes_256_gcm();
  return read_name(from.tool(), to.tool) && read_name(from.version(), to.version) &&
         read_name(from.client(), to.client) && read_name(from.scene(), to.scene) &&
         read(*from.device(), to.device) && read(*from.parameters(), to.parameters) &&
         read_enum(from.role(), to.role);
}
bool read(const wire::JoinAccepted& from, JoinAccepted& to) {
  to.session = from.session();
  to.port_offset = from.port_offset();
  to.silence_timeout = from.silence_timeout();
  to.friction = from.friction();
  to.rotation = from.rotation();
  if (const auto* p = from.start_position()) to.start_position = vector(*p);
  if (const auto* n = from.start_normal()) to.start_normal = vector(*n);
  to.stiffness = from.stiffness();
  to.suite = static_cast<CipherSuite>(from.suite());
  // Numbered from 1: there is no suite of number 0.
  return from.suite() >= wire::CipherSuite::MIN && from.suite() <= wire::CipherSuite::MAX &&
         read_name(from.tool(), to.tool) && read_name(from.version(), to.version) &&
         read(*from.parameters(), to.parameters);
}
bool read(const wire::LeaveRequest& from, LeaveRequest& to) {
  to.session = from.session();
  return true;
}
bool read(const wire::Left& from, Left& to) {
  to.session = from.session();
  return true;
}
bool read(const wire::ListScenes&, ListScenes&) { return true; }
bool read(const wire::SceneList& from, SceneList& to) {
  for (const wire::SceneEntry* entry : *from.scenes()) {
    SceneEntry scene{{}, entry->port_offset(), entry->objects(), entry->sessions()};
    if (!read_name(entry->name(), scene.name)) return false;
    to.scenes.push_back(std::move(scene));
  }
  return true;
}
bool read(const wire::SetParameters& from, SetParameters& to) {
  to.session = from.session();
  return read(*from.parameters(), to.parameters);
}
bool read(const wire::ParametersSet& from, ParametersSet& to) {
  to.session = from.session();
  return read(*from.parameters(), to.parameters);
}
bool read(const wire::Refused& from, Refused& to) {
  to.reason.assign(from.reason()->c_str(), from.reason()->size());
  return read_enum(from.code(), to.code);
}

bool read(const wire::Authenticate& from, Authenticate& to) {
  if (from.token()->size() > kMaxName) return false;
  to.token = Secret({from.token()->c_str(), from.token()->size()});
  return true;
}
bool read(const wire::Authenticated& from, Authenticated& to) {
  return read_name(from.client(), to.client) && read_name(from.scene(), to.scene) &&
         read_enum(from.role(), to.role);
}
bool read(const wire::Evict& from, Evict& to) {
  to.session = from.session();
  return true;
}
bool read(const wire::Evicted& from, Evicted& to) {
  to.session = from.session();
  return true;
}
bool read(const wire::ListSessions& from, ListSessions& to) {
  to.after = from.after();
  return true;
}
bool read(const wire::SessionList& from, SessionList& to) {
  to.more = from.more();
  for (const wire::SessionEntry* entry : *from.sessions()) {
    SessionEntry session;
    session.session = entry->session();
    if (!read_name(entry->client(), session.client) || !read_name(entry->scene(), session.scene) ||
        !read_enum(entry->role(), session.role))
      return false;
    to.sessions.push_back(std::move(session));
  }
  return true;
}
bool read(const wire::ReloadScene& from, ReloadScene& to) {
  return read_name(from.scene(), to.scene);
}
bool read(const wire::SceneReloaded& from, SceneReloaded& to) {
  return read_name(from.scene(), to.scene);
}

template <class Value, class Table>
std::optional<Message> message(const Table& table) {
  Value value;
  if (!read(table, value)) return std::nullopt;
  return Message(std::move(value));
}

}  // namespace

std::vector<std::uint8_t> encode(const Message& message) {
  FlatBufferBuilder builder;
  const Offset<void> body =
      std::visit([&](const auto& m) { return BodyBuilder{builder}(m).Union(); }, message);
  builder.Finish(wire::CreateControlMessage(builder, body_type(message), body));
  if (builder.GetSize() > kMaxFrame)
    throw std::length_error("a control message of " + std::to_string(builder.GetSize()) +
                            " bytes is longer than a frame may be (" + std::to_string(kMaxFrame) +
                            "); shorten its names");
  std::vector<std::uint8_t> frame(kFrameLengthSize + builder.GetSize());
  put_little_endian(frame.data(), static_cast<std::uint32_t>(builder.GetSize()));
  std::copy_n(builder.GetBufferPointer(), builder.GetSize(), frame.data() + kFrameLengthSize);
  sodium_memzero(builder.GetBufferPointer(), builder.GetSize());  // a token may have been in it
  return frame;
}

std::uint32_t frame_length(std::span<const std::uint8_t, kFrameLengthSize> bytes) noexcept {
  return get_little_endian<std::uint32_t>(bytes.data());
}

std::optional<Message> decode(Bytes body) {
  if (body.size() < kSmallestBuffer || body.size() > kMaxFrame) return std::nullopt;
  // FlatBuffers reads eight bytes at a time; a body need not come aligned.
  std::vector<std::uint8_t> aligned;
  if (reinterpret_cast<std::uintptr_t>(body.data()) % alignof(std::uint64_t) != 0) {
    aligned.assign(body.begin(), body.end());
    body = aligned;
  }
  flatbuffers::Verifier verifier(body.data(), body.size(), kMaxDepth, kMaxTables);
  if (!wire::VerifyControlMessageBuffer(verifier)) return std::nullopt;
  const wire::ControlMessage* root = wire::GetControlMessage(body.data());
  switch (root->body_type()) {
    case wire::Body::JoinRequest:
      return message<JoinRequest>(*root->body_as_JoinRequest());
    case wire::Body::JoinAccepted:
      return message<JoinAccepted>(*root->body_as_JoinAccepted());
    case wire::Body::LeaveRequest:
      return message<LeaveRequest>(*root->body_as_LeaveRequest());
    case wire::Body::Left:
      return message<Left>(*root->body_as_Left());
    case wire::Body::ListScenes:
      return message<ListScenes>(*root->body_as_ListScenes());
    case wire::Body::SceneList:
      return message<SceneList>(*root->body_as_SceneList());
    case wire::Body::SetParameters:
      return message<SetParameters>(*root->body_as_SetParameters());
    case wire::Body::ParametersSet:
      return message<ParametersSet>(*root->body_as_ParametersSet());
    case wire::Body::Refused:
      return message<Refused>(*root->body_as_Refused());
    case wire::Body::Authenticate:
      return message<Authenticate>(*root->body_as_Authenticate());
    case wire::Body::Authenticated:
      return message<Authenticated>(*root->body_as_Authenticated());
    case wire::Body::Evict:
      return message<Evict>(*root->body_as_Evict());
    case wire::Body::Evicted:
      return message<Evicted>(*root->body_as_Evicted());
    case wire::Body::ListSessions:
      return message<ListSessions>(*root->body_as_ListSessions());
    case wire::Body::SessionList:
      return message<SessionList>(*root->body_as_SessionList());
    case wire::Body::ReloadScene:
      return message<ReloadScene>(*root->body_as_ReloadScene());
    case wire::Body::SceneReloaded:
      return message<SceneReloaded>(*root->body_as_SceneReloaded());
    case wire::Body::NONE:
      break;
  }
  return std::nullopt;
}

}  // namespace feltwire::control
