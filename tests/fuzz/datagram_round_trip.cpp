// Bytes become values, values a datagram, and the datagram the same values.

#include "protocol/codec.hpp"
#include "protocol/guard.hpp"
#include "protocol/seal.hpp"
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
  p.feature = in.byte();
  p.touching = in.coin();
  p.slipping = in.coin();
  p.joined = in.coin();
  return p;
}

LocalModel model(Input& in) {
  LocalModel m;
  m.center = in.vector(kMaxPosition);
  m.reach = at_least_zero(in, 1.0);
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
  r.violations = in.whole<std::uint64_t>();
  r.withheld = in.whole<std::uint64_t>();
  r.predicted = in.coin();
  if (r.predicted) r.rates = {any_float_vector(in), any_float_vector(in), any_float_vector(in)};
  r.modelled = in.coin();
  if (r.modelled) r.model = model(in);
  return r;
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
  const Reply sent = reply(in);
  const DropReason drop = decode(carried(encoder.reply(sent), header), again);
  require(drop == expected(sent), "a reply is refused for what is wrong with it");
  if (drop != DropReason::none) return;
  require(same_but_model(sent, again), "a reply arrives as it was");
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
