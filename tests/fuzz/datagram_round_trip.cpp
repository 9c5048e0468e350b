// Bytes become values, values a datagram, and the datagram the same values.

#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/seal.hpp"
#include "tests/fuzz/same_datagram.hpp"

namespace feltwire::fuzz {
namespace {

constexpr unsigned kAllKinds = ~0u;

/// The payload as it comes out of the datagram that it went into.
Bytes carried(Bytes payload, const Header& sent) {
  constexpr Key kSecret{1, 2, 3};
  static DatagramBuffer sealed, out;
  Sealer sealer(preferred_suite(), kSecret, sent.packet_number - 1);
  Opener opener(preferred_suite(), kSecret);
  const Bytes datagram = sealer.seal(sent.kind, sent.session, payload, sealed);
  require(datagram.size() == payload.size() + kOverhead && datagram.size() <= kMaxDatagram,
          "every datagram fits");
  const Guarded guarded = guard(datagram, kAllKinds);
  require(guarded.drop == DropReason::none, "what is sent passes the guard");
  require(guarded.header.kind == sent.kind && guarded.header.session == sent.session &&
              guarded.header.packet_number == sent.packet_number,
          "the header arrives");
  const Opened opened = opener.open(guarded.header, datagram, out);
  require(opened.drop == DropReason::none && opened.payload.size() == payload.size(),
          "what is sealed is opened");
  return opened.payload;
}

Vec3 any_vector(Input& in) {
  const double x = in.any_double(), y = in.any_double(), z = in.any_double();
  return {x, y, z};
}
Vec3 any_float_vector(Input& in) {
  const double x = in.any_float(), y = in.any_float(), z = in.any_float();
  return {x, y, z};
}

Quaternion orientation(Input& in) {
  const Quaternion q(in.number(1.0), in.number(1.0), in.number(1.0), in.number(1.0));
  return q.squaredNorm() > 0.0 ? q.normalized() : Quaternion::Identity();
}

/// Mostly what a client might send, and now and then anything.
SampleBatch batch(Input& in) {
  SampleBatch b;
  const bool wild = in.coin();
  b.count = wild ? in.byte() % (kMaxRedundancy + 2) : 1 + in.byte() % (kMaxRedundancy + 1);
  b.rotation = in.coin();
  std::uint64_t index = in.whole<std::uint64_t>();
  const auto count = static_cast<std::size_t>(std::min(b.count, kMaxRedundancy + 1));
  b.count = static_cast<int>(count);
  for (std::size_t i = 0; i < count; ++i) {
    Sample& s = b.samples[i];
    s.index = index;
    index -= 1 + in.byte();
    s.client_time = Nanoseconds(in.whole<std::int64_t>());
    s.pose.position = wild ? any_vector(in) : in.vector(kMaxPosition);
    s.held.elastic = wild ? any_float_vector(in) : in.vector(100.0);
    s.held.frictional = wild ? any_float_vector(in) : in.vector(100.0);
    if (!b.rotation) continue;
    s.pose.orientation = orientation(in);
    s.held.torque = wild ? any_float_vector(in) : in.vector(10.0);
  }
  b.previous = wild ? in.whole<std::uint64_t>() : index;
  if (in.coin())
    b.report = HandReport{.reasons = in.whole<std::uint32_t>() & ((1u << kHandReasons) - 1),
                          .has_account = in.coin(),
                          .balance = wild ? in.any_float() : in.number(1.0),
                          .round_trip = wild ? in.any_float() : in.number(1.0),
                          .hand_damping = in.number(8.0)};
  return b;
}

void try_batch(Input& in, const Header& header) {
  static Encoder encoder;
  static SampleBatch again;
  const SampleBatch sent = batch(in);
  const DropReason drop = decode(carried(encoder.samples(sent), header), again);
  require(drop == check(sent), "a batch is refused for what is wrong with it");
  if (drop == DropReason::none) require(same(sent, again), "samples arrive as they were");
}

double at_least_zero(Input& in, double size) { return std::abs(in.number(size)); }

SurfacePatch patch(Input& in, const Vec3& center) {
  SurfacePatch p;
  p.point = center + in.vector(1.0);
  const auto unit = [&in](const Vec3& instead) {
    const Vec3 v = in.vector(1.0);
    return v.isZero(0.0) ? instead : Vec3(v.normalized());
  };
  p.normal = unit(Vec3::UnitZ());
  p.axis = in.coin() ? unit(Vec3::UnitX()) : Vec3::Zero();
  p.velocity = in.vector(10.0);
  p.anchor = center + in.vector(1.0);
  p.curvature = in.any_float();
  if (!std::isfinite(p.curvature)) p.curvature = 0.0;
  p.radius = at_least_zero(in, 1.0);
  p.material.stiffness = 1.0 + at_least_zero(in, 8192.0);
  p.material.damping = at_least_zero(in, 100.0);
  p.material.dynamic_friction = at_least_zero(in, 1.0);
  p.material.static_friction = p.material.dynamic_friction + at_least_zero(in, 1.0);
  p.material.viscous_friction = at_least_zero(in, 100.0);
  p.object = in.whole<std::uint16_t>();
  p.feature = in.whole<std::uint32_t>();
  p.touching = in.coin();
  p.slipping = in.coin();
  p.joined = in.coin();
  return p;
}

LocalModel model(Input& in) {
  LocalModel m;
  m.center = in.vector(kMaxPosition);
  m.reach = at_least_zero(in, 1.0);
  m.scene = in.whole<std::uint32_t>();
  m.count = in.byte() % (kMaxPatches + 1);
  for (int i = 0; i < m.count; ++i) m.patches[static_cast<std::size_t>(i)] = patch(in, m.center);
  return m;
}

Reply reply(Input& in) {
  Reply r;
  r.sample_index = in.whole<std::uint64_t>();
  r.client_time = Nanoseconds(in.whole<std::int64_t>());
  r.server_receive_time = Nanoseconds(in.whole<std::int64_t>());
  r.server_send_time = Nanoseconds(in.whole<std::int64_t>());
  r.command = {any_vector(in), any_vector(in), Vec3::Zero()};
  r.rotation = in.coin();
  if (r.rotation) r.command.torque = any_vector(in);
  r.delivered = {in.any_double(), in.any_double(), in.any_double()};
  r.ratio = in.any_float();
  const unsigned flags = in.byte();
  r.active = (flags & 1u) != 0;
  r.saturated = (flags & 2u) != 0;
  r.refused = (flags & 4u) != 0;
  r.gap = (flags & 8u) != 0;
  r.reloads = in.whole<std::uint8_t>();
  r.withheld = in.whole<std::uint64_t>();
  r.predicted = in.coin();
  if (r.predicted) r.rates = {any_float_vector(in), any_float_vector(in), any_float_vector(in)};
  r.modelled = in.coin();
  if (r.modelled) r.model = model(in);
  for (int i = in.byte() % 4; i > 0; --i)
    r.normals.add((in.coin() ? 1.0 : -1.0) * Vec3::Unit(in.byte() % 3));
  if (r.normals.count < 2) r.normals = {};  // one says nothing
  return r;
}

Pose seen_pose(Input& in) {
  const Vec3 position = in.vector(kMaxPosition);
  return {position, orientation(in)};
}

/// As much as fits, mostly.
SceneView view(Input& in) {
  SceneView v;
  v.present = true;
  std::size_t room = view_room(in.coin() ? 1.0 : 0.0);
  v.hands_from = in.whole<std::uint16_t>();
  v.bodies_from = in.byte();
  std::uint32_t number = v.hands_from;
  for (std::size_t most = in.byte() % 32; most > 0 && room >= SceneView::kHandSize; --most) {
    number += 1 + in.byte();
    const Pose pose = seen_pose(in);
    v.hand[v.hand_count++] = {number, pose, in.vector(100.0)};
    room -= SceneView::kHandSize;
  }
  std::uint32_t object = v.bodies_from;
  for (std::size_t most = in.byte() % 32; most > 0 && room >= SceneView::kBodySize; --most) {
    object += 1 + in.byte();
    v.body[v.body_count++] = {static_cast<std::uint16_t>(object), seen_pose(in)};
    room -= SceneView::kBodySize;
  }
  v.hands_end = number + 1;
  v.bodies_end = static_cast<std::uint16_t>(object + 1);
  if (in.byte() == 0) std::swap(v.hands_from, v.hands_end);  // of no server
  return v;
}

/// What travels as float32.
void require_arrived(const SceneView& sent, const SceneView& got) {
  require(got.present && got.hands_from == sent.hands_from && got.hands_end == sent.hands_end &&
              got.bodies_from == sent.bodies_from && got.bodies_end == sent.bodies_end,
          "a view's ranges arrive");
  const auto near_pose = [](const Pose& a, const Pose& b) {
    return near(a.position, b.position) &&
           (a.orientation.coeffs() - b.orientation.coeffs()).norm() <= 4.0 * kFloatRounding;
  };
  require(std::ranges::equal(sent.hands(), got.hands(),
                             [&](const SeenHand& a, const SeenHand& b) {
                               return a.number == b.number && near_pose(a.pose, b.pose) &&
                                      near(a.force, b.force);
                             }),
          "hands arrive as they were");
  require(std::ranges::equal(sent.bodies(), got.bodies(),
                             [&](const SeenBody& a, const SeenBody& b) {
                               return a.object == b.object && near_pose(a.pose, b.pose);
                             }),
          "bodies arrive as they were");
}

DropReason expected(const Reply& r) {
  if (r.sample_index == 0) return DropReason::order;
  const bool finite = r.command.finite() && r.rates.finite() && std::isfinite(r.ratio) &&
                      std::isfinite(r.delivered.elastic) && std::isfinite(r.delivered.frictional) &&
                      std::isfinite(r.delivered.torque);
  return finite ? DropReason::none : DropReason::not_finite;
}

void try_reply(Input& in, const Header& header) {
  static Encoder encoder;
  static Reply again;
  static SceneView seen;
  Reply sent = reply(in);
  const bool shows = !sent.modelled && in.coin();
  if (shows) sent.normals = {};  // an observer feels nothing: neither a model nor walls are for it
  const SceneView shown = shows ? view(in) : SceneView{};
  const Bytes payload = carried(encoder.reply(sent, shows ? &shown : nullptr), header);
  const DropReason drop = decode(payload, again, &seen);
  const bool rises = shown.hands_from < shown.hands_end || shown.hand_count == 0;
  require(drop == (rises ? expected(sent) : DropReason::order),
          "a reply is refused for what is wrong with it");
  if (drop != DropReason::none) return;
  require(same_but_model(sent, again), "a reply arrives as it was");
  require(seen.present == shows, "a view arrives where there is one");
  if (shows) require_arrived(shown, seen);
  if (sent.modelled) require(near(sent.model, again.model), "a model arrives as it was");
}

void try_goodbye(Input& in, const Header& header) {
  static Encoder encoder;
  const auto reason = static_cast<GoodbyeReason>(in.byte() % 3);
  GoodbyeReason again{};
  require(decode(carried(encoder.goodbye(reason), header), again) == DropReason::none &&
              again == reason,
          "a goodbye arrives as it was");
}

}  // namespace
}  // namespace feltwire::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace feltwire;
  fuzz::Input in(data, size);
  while (!in.empty()) {
    Header header;
    header.kind = static_cast<DatagramKind>(1 + in.byte() % 3);
    header.session = in.whole<std::uint64_t>();
    // Of the first generation, whose secret is the session's; 0 is never sent.
    header.packet_number = 1 + in.whole<std::uint32_t>() % ((1u << kGenerationBits) - 1);
    if (header.kind == DatagramKind::samples) fuzz::try_batch(in, header);
    if (header.kind == DatagramKind::reply) fuzz::try_reply(in, header);
    if (header.kind == DatagramKind::goodbye) fuzz::try_goodbye(in, header);
  }
  return 0;
}
