#include "protocol/wire/codec.hpp"

#include <algorithm>
#include <cmath>

#include "protocol/wire/aligned_vector.hpp"
#include "protocol/wire/body_codec.hpp"
#include "protocol/wire/model_codec.hpp"
#include "protocol/wire/payload.hpp"
#include "protocol/wire/report_codec.hpp"
#include "protocol/wire/robot_codec.hpp"
#include "protocol/wire/view_codec.hpp"
#include "protocol/wire/wire_values.hpp"

namespace feltwire {
namespace {

constexpr std::uint32_t kFlagActive = 1u << 0, kFlagSaturated = 1u << 1, kFlagRefused = 1u << 2,
                        kFlagGap = 1u << 3, kFlagRecovering = 1u << 4, kFlagShortened = 1u << 5;
constexpr unsigned kReloadsShift = 8;  // the byte of the flags that counts reloads
constexpr unsigned kPaceShift = 16;    // the byte of the flags that has the pace

bool plausible(const Sample& sample, bool rotation) {
  if (!sample.held.finite()) return false;
  // Written so that NaN fails.
  if (!(sample.pose.position.cwiseAbs().maxCoeff() <= kMaxPosition) ||
      !sample.pose.position.allFinite())
    return false;
  return !rotation || std::abs(sample.pose.orientation.squaredNorm() - 1.0) <= kUnitTolerance;
}

/// False if there are too few or too many.
bool read(const flatbuffers::Vector<const wire::Vec3f*>* from, ContactNormals& to) {
  to = {};
  if (from == nullptr) return true;
  if (from->size() < 2 || from->size() > to.unit.size()) return false;
  for (flatbuffers::uoffset_t i = 0; i < from->size(); ++i) to.unit[i] = value(*from->Get(i));
  to.count = static_cast<int>(from->size());
  return true;
}

/// Drops a change whose name is too long, whose number or choice does not exist, or whose link is
/// impossible.
DropReason read(const wire::ClientChange* from, std::optional<ClientChange>& to) {
  to.reset();
  if (from == nullptr) return DropReason::none;
  ClientChange& change = to.emplace();
  change.number = from->number();
  if (const auto* mode = from->mode()) {
    if (mode->size() > kLongestMethodName) return DropReason::count;
    if (from->projection() >= kProjectionNames.size() || from->storage() >= kStorageNames.size())
      return DropReason::count;
    change.law = LawChoice{MethodName({mode->c_str(), mode->size()}),
                           static_cast<Projection>(from->projection()),
                           static_cast<Storage>(from->storage())};
  }
  if (change.number == 0 || change.number > ClientChange::kLast) return DropReason::count;
  if (const wire::LinkQuality* link = from->link()) {
    change.link = LinkQuality{link->delay(), link->jitter(), link->loss()};
    if (!possible(*change.link)) return DropReason::not_finite;
  }
  return DropReason::none;
}

bool plausible(const ContactNormals& normals) {
  return std::all_of(normals.unit.begin(), normals.unit.begin() + normals.count, unit_length);
}

/// Exactly unit normals, without a normal that almost depends linearly on the others.
ContactNormals usable(const ContactNormals& told) {
  ContactNormals normals;
  for (int i = 0; i < told.count; ++i)
    normals.add(told.unit[static_cast<std::size_t>(i)].normalized());
  return normals;
}

flatbuffers::Offset<wire::ClientChange> build(flatbuffers::FlatBufferBuilder& builder,
                                              const std::optional<ClientChange>& change) {
  if (!change) return {};
  const LawChoice law = change->law.value_or(LawChoice{});
  const std::string_view mode = law.mode.view();
  const auto name = change->law ? builder.CreateString(mode.data(), mode.size())
                                : flatbuffers::Offset<flatbuffers::String>{};
  const LinkQuality quality = change->link.value_or(LinkQuality{});
  const wire::LinkQuality link(float32(quality.delay), float32(quality.jitter),
                               float32(quality.loss));
  return wire::CreateClientChange(
      builder, change->number, name, static_cast<std::uint8_t>(law.projection),
      static_cast<std::uint8_t>(law.storage), change->link ? &link : nullptr);
}

flatbuffers::Offset<flatbuffers::Vector<const wire::Vec3f*>> build(
    flatbuffers::FlatBufferBuilder& builder, const ContactNormals& normals) {
  if (normals.count < 2) return {};
  std::array<wire::Vec3f, ContactNormals::kMost> unit;
  const auto count = static_cast<std::size_t>(std::min(normals.count, ContactNormals::kMost));
  for (std::size_t i = 0; i < count; ++i) unit[i] = wire_float(normals.unit[i]);
  return builder.CreateVectorOfStructs(unit.data(), count);
}

}  // namespace

Encoder::Encoder() : builder_(std::make_unique<Builder>()) {}
Encoder::~Encoder() = default;
Encoder::Encoder(Encoder&&) noexcept = default;
Encoder& Encoder::operator=(Encoder&&) noexcept = default;

Bytes Encoder::samples(const SampleBatch& batch) {
  const auto count = static_cast<std::size_t>(std::clamp(batch.count, 0, kMaxRedundancy + 1));
  std::array<wire::Sample, kMaxRedundancy + 1> samples;
  std::array<wire::Rotation, kMaxRedundancy + 1> rotations;
  for (std::size_t i = 0; i < count; ++i) {
    const Sample& s = batch.samples[i];
    samples[i] = {s.index, s.client_time.count(), wire_double(s.pose.position),
                  wire_float(s.held.elastic), wire_float(s.held.frictional)};
    rotations[i] = {wire_double(s.pose.orientation), wire_float(s.held.torque)};
  }
  auto& builder = builder_->begin();
  const auto wire_samples = builder.CreateVectorOfStructs(samples.data(), count);
  const auto wire_rotations =
      batch.rotation ? builder.CreateVectorOfStructs(rotations.data(), count)
                     : flatbuffers::Offset<flatbuffers::Vector<const wire::Rotation*>>{};
  const HandReport said = batch.report.value_or(HandReport{});
  const wire::HandReport report = wire_report(said);
  const wire::HandTimes times = wire_times(said.times.value_or(HandTimes{}));
  const wire::Lead lead = batch.lead ? wire_lead(*batch.lead) : wire::Lead();
  return builder_->finish(wire::CreateSamples(
      builder, wire_samples, wire_rotations, batch.previous, batch.report ? &report : nullptr,
      batch.lead ? &lead : nullptr, said.times ? &times : nullptr));
}

Bytes Encoder::reply(const Reply& reply, const SceneView* view, bool shortened) {
  const wire::Vec3d elastic = wire_double(reply.command.elastic);
  const wire::Vec3d frictional = wire_double(reply.command.frictional);
  const wire::Vec3d torque = wire_double(reply.command.torque);
  const std::uint32_t flags =
      (reply.bound.active ? kFlagActive : 0) | (reply.bound.saturated ? kFlagSaturated : 0) |
      (reply.bound.refused ? kFlagRefused : 0) | (reply.gap ? kFlagGap : 0) |
      (reply.recovering ? kFlagRecovering : 0) | (shortened ? kFlagShortened : 0) |
      (std::uint32_t{reply.reloads} << kReloadsShift) |
      (std::uint32_t{reply.pace > 1 ? reply.pace : std::uint8_t{0}} << kPaceShift);
  const wire::BoundingReport report(reply.delivered.elastic, reply.delivered.frictional,
                                    reply.delivered.torque, float32(reply.bound.ratio), flags, 0);
  const wire::Rates rates(wire_float(reply.rates.elastic), wire_float(reply.rates.frictional),
                          wire_float(reply.rates.torque));
  auto& builder = builder_->begin();
  const auto model =
      reply.modelled ? build(builder, reply.model) : flatbuffers::Offset<wire::LocalModel>{};
  const auto seen =
      view != nullptr ? build(builder, *view) : flatbuffers::Offset<wire::SceneView>{};
  const auto normals = build(builder, reply.normals);
  const auto change = build(builder, reply.change);
  const auto body = reply.body_modelled && !reply.remote ? build(builder, reply.body)
                                                         : flatbuffers::Offset<wire::BodyModel>{};
  const wire::Remote remote = reply.remote ? wire_remote(*reply.remote) : wire::Remote();
  const auto walls = build_walls(builder, reply.remote);
  const auto others = build_others(builder, reply.remote ? reply.remote->others : OtherSurfaces{});
  const bool turns = reply.remote && reply.remote->turn;
  const wire::Vec3f turn = turns ? wire_float(*reply.remote->turn) : wire::Vec3f();
  return builder_->finish(wire::CreateReply(
      builder, reply.sample_index, reply.client_time.count(), reply.server_times.received.count(),
      reply.server_times.sent.count(), &elastic, &frictional, reply.rotation ? &torque : nullptr,
      &report, reply.withheld, reply.predicted ? &rates : nullptr, model, seen, normals,
      reply.remote ? &remote : nullptr, change, walls, body, turns ? &turn : nullptr, others));
}

Bytes Encoder::goodbye(GoodbyeReason reason) {
  auto& builder = builder_->begin();
  return builder_->finish(wire::CreateGoodbye(builder, static_cast<wire::GoodbyeReason>(reason)));
}

Bytes Encoder::state(const RobotState& state) {
  return builder_->finish(build(builder_->begin(), state));
}

Bytes Encoder::target(const RobotTarget& target) {
  return builder_->finish(build(builder_->begin(), target));
}

DropReason decode(Bytes payload, SampleBatch& out) noexcept {
  const Aligned bytes(payload);
  const auto* root = bytes.root<wire::Samples>();
  if (root == nullptr) return DropReason::malformed;

  const auto& samples = *root->samples();
  const auto* rotations = root->rotations();
  if (!aligned(samples, alignof(wire::Sample)) ||
      (rotations != nullptr && !aligned(*rotations, alignof(wire::Rotation))))
    return DropReason::malformed;
  if (samples.size() == 0 || samples.size() > out.samples.size()) return DropReason::count;
  if (rotations != nullptr && rotations->size() != samples.size()) return DropReason::count;

  out.count = static_cast<int>(samples.size());
  out.rotation = rotations != nullptr;
  out.previous = root->previous();
  out.report.reset();
  if (const wire::HandReport* said = root->report(); said != nullptr)
    out.report = value(*said, root->times());
  out.lead.reset();
  if (const wire::Lead* said = root->lead(); said != nullptr) out.lead = value(*said);
  for (flatbuffers::uoffset_t i = 0; i < samples.size(); ++i) {
    const wire::Sample& from = *samples.Get(i);
    Sample& to = out.samples[i];
    to.index = from.index();
    to.client_time = Nanoseconds(from.client_time());
    to.pose.position = value(from.position());
    to.held.elastic = value(from.held_elastic());
    to.held.frictional = value(from.held_frictional());
    if (rotations != nullptr) {
      to.pose.orientation = value(rotations->Get(i)->orientation());
      to.held.torque = value(rotations->Get(i)->held_torque());
    } else {
      to.pose.orientation = Quaternion::Identity();
      to.held.torque.setZero();
    }
  }
  return check(out);
}

DropReason check(const SampleBatch& batch) noexcept {
  if (batch.count < 1 || batch.count > kMaxRedundancy + 1) return DropReason::count;
  const auto samples = batch.view();
  if (batch.previous >= samples.back().index) return DropReason::order;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (samples[i].index == 0) return DropReason::order;
    if (i > 0 && samples[i].index >= samples[i - 1].index) return DropReason::order;
  }
  for (const Sample& sample : samples)
    if (!plausible(sample, batch.rotation)) return DropReason::not_finite;
  if (batch.report && !batch.report->finite()) return DropReason::not_finite;
  if (batch.lead && !plausible(*batch.lead)) return DropReason::not_finite;
  return DropReason::none;
}

namespace {

/// Checks the view even if the caller does not want it.
DropReason read_view(const wire::SceneView* from, SceneView* view) noexcept {
  if (view != nullptr) view->present = false;
  if (from == nullptr) return DropReason::none;
  if (view != nullptr) return read(*from, *view);
  SceneView unwanted;
  return read(*from, unwanted);
}

}  // namespace

DropReason decode(Bytes payload, Reply& out, SceneView* view) noexcept {
  const Aligned bytes(payload);
  const auto* root = bytes.root<wire::Reply>();
  if (root == nullptr) return DropReason::malformed;
  if (root->walls() != nullptr && !aligned(*root->walls(), alignof(wire::RobotWall)))
    return DropReason::malformed;

  const wire::BoundingReport& report = *root->report();
  out.sample_index = root->sample_index();
  out.client_time = Nanoseconds(root->client_time());
  out.server_times.received = Nanoseconds(root->server_receive_time());
  out.server_times.sent = Nanoseconds(root->server_send_time());
  out.command.elastic = value(*root->elastic());
  out.command.frictional = value(*root->frictional());
  out.rotation = root->torque() != nullptr;
  out.command.torque = out.rotation ? value(*root->torque()) : Vec3::Zero();
  out.delivered = {report.delivered_elastic(), report.delivered_frictional(),
                   report.delivered_torque()};
  out.bound.ratio = report.ratio();
  out.bound.active = (report.flags() & kFlagActive) != 0;
  out.bound.saturated = (report.flags() & kFlagSaturated) != 0;
  out.bound.refused = (report.flags() & kFlagRefused) != 0;
  out.gap = (report.flags() & kFlagGap) != 0;
  out.recovering = (report.flags() & kFlagRecovering) != 0;
  out.reloads = static_cast<std::uint8_t>(report.flags() >> kReloadsShift);
  out.pace = std::max<std::uint8_t>(static_cast<std::uint8_t>(report.flags() >> kPaceShift), 1);
  out.withheld = root->withheld();
  out.predicted = root->rates() != nullptr;
  out.rates = {};
  if (const auto* rates = root->rates())
    out.rates = {value(rates->elastic()), value(rates->frictional()), value(rates->torque())};
  out.modelled = root->model() != nullptr;
  if (out.modelled && !read(*root->model(), out.model)) return DropReason::count;
  out.body_modelled = root->body() != nullptr;
  if (out.body_modelled && !read(*root->body(), out.body)) return DropReason::count;
  if (!read(root->normals(), out.normals)) return DropReason::count;
  out.remote.reset();
  bool remote_read = root->remote() == nullptr || read(*root->remote(), out.remote.emplace());
  if (const auto* walls = root->walls(); walls != nullptr && out.remote) {
    if (walls->size() > kMostRemoteWalls) return DropReason::count;
    remote_read = read(*walls, *out.remote) && remote_read;
  }
  OtherSurfaces others;
  const DropReason surfaces = read(root->others(), others);
  if (surfaces == DropReason::malformed || surfaces == DropReason::count) return surfaces;
  if (out.remote) {
    out.remote->others = others;
    remote_read = remote_read && surfaces == DropReason::none;
  }
  if (root->turn() != nullptr && out.remote)
    remote_read = read(*root->turn(), *out.remote) && remote_read;
  const DropReason seen = read_view(root->view(), view);
  if (seen == DropReason::count) return seen;
  const DropReason changed = read(root->change(), out.change);
  if (changed == DropReason::count) return changed;

  if (out.sample_index == 0) return DropReason::order;
  if (seen != DropReason::none) return seen;
  if (!out.command.finite() || !std::isfinite(out.bound.ratio) ||
      !std::isfinite(out.delivered.elastic) || !std::isfinite(out.delivered.frictional) ||
      !std::isfinite(out.delivered.torque) || !out.rates.finite() ||
      (out.modelled && !plausible(out.model)) || (out.body_modelled && !plausible(out.body)) ||
      !plausible(out.normals) || !remote_read || changed != DropReason::none)
    return DropReason::not_finite;
  out.normals = usable(out.normals);
  return DropReason::none;
}

bool is_shortened(Bytes payload) noexcept {
  const Aligned bytes(payload);
  const auto* root = bytes.root<wire::Reply>();
  return root != nullptr && (root->report()->flags() & kFlagShortened) != 0;
}

DropReason decode(Bytes payload, GoodbyeReason& out) noexcept {
  const Aligned bytes(payload);
  const auto* root = bytes.root<wire::Goodbye>();
  if (root == nullptr || root->reason() > wire::GoodbyeReason::MAX) return DropReason::malformed;
  out = static_cast<GoodbyeReason>(root->reason());
  return DropReason::none;
}

}  // namespace feltwire
