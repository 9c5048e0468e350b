// Bytes become values, values become a datagram, and the datagram must become equal values.

#include <algorithm>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/seal.hpp"
#include "tests/fuzz/any_datagram.hpp"
#include "tests/fuzz/same_datagram.hpp"

namespace feltwire::fuzz {
namespace {

constexpr unsigned kAllKinds = ~0u;

/// Sends the payload through a datagram and returns the received payload.
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

/// A payload that decodes must equal the sent value.
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

bool near_body(const BodyModel& a, const BodyModel& b) {
  const double unit = 2.0 * a.radius / 32767.0;  // [m]
  if (a.scene != b.scene || a.solids != b.solids || a.slipping != b.slipping ||
      a.count != b.count || a.patch_count != b.patch_count ||
      !same(a.tool.position, b.tool.position))
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

/// A view sends its numbers as float32.
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
  const bool finite = r.command.finite() && r.rates.finite() && std::isfinite(r.bound.ratio) &&
                      std::isfinite(r.delivered.elastic) && std::isfinite(r.delivered.frictional) &&
                      std::isfinite(r.delivered.torque);
  if (!finite) return DropReason::not_finite;
  if (!r.remote) return DropReason::none;
  const Remote& m = *r.remote;
  const bool known = m.state <= kLastLinkState;
  const auto possible = [](const RemoteContact& c) {
    return c.surface == 0 ||
           (c.velocity.allFinite() && c.velocity.cwiseAbs().maxCoeff() <= 100.0 &&
            c.stiffness > 0.0 && c.stiffness <= 1e9 && c.friction >= 0.0 && c.friction <= 1e6);
  };
  const bool surface = possible(m.contact) && std::ranges::all_of(m.others.view(), possible);
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
  if (shows) {  // An observer gets no force and leads nothing, which leaves room for its view.
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
    // The first key generation uses the session's secret. Packet number 0 is never sent.
    header.packet_number = 1 + in.whole<std::uint32_t>() % ((1u << kGenerationBits) - 1);
    if (header.kind == DatagramKind::samples) fuzz::try_batch(in, header);
    if (header.kind == DatagramKind::reply) fuzz::try_reply(in, header);
    if (header.kind == DatagramKind::goodbye) fuzz::try_goodbye(in, header);
    if (header.kind == DatagramKind::follower_state) fuzz::try_state(in, header);
    if (header.kind == DatagramKind::follower_target) fuzz::try_target(in, header);
  }
  return 0;
}
