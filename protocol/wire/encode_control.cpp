// Encodes control messages to bytes.

#include <sodium.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "core/base/little_endian.hpp"
#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_values.hpp"
#include "protocol/wire/fleet_codec.hpp"
#include "protocol/wire/parameters_codec.hpp"
#include "protocol/wire/shape_codec.hpp"
#include "protocol/wire/solid_codec.hpp"
#include "protocol/wire/surface_codec.hpp"

namespace feltwire::control {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

wire::TimesSoFar wire_times(const HandTimesHeard& times) {
  return wire::TimesSoFar(
      flatbuffers::span<const std::uint64_t, HandTimes::kClasses>(times.wakeups()),
      flatbuffers::span<const std::uint64_t, HandTimes::kClasses>(times.round_trips()));
}

wire::TimesCounted wire_times(const TimeCounts& times) {
  return {flatbuffers::span<const std::uint64_t, TimeCounts::kClasses>(times.counts()),
          times.sum()};
}

/// Wipes memory before it returns it, also where a growing buffer moves: messages hold secrets. It
/// keeps the size of a block before the block, because after a failed allocation the builder gives
/// back the old block with the size of the new one.
class WipingAllocator : public flatbuffers::Allocator {
 public:
  std::uint8_t* allocate(std::size_t size) override {
    auto* const block = new std::uint8_t[kHead + size];
    std::memcpy(block, &size, sizeof size);
    return block + kHead;
  }
  void deallocate(std::uint8_t* memory, std::size_t /*size*/) override {
    std::size_t size = 0;
    std::memcpy(&size, memory - kHead, sizeof size);
    sodium_memzero(memory, size);
    delete[](memory - kHead);
  }

 private:
  static constexpr std::size_t kHead = __STDCPP_DEFAULT_NEW_ALIGNMENT__;
};

/// Builds the union member for each message.
struct BodyBuilder {
  FlatBufferBuilder& builder;

  Offset<wire::JoinRequest> operator()(const JoinRequest& m) {
    const auto device = build(builder, m.device);
    const auto parameters = build(builder, m.parameters);
    // A name may contain a zero byte, so CreateString gets the length, here and below.
    const auto client = builder.CreateString(m.client), scene = builder.CreateString(m.scene);
    const auto tool = name_if_any(builder, m.tool), version = name_if_any(builder, m.version);
    const auto workspace = build(builder, m.workspace);
    const auto seat = name_if_any(builder, m.seat), ticket = name_if_any(builder, m.ticket);
    return wire::CreateJoinRequest(
        builder, client, scene, device, parameters, wire_enum<wire::Role>(m.role), m.aes_256_gcm,
        tool, version, m.figures, wire_enum<wire::LawsTaken>(m.takes.laws), m.takes.link, workspace,
        m.lead_share, seat, m.follows_redirects, m.epoch.term, m.epoch.holder, ticket);
  }
  Offset<wire::JoinAccepted> operator()(const JoinAccepted& m) {
    const wire::Vector position = wire_vector(m.start_position),
                       normal = wire_vector(m.start_normal);
    const auto parameters = build(builder, m.parameters);
    const auto tool = name_if_any(builder, m.tool), version = name_if_any(builder, m.version);
    const auto workspace = build(builder, m.workspace);
    const auto seats = m.seats.empty() ? 0 : builder.CreateVectorOfStrings(m.seats);
    const auto up = secret_if_any(m.secret_up), down = secret_if_any(m.secret_down);
    const auto hosts = build(builder, m.hosts);
    return wire::CreateJoinAccepted(
        builder, m.session, m.port_offset, parameters, m.silence_timeout, m.friction, m.rotation,
        &position, &normal, m.stiffness, wire_enum<wire::CipherSuite>(m.suite), tool, version,
        workspace, seats, m.lists_surfaces, up, down, m.epoch.term, m.epoch.holder, hosts);
  }
  Offset<wire::Redirected> operator()(const Redirected& m) { return build(builder, m); }
  Offset<flatbuffers::Vector<std::uint8_t>> secret_if_any(const Secret& secret) {
    if (secret.empty()) return 0;
    const std::string_view bytes = secret.text();
    std::uint8_t* at = nullptr;
    const auto vector = builder.CreateUninitializedVector(bytes.size(), &at);
    std::copy(bytes.begin(), bytes.end(), at);
    return vector;
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
    return wire::CreateAuthenticate(builder, builder.CreateString(token.data(), token.size()),
                                    m.versions.newest, m.versions.oldest);
  }
  Offset<wire::Authenticated> operator()(const Authenticated& m) {
    return wire::CreateAuthenticatedDirect(builder, m.client.c_str(), m.scene.c_str(),
                                           wire_enum<wire::Role>(m.role), m.versions.newest,
                                           m.versions.oldest);
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
  Offset<wire::SetMaterial> operator()(const SetMaterial& m) {
    const MaterialChange& c = m.change;
    const auto scene = builder.CreateString(m.scene), object = builder.CreateString(c.object);
    return wire::CreateSetMaterial(
        builder, scene, object, c.stiffness.value_or(kNotGiven), c.damping.value_or(kNotGiven),
        c.static_friction.value_or(kNotGiven), c.dynamic_friction.value_or(kNotGiven),
        c.viscous_friction.value_or(kNotGiven));
  }
  Offset<wire::SetGravity> operator()(const SetGravity& m) {
    const wire::Vector gravity = wire_vector(m.gravity);
    return wire::CreateSetGravity(builder, builder.CreateString(m.scene), &gravity);
  }
  Offset<wire::SetLink> operator()(const SetLink& m) {
    return wire::CreateSetLink(builder, m.session, m.link.delay, m.link.jitter, m.link.loss);
  }
  Offset<wire::SetLead> operator()(const SetLead& m) {
    return wire::CreateSetLead(builder, m.session, m.share);
  }
  Offset<wire::WriteFlightRecord> operator()(const WriteFlightRecord& m) {
    return wire::CreateWriteFlightRecord(builder, builder.CreateString(m.scene));
  }
  Offset<wire::FlightRecordWritten> operator()(const FlightRecordWritten& m) {
    const auto scene = builder.CreateString(m.scene);
    return wire::CreateFlightRecordWritten(builder, scene,
                                           builder.CreateString(shortened(m.file, kMaxReason)));
  }
  Offset<wire::RecordScene> operator()(const RecordScene& m) {
    return wire::CreateRecordScene(builder, builder.CreateString(m.scene),
                                   wire_enum<wire::RecordingAction>(m.action));
  }
  Offset<wire::SceneRecordings> operator()(const SceneRecordings& m) {
    std::vector<Offset<wire::KeptRecording>> kept;
    kept.reserve(m.kept.size());
    for (const KeptRecording& file : m.kept)
      kept.push_back(wire::CreateKeptRecordingDirect(builder, file.name.c_str(), file.bytes));
    const auto scene = builder.CreateString(m.scene);
    const auto folder = builder.CreateString(shortened(m.folder, kMaxReason));
    const auto running =
        m.running.empty() ? Offset<flatbuffers::String>() : builder.CreateString(m.running);
    return wire::CreateSceneRecordings(builder, scene, folder, running, m.seconds, m.bytes,
                                       wire_enum<wire::RecordingEnd>(m.ended),
                                       builder.CreateVector(kept));
  }
  Offset<wire::SceneChanged> operator()(const SceneChanged& m) {
    const auto scene = builder.CreateString(m.scene);
    return wire::CreateSceneChanged(builder, scene,
                                    builder.CreateString(shortened(m.what, kMaxReason)));
  }
  Offset<wire::ListSurfaces> operator()(const ListSurfaces& m) {
    return wire::CreateListSurfaces(builder, m.session);
  }
  Offset<wire::SurfaceList> operator()(const SurfaceList& m) { return control::build(builder, m); }
  Offset<wire::GetSurface> operator()(const GetSurface& m) {
    return wire::CreateGetSurface(builder, m.session, m.version, m.object, m.vertices, m.triangles);
  }
  Offset<wire::SurfacePart> operator()(const SurfacePart& m) { return control::build(builder, m); }
  Offset<wire::TakeSurfaces> operator()(const TakeSurfaces& m) {
    return wire::CreateTakeSurfaces(builder, m.session, m.version, builder.CreateVector(m.objects));
  }
  Offset<wire::SurfacesTaken> operator()(const SurfacesTaken& m) {
    return wire::CreateSurfacesTaken(builder, m.session);
  }
  Offset<wire::ListSolids> operator()(const ListSolids& m) {
    return wire::CreateListSolids(builder, m.session);
  }
  Offset<wire::SolidList> operator()(const SolidList& m) { return control::build(builder, m); }
  Offset<wire::GetBodyPoints> operator()(const GetBodyPoints& m) {
    return wire::CreateGetBodyPoints(builder, m.session, m.version, m.points);
  }
  Offset<wire::BodyPoints> operator()(const BodyPoints& m) { return control::build(builder, m); }
  Offset<wire::DescribeShapes> operator()(const DescribeShapes& m) {
    return control::build(builder, m);
  }
  Offset<wire::ShapeDescriptions> operator()(const ShapeDescriptions& m) {
    return control::build(builder, m);
  }
  Offset<wire::GetShape> operator()(const GetShape& m) { return control::build(builder, m); }
  Offset<wire::ShapePart> operator()(const ShapePart& m) { return control::build(builder, m); }
  Offset<wire::DescribeSessions> operator()(const DescribeSessions& m) {
    return wire::CreateDescribeSessions(builder, builder.CreateString(m.scene), m.after);
  }
  Offset<wire::SessionDescription> entry(const SessionDescription& d) {
    const auto client = builder.CreateString(d.client), device = builder.CreateString(d.device);
    const auto tool = name_if_any(builder, d.tool), asked = name_if_any(builder, d.changes.asked);
    const auto seat = name_if_any(builder, d.seat);
    const auto parameters = build(builder, d.parameters);
    const wire::TimesSoFar times = wire_times(d.times);
    return wire::CreateSessionDescription(
        builder, d.number, d.session, client, device, tool, wire_enum<wire::Role>(d.role),
        parameters, d.samples, d.missed, d.round_trip.value_or(kNotGiven), d.delivered, d.burned,
        d.balance.value_or(kNotGiven), wire_enum<wire::LawsTaken>(d.changes.takes.laws),
        d.changes.takes.link, asked, wire_enum<wire::ChangeAnswer>(d.changes.answer), d.lead_share,
        seat, d.seconds.value_or(kNotGiven), d.hand_damping.value_or(kNotGiven),
        d.times.heard() ? &times : nullptr);
  }
  Offset<wire::SessionDescriptions> operator()(const SessionDescriptions& m) {
    std::vector<Offset<wire::SessionDescription>> entries;
    for (const SessionDescription& session : m.sessions) entries.push_back(entry(session));
    return wire::CreateSessionDescriptions(builder, builder.CreateVector(entries), m.more);
  }
  Offset<wire::DescribeScene> operator()(const DescribeScene& m) {
    return wire::CreateDescribeScene(builder, builder.CreateString(m.scene), m.from);
  }
  Offset<wire::SceneDescription> operator()(const SceneDescription& m) {
    std::vector<wire::FeltMaterial> materials;
    for (const Material& material : m.materials) materials.push_back(wire_material(material));
    const wire::Vector gravity = wire_vector(m.gravity.value_or(Vec3::Zero()));
    const wire::TimesCounted answers = wire_times(m.times.answers.value_or(TimeCounts()));
    const wire::TimesCounted late = wire_times(m.times.world_late.value_or(TimeCounts()));
    return wire::CreateSceneDescription(
        builder, m.version, m.changes, m.gravity ? &gravity : nullptr, m.objects,
        builder.CreateVectorOfStructs(materials), m.times.answers ? &answers : nullptr,
        m.times.world_late ? &late : nullptr);
  }
  Offset<wire::GetCounters> operator()(const GetCounters& m) {
    return wire::CreateGetCounters(builder, name_if_any(builder, m.scene));
  }
  Offset<wire::Counters> operator()(const Counters& m) {
    std::vector<Offset<wire::Counter>> entries;
    for (const Counter& counter : m.counters)
      entries.push_back(
          wire::CreateCounter(builder, builder.CreateString(counter.name), counter.value));
    return wire::CreateCounters(builder, builder.CreateVector(entries));
  }
};

/// Returns the union's type. It counts from 1, in the order of Message.
wire::Body body_type(const Message& message) {
  return static_cast<wire::Body>(message.index() + 1);
}

}  // namespace

std::vector<std::uint8_t> encode(const Message& message) {
  constexpr std::size_t kFirstSize = 1024;  // [bytes]
  WipingAllocator allocator;
  FlatBufferBuilder builder(kFirstSize, &allocator);
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
  return frame;
}

}  // namespace feltwire::control
