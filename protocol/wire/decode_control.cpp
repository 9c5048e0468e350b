// Decodes control messages from bytes.

#include <cmath>

#include "core/base/little_endian.hpp"
#include "flatbuffers/flatbuffers.h"
#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/control_values.hpp"
#include "protocol/wire/fleet_codec.hpp"
#include "protocol/wire/parameters_codec.hpp"
#include "protocol/wire/shape_codec.hpp"
#include "protocol/wire/solid_codec.hpp"
#include "protocol/wire/surface_codec.hpp"

namespace feltwire::control {
namespace {

constexpr flatbuffers::uoffset_t kMaxDepth = 8;
// Largest number of tables in a message. Several entries of a list may point at the same bytes, so
// this also limits the memory that a hostile frame can take.
constexpr flatbuffers::uoffset_t kMaxTables = kMaxScenes + 8;
constexpr std::size_t kSmallestBuffer = 8;  // [bytes] size of a root offset and an empty table

bool read(const wire::JoinRequest& from, JoinRequest& to) {
  to.figures = from.figures();
  to.aes_256_gcm = from.aes_256_gcm();
  to.takes.link = from.link_taken();
  to.lead_share = from.lead_share();
  to.follows_redirects = from.follows_redirects();
  to.epoch = {from.term(), from.holder()};
  return read_name(from.ticket(), to.ticket, kMaxTicket) &&
         control::read(from.workspace(), to.workspace) && read_name(from.tool(), to.tool) &&
         read_name(from.seat(), to.seat) && read_name(from.version(), to.version) &&
         read_name(from.client(), to.client) && read_name(from.scene(), to.scene) &&
         control::read(*from.device(), to.device) &&
         control::read(*from.parameters(), to.parameters) && read_enum(from.role(), to.role) &&
         read_enum(from.laws_taken(), to.takes.laws);
}
Secret secret(const flatbuffers::Vector<std::uint8_t>* bytes) {
  if (bytes == nullptr) return {};
  return Secret({reinterpret_cast<const char*>(bytes->data()), bytes->size()});
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
  to.lists_surfaces = from.lists_surfaces();
  if (const auto* seats = from.seats()) {
    if (seats->size() > kMostSeats) return false;
    for (const auto* seat : *seats)
      if (!read_name(seat, to.seats.emplace_back())) return false;
  }
  to.epoch = {from.term(), from.holder()};
  to.secret_up = secret(from.secret_up());
  to.secret_down = secret(from.secret_down());
  // Cipher suites are numbered from 1.
  return control::read(from.hosts(), to.hosts) && control::read(from.workspace(), to.workspace) &&
         from.suite() >= wire::CipherSuite::MIN && from.suite() <= wire::CipherSuite::MAX &&
         read_name(from.tool(), to.tool) && read_name(from.version(), to.version) &&
         control::read(*from.parameters(), to.parameters);
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
  return control::read(*from.parameters(), to.parameters);
}
bool read(const wire::ParametersSet& from, ParametersSet& to) {
  to.session = from.session();
  return control::read(*from.parameters(), to.parameters);
}
bool read(const wire::Refused& from, Refused& to) {
  to.reason.assign(from.reason()->c_str(), from.reason()->size());
  return read_enum(from.code(), to.code);
}

bool read(const wire::Authenticate& from, Authenticate& to) {
  if (from.token()->size() > kMaxName) return false;
  to.token = Secret({from.token()->c_str(), from.token()->size()});
  to.versions = {.newest = from.newest_protocol(), .oldest = from.oldest_protocol()};
  return to.versions.oldest <= to.versions.newest;
}
bool read(const wire::Authenticated& from, Authenticated& to) {
  to.versions = {.newest = from.newest_protocol(), .oldest = from.oldest_protocol()};
  return to.versions.oldest <= to.versions.newest && read_name(from.client(), to.client) &&
         read_name(from.scene(), to.scene) && read_enum(from.role(), to.role);
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

std::optional<double> given(double value) {
  return std::isnan(value) ? std::nullopt : std::optional(value);
}

bool read(const wire::SetMaterial& from, SetMaterial& to) {
  to.change = {.stiffness = given(from.stiffness()),
               .damping = given(from.damping()),
               .static_friction = given(from.static_friction()),
               .dynamic_friction = given(from.dynamic_friction()),
               .viscous_friction = given(from.viscous_friction())};
  return read_name(from.scene(), to.scene) && read_name(from.object(), to.change.object);
}
bool read(const wire::SetGravity& from, SetGravity& to) {
  to.gravity = vector(*from.gravity());
  return read_name(from.scene(), to.scene);
}
bool read(const wire::SetLink& from, SetLink& to) {
  to.session = from.session();
  to.link = {from.delay(), from.jitter(), from.loss()};
  return true;
}
bool read(const wire::SetLead& from, SetLead& to) {
  to = {from.session(), from.share()};
  return true;
}
bool read(const wire::SceneChanged& from, SceneChanged& to) {
  return read_name(from.scene(), to.scene) && read_name(from.what(), to.what, kMaxReason);
}
bool read(const wire::WriteFlightRecord& from, WriteFlightRecord& to) {
  return read_name(from.scene(), to.scene);
}
bool read(const wire::FlightRecordWritten& from, FlightRecordWritten& to) {
  return read_name(from.scene(), to.scene) && read_name(from.file(), to.file, kMaxReason);
}
bool read(const wire::RecordScene& from, RecordScene& to) {
  return read_name(from.scene(), to.scene) && read_enum(from.action(), to.action);
}
bool read(const wire::SceneRecordings& from, SceneRecordings& to) {
  to.seconds = from.seconds();
  to.bytes = from.bytes();
  if (from.kept()->size() > kMaxKept || !read_name(from.scene(), to.scene) ||
      !read_name(from.folder(), to.folder, kMaxReason) ||
      (from.running() != nullptr && !read_name(from.running(), to.running, kMaxReason)) ||
      !read_enum(from.ended(), to.ended))
    return false;
  for (const wire::KeptRecording* file : *from.kept()) {
    KeptRecording& kept = to.kept.emplace_back();
    kept.bytes = file->bytes();
    if (!read_name(file->name(), kept.name, kMaxReason)) return false;
  }
  return true;
}
bool read(const wire::ListSurfaces& from, ListSurfaces& to) {
  to.session = from.session();
  return true;
}
bool read(const wire::GetSurface& from, GetSurface& to) {
  to = {from.session(), from.version(), from.object(), from.vertices(), from.triangles()};
  return true;
}
bool read(const wire::ListSolids& from, ListSolids& to) {
  to.session = from.session();
  return true;
}
bool read(const wire::GetBodyPoints& from, GetBodyPoints& to) {
  to = {from.session(), from.version(), from.points()};
  return true;
}
bool read(const wire::SurfacesTaken& from, SurfacesTaken& to) {
  to.session = from.session();
  return true;
}
bool read(const wire::DescribeSessions& from, DescribeSessions& to) {
  to.after = from.after();
  return read_name(from.scene(), to.scene);
}
HandTimesHeard heard(const wire::TimesSoFar* times) {
  if (times == nullptr) return {};
  HandTimesHeard::Totals wakeups{}, round_trips{};
  for (std::uint16_t i = 0; i < HandTimes::kClasses; ++i) {
    wakeups[i] = times->wakeups()->Get(i);
    round_trips[i] = times->round_trips()->Get(i);
  }
  return {wakeups, round_trips};
}
bool read(const wire::SessionDescriptions& from, SessionDescriptions& to) {
  to.more = from.more();
  for (const wire::SessionDescription* entry : *from.sessions()) {
    SessionDescription session;
    session.number = entry->number();
    session.session = entry->session();
    session.samples = entry->samples();
    session.missed = entry->missed();
    session.round_trip = given(entry->round_trip());
    session.delivered = entry->delivered();
    session.burned = entry->burned();
    session.balance = given(entry->balance());
    session.changes.takes.link = entry->link_taken();
    session.lead_share = entry->lead_share();
    session.seconds = given(entry->seconds());
    session.hand_damping = given(entry->hand_damping());
    session.times = heard(entry->times());
    if (!read_name(entry->client(), session.client) ||
        !read_name(entry->device(), session.device) || !read_name(entry->tool(), session.tool) ||
        !read_name(entry->seat(), session.seat) || !read_enum(entry->role(), session.role) ||
        !control::read(*entry->parameters(), session.parameters) ||
        !read_enum(entry->laws_taken(), session.changes.takes.laws) ||
        !read_name(entry->asked(), session.changes.asked, kMaxReason) ||
        !read_enum(entry->answer(), session.changes.answer))
      return false;
    to.sessions.push_back(std::move(session));
  }
  return true;
}
bool read(const wire::DescribeScene& from, DescribeScene& to) {
  to.from = from.from();
  return read_name(from.scene(), to.scene);
}
std::optional<TimeCounts> counted(const wire::TimesCounted* times) {
  if (times == nullptr) return std::nullopt;
  TimeCounts::Counts counts{};
  constexpr auto kClasses = static_cast<std::uint16_t>(TimeCounts::kClasses);
  for (std::uint16_t i = 0; i < kClasses; ++i) counts.at(i) = times->counts()->Get(i);
  return TimeCounts(counts, times->sum());
}
bool read(const wire::SceneDescription& from, SceneDescription& to) {
  to.version = from.version();
  to.changes = from.changes();
  if (from.gravity() != nullptr) to.gravity = vector(*from.gravity());
  to.objects = from.objects();
  to.times = {counted(from.answers()), counted(from.world_late())};
  const auto& materials = *from.materials();
  if (!aligned(materials, alignof(wire::FeltMaterial)) || materials.size() > kMaxMaterials)
    return false;
  for (const wire::FeltMaterial* m : materials) to.materials.push_back(material(*m));
  return true;
}
bool read(const wire::GetCounters& from, GetCounters& to) {
  return read_name(from.scene(), to.scene);
}
bool read(const wire::Counters& from, Counters& to) {
  for (const wire::Counter* entry : *from.counters()) {
    Counter counter{{}, entry->value()};
    if (!read_name(entry->name(), counter.name)) return false;
    to.counters.push_back(std::move(counter));
  }
  return true;
}

template <class Value, class Table>
std::optional<Message> message(const Table& table) {
  Value value;
  if (!read(table, value)) return std::nullopt;
  return Message(std::move(value));
}

}  // namespace

std::uint32_t frame_length(std::span<const std::uint8_t, kFrameLengthSize> bytes) noexcept {
  return get_little_endian<std::uint32_t>(bytes.data());
}

std::optional<Message> decode(Bytes body) {
  if (body.size() < kSmallestBuffer || body.size() > kMaxFrame) return std::nullopt;
  // FlatBuffers reads eight bytes at a time, so copy an unaligned body.
  struct Wiped {  // the copy may hold secrets
    std::vector<std::uint8_t> bytes;
    ~Wiped() { wipe(bytes); }
  } aligned;
  if (reinterpret_cast<std::uintptr_t>(body.data()) % alignof(std::uint64_t) != 0) {
    aligned.bytes.assign(body.begin(), body.end());
    body = aligned.bytes;
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
    case wire::Body::SetMaterial:
      return message<SetMaterial>(*root->body_as_SetMaterial());
    case wire::Body::SetGravity:
      return message<SetGravity>(*root->body_as_SetGravity());
    case wire::Body::SceneChanged:
      return message<SceneChanged>(*root->body_as_SceneChanged());
    case wire::Body::DescribeSessions:
      return message<DescribeSessions>(*root->body_as_DescribeSessions());
    case wire::Body::SessionDescriptions:
      return message<SessionDescriptions>(*root->body_as_SessionDescriptions());
    case wire::Body::GetCounters:
      return message<GetCounters>(*root->body_as_GetCounters());
    case wire::Body::Counters:
      return message<Counters>(*root->body_as_Counters());
    case wire::Body::SetLink:
      return message<SetLink>(*root->body_as_SetLink());
    case wire::Body::SetLead:
      return message<SetLead>(*root->body_as_SetLead());
    case wire::Body::WriteFlightRecord:
      return message<WriteFlightRecord>(*root->body_as_WriteFlightRecord());
    case wire::Body::FlightRecordWritten:
      return message<FlightRecordWritten>(*root->body_as_FlightRecordWritten());
    case wire::Body::RecordScene:
      return message<RecordScene>(*root->body_as_RecordScene());
    case wire::Body::SceneRecordings:
      return message<SceneRecordings>(*root->body_as_SceneRecordings());
    case wire::Body::ListSurfaces:
      return message<ListSurfaces>(*root->body_as_ListSurfaces());
    case wire::Body::SurfaceList:
      return message<SurfaceList>(*root->body_as_SurfaceList());
    case wire::Body::GetSurface:
      return message<GetSurface>(*root->body_as_GetSurface());
    case wire::Body::SurfacePart:
      return message<SurfacePart>(*root->body_as_SurfacePart());
    case wire::Body::TakeSurfaces:
      return message<TakeSurfaces>(*root->body_as_TakeSurfaces());
    case wire::Body::SurfacesTaken:
      return message<SurfacesTaken>(*root->body_as_SurfacesTaken());
    case wire::Body::ListSolids:
      return message<ListSolids>(*root->body_as_ListSolids());
    case wire::Body::SolidList:
      return message<SolidList>(*root->body_as_SolidList());
    case wire::Body::GetBodyPoints:
      return message<GetBodyPoints>(*root->body_as_GetBodyPoints());
    case wire::Body::BodyPoints:
      return message<BodyPoints>(*root->body_as_BodyPoints());
    case wire::Body::DescribeShapes:
      return message<DescribeShapes>(*root->body_as_DescribeShapes());
    case wire::Body::ShapeDescriptions:
      return message<ShapeDescriptions>(*root->body_as_ShapeDescriptions());
    case wire::Body::GetShape:
      return message<GetShape>(*root->body_as_GetShape());
    case wire::Body::ShapePart:
      return message<ShapePart>(*root->body_as_ShapePart());
    case wire::Body::DescribeScene:
      return message<DescribeScene>(*root->body_as_DescribeScene());
    case wire::Body::SceneDescription:
      return message<SceneDescription>(*root->body_as_SceneDescription());
    case wire::Body::Redirected:
      return message<Redirected>(*root->body_as_Redirected());
    case wire::Body::NONE:
      break;
  }
  return std::nullopt;
}

}  // namespace feltwire::control
