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
                          .hand_damping = in.number(8.0),
                          .change = static_cast<std::uint8_t>(in.byte() & ClientChange::kLast),
                          .change_refused = in.coin()};
  if (b.report && in.coin()) {
    HandTimes& times = b.report->times.emplace();
    for (std::uint16_t& n : times.wakeups) n = in.whole<std::uint16_t>();
    for (std::uint16_t& n : times.round_trips) n = in.whole<std::uint16_t>();
  }
  if (in.coin())
    b.lead = Lead{.deadman = in.coin(),
                  .known_surface = in.whole<std::uint32_t>(),
                  .offset = wild ? any_float_vector(in) : Vec3(Vec3::UnitX()),
                  .hand_work = in.any_double(),
                  .gripper = in.any_float()};
  return b;
}

/// Numbers that survive their float32 on the wire.
RemoteContact contact(Input& in) {
  RemoteContact c;
  c.surface = in.byte();
  if (c.surface == 0) return c;
  c.touching = in.coin();
  c.point = in.vector(kMaxPosition);
  c.normal = (in.coin() ? 1.0 : -1.0) * Vec3::Unit(in.byte() % 3);
  c.velocity = any_float_vector(in);
  c.stiffness = in.any_float();
  c.friction = in.any_float();
  return c;
}

EnergyCounters energy(Input& in) { return {in.any_double(), in.any_double(), in.any_double()}; }

/// One that arrives is the one that was sent.
template <class Said>
void require_carried(const Said& sent, Bytes payload) {
  Said again;
  if (decode(payload, again) == DropReason::none)
    require(same(sent, again), "what is said of a robot arrives as it was");
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

/// Numbers that 16 bits tell exactly, but for the root of a covariance.
BodyModel body(Input& in) {
  BodyModel m;
  m.scene = in.whole<std::uint32_t>();
  m.tool = {in.vector(kMaxPosition), orientation(in)};
  m.reach = at_least_zero(in, 1.0);
  m.turn = at_least_zero(in, 1.0);
  m.coupling = {1000.0, 0.5, 8.0, 0.25};
  m.radius = 0.0625;
  m.slipping = in.coin();
  m.count = in.byte() % (kMaxBodyPoints + 1);
  m.patch_count = kMaxBodyPatches;
  for (int i = 0; i < m.count; ++i) {
    BodyPoint& p = m.points[static_cast<std::size_t>(i)];
    const Vec3 wide = in.vector(0.05);
    p = {in.vector(0.1),
         wide * wide.transpose(),
         Vec3::Unit(in.byte() % 3),
         in.number(0.125),
         at_least_zero(in, 1e6),
         static_cast<std::uint8_t>(in.byte() % kMaxBodyPatches)};
  }
  return m;
}
bool near_body(const BodyModel& a, const BodyModel& b) {
  const double unit = 2.0 * a.radius / 32767.0;  // [m]
  if (a.scene != b.scene || a.slipping != b.slipping || a.count != b.count ||
      a.patch_count != b.patch_count || !same(a.tool.position, b.tool.position))
    return false;
  for (std::size_t i = 0; i < a.view().size(); ++i) {
    const BodyPoint &p = a.points[i], &q = b.points[i];
    if (!((p.arm - q.arm).cwiseAbs().maxCoeff() <= 0.51 * unit) || !same(p.distance, q.distance) ||
        !((p.normal - q.normal).norm() <= 1e-4) || p.patch != q.patch ||
        !((p.spread - q.spread).norm() <= 8.0 * unit * (std::sqrt(p.spread.trace()) + unit)))
      return false;
  }
  return true;
}

/// Mostly one that can be: a name of any bytes, a link of any size.
ClientChange change(Input& in) {
  ClientChange c;
  c.number = in.byte();
  if (in.coin()) {
    const Bytes name = in.bytes(in.byte() % (kLongestMethodName + 1));
    c.law = LawChoice{MethodName({reinterpret_cast<const char*>(name.data()), name.size()}),
                      static_cast<Projection>(in.byte() % 3), static_cast<Storage>(in.byte() % 3)};
  }
  if (in.coin())
    c.link = LinkQuality{in.number(12.0), in.coin() ? in.any_float() : 0.25, in.number(1.0)};
  return c;
}
DropReason expected(const ClientChange& c) {
  if (c.number == 0 || c.number > 63) return DropReason::count;
  if (c.law && (static_cast<int>(c.law->projection) > 1 || static_cast<int>(c.law->storage) > 1))
    return DropReason::count;
  if (!c.link) return DropReason::none;
  const auto lies = [](double value, double most) { return value >= 0.0 && value <= most; };
  return lies(c.link->delay, 10.0) && lies(c.link->jitter, 10.0) && lies(c.link->loss, 1.0)
             ? DropReason::none
             : DropReason::not_finite;
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
  r.body_modelled = !r.modelled && in.coin();
  if (r.body_modelled) r.body = body(in);
  if (in.coin())
    r.remote = Remote{.state = static_cast<LinkState>(in.byte() % 8),
                      .meets_surfaces = in.coin(),
                      .pose = {in.vector(kMaxPosition), orientation(in)},
                      .contact = contact(in),
                      .energy = energy(in),
                      .gripper = in.any_float(),
                      .gripper_force = in.any_float(),
                      .age = in.any_float()};
  if (r.remote && in.coin()) r.remote->turn = any_float_vector(in);
  for (int i = in.byte() % 4; i > 0; --i)
    r.normals.add((in.coin() ? 1.0 : -1.0) * Vec3::Unit(in.byte() % 3));
  if (r.normals.count < 2) r.normals = {};  // one says nothing
  if (in.coin()) r.change = change(in);
  return r;
}

Pose seen_pose(Input& in) {
  const Vec3 position = in.vector(kMaxPosition);
  return {position, orientation(in)};
}

HandFigures figures(Input& in) {
  HandFigures f;
  f.samples = in.whole<std::uint64_t>();
  f.proxy = in.vector(kMaxPosition);
  f.elastic = in.vector(100.0);
  f.depth = in.vector(1.0).x();
  f.states = in.whole<std::uint32_t>();
  f.tool = in.whole<std::uint16_t>();
  if (in.coin()) f.report = HandReport{.has_account = in.coin(), .balance = in.vector(1.0).x()};
  return f;
}

/// As much as fits, mostly.
SceneView view(Input& in) {
  SceneView v;
  v.present = true;
  std::size_t room = view_room(in.coin() ? 1.0 : 0.0);
  v.hands_from = in.whole<std::uint16_t>();
  v.bodies_from = in.byte();
  std::uint32_t number = v.hands_from;
  const bool figured = in.coin();
  if (figured) room -= kFiguresOverhead;
  const std::size_t hand_size = SceneView::kHandSize + (figured ? SceneView::kFiguresSize : 0);
  for (std::size_t most = in.byte() % 32; most > 0 && room >= hand_size; --most) {
    number += 1 + in.byte();
    const Pose pose = seen_pose(in);
    SeenHand& hand = v.hand[v.hand_count++];
    hand = {number, pose, in.vector(100.0)};
    if (figured) hand.figures = figures(in);
    room -= hand_size;
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
                                      near(a.force, b.force) && near(a.figures, b.figures);
                             }),
          "hands arrive as they were");
  require(std::ranges::equal(sent.bodies(), got.bodies(),
                             [&](const SeenBody& a, const SeenBody& b) {
                               return a.object == b.object && near_pose(a.pose, b.pose);
                             }),
          "bodies arrive as they were");
}

DropReason expected(const Reply& r) {
  if (r.change && expected(*r.change) == DropReason::count) return DropReason::count;
  if (r.sample_index == 0) return DropReason::order;
  if (r.change && expected(*r.change) != DropReason::none) return DropReason::not_finite;
  const bool finite = r.command.finite() && r.rates.finite() && std::isfinite(r.ratio) &&
                      std::isfinite(r.delivered.elastic) && std::isfinite(r.delivered.frictional) &&
                      std::isfinite(r.delivered.torque);
  if (!finite) return DropReason::not_finite;
  if (!r.remote) return DropReason::none;
  const Remote& m = *r.remote;
  const RemoteContact& c = m.contact;
  const bool known = m.state <= kLastLinkState;
  const bool surface =
      c.surface == 0 ||
      (c.velocity.allFinite() && c.velocity.cwiseAbs().maxCoeff() <= 100.0 && c.stiffness > 0.0 &&
       c.stiffness <= 1e9 && c.friction >= 0.0 && c.friction <= 1e6);
  const auto counts = [](double e) { return e >= 0.0 && std::isfinite(e); };
  const bool counted = counts(m.energy.given) && counts(m.energy.taken) && counts(m.energy.pushed);
  const bool gripper = std::isfinite(m.gripper) && std::isfinite(m.gripper_force);
  const bool turn = !m.turn || m.turn->norm() <= 3.1416;
  return known && surface && counted && gripper && turn && counts(m.age) ? DropReason::none
                                                                         : DropReason::not_finite;
}

void try_reply(Input& in, const Header& header) {
  static Encoder encoder;
  static Reply again;
  static SceneView seen;
  Reply sent = reply(in);
  const bool shows = !sent.modelled && in.coin();
  if (shows) {  // an observer feels nothing and leads nothing: that leaves the room for its view
    sent.normals = {};
    sent.remote.reset();
    sent.change.reset();
    sent.body_modelled = false;
  }
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
  require(again.body_modelled == (sent.body_modelled && !sent.remote), "a body's model arrives");
  if (again.body_modelled)
    require(near_body(sent.body, again.body), "a body's model arrives as it was");
  if (sent.modelled) require(near(sent.model, again.model), "a model arrives as it was");
}

void try_state(Input& in, const Header& header) {
  static Encoder encoder;
  RobotState s;
  s.index = in.whole<std::uint64_t>();
  s.time = Nanoseconds(in.whole<std::int64_t>());
  s.pose = {in.vector(kMaxPosition), orientation(in)};
  s.commanded = {any_vector(in), orientation(in)};
  s.velocity = any_float_vector(in);
  s.angular_velocity = any_float_vector(in);
  if (in.coin()) s.force = any_float_vector(in);
  s.torque = any_float_vector(in);
  s.contact = contact(in);
  s.energy = energy(in);
  s.gripper = in.any_float();
  s.gripper_force = in.any_float();
  s.ok = in.coin();
  s.stopped = in.coin();
  require_carried(s, carried(encoder.state(s), header));
}

void try_target(Input& in, const Header& header) {
  static Encoder encoder;
  RobotTarget t;
  t.index = in.whole<std::uint64_t>();
  t.sample_index = in.whole<std::uint64_t>();
  t.state = static_cast<LinkState>(in.byte() % 7);
  t.pose = {any_vector(in), orientation(in)};
  t.gripper = in.any_float();
  t.known_surface = in.whole<std::uint32_t>();
  t.hand_work = in.any_double();
  require_carried(t, carried(encoder.target(t), header));
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
    header.kind = static_cast<DatagramKind>(1 + in.byte() % 5);
    header.session = in.whole<std::uint64_t>();
    // Of the first generation, whose secret is the session's; 0 is never sent.
    header.packet_number = 1 + in.whole<std::uint32_t>() % ((1u << kGenerationBits) - 1);
    if (header.kind == DatagramKind::samples) fuzz::try_batch(in, header);
    if (header.kind == DatagramKind::reply) fuzz::try_reply(in, header);
    if (header.kind == DatagramKind::goodbye) fuzz::try_goodbye(in, header);
    if (header.kind == DatagramKind::follower_state) fuzz::try_state(in, header);
    if (header.kind == DatagramKind::follower_target) fuzz::try_target(in, header);
  }
  return 0;
}
