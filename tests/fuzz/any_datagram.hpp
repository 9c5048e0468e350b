#pragma once
// Makes datagram values (samples, replies, views) from a fuzzer's bytes.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/scene_view.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace feltwire::fuzz {

inline Vec3 any_vector(Input& in) {
  const double x = in.any_double(), y = in.any_double(), z = in.any_double();
  return {x, y, z};
}
inline Vec3 any_float_vector(Input& in) {
  const double x = in.any_float(), y = in.any_float(), z = in.any_float();
  return {x, y, z};
}

inline Quaternion orientation(Input& in) {
  const Quaternion q(in.number(1.0), in.number(1.0), in.number(1.0), in.number(1.0));
  return q.squaredNorm() > 0.0 ? q.normalized() : Quaternion::Identity();
}

/// Mostly a possible batch of a client, and sometimes any batch.
inline SampleBatch batch(Input& in) {
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
                  .gripper = in.any_float(),
                  .seat = in.byte()};
  return b;
}

/// Numbers that float32 represents exactly.
inline RemoteContact contact(Input& in) {
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

inline OtherSurfaces others(Input& in) {
  OtherSurfaces o;
  for (int i = in.byte() % (OtherSurfaces::kMost + 1); i > 0; --i) {
    RemoteContact c = contact(in);
    if (c.surface == 0) break;
    c.touching = false;
    o.surfaces[static_cast<std::size_t>(o.count++)] = c;
  }
  return o;
}

inline EnergyCounters energy(Input& in) {
  return {in.any_double(), in.any_double(), in.any_double()};
}

inline double at_least_zero(Input& in, double size) { return std::abs(in.number(size)); }

inline SurfacePatch patch(Input& in, const Vec3& center) {
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
  p.whole = in.coin();
  return p;
}

inline LocalModel model(Input& in) {
  LocalModel m;
  m.center = in.vector(kMaxPosition);
  m.reach = at_least_zero(in, 1.0);
  m.scene = in.whole<std::uint32_t>();
  m.surfaces = 1u + in.byte();
  m.count = in.byte() % (kMaxPatches + 1);
  for (int i = 0; i < m.count; ++i) m.patches[static_cast<std::size_t>(i)] = patch(in, m.center);
  return m;
}

/// Numbers that 16 bits represent exactly, except the root of a covariance.
inline BodyModel body(Input& in) {
  BodyModel m;
  m.scene = in.whole<std::uint32_t>();
  m.solids = in.coin() ? in.whole<std::uint32_t>() : 0;
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
/// Mostly a possible change: any name, any link.
inline ClientChange change(Input& in) {
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
inline Reply reply(Input& in) {
  Reply r;
  r.sample_index = in.whole<std::uint64_t>();
  r.client_time = Nanoseconds(in.whole<std::int64_t>());
  r.server_times.received = Nanoseconds(in.whole<std::int64_t>());
  r.server_times.sent = Nanoseconds(in.whole<std::int64_t>());
  r.command = {any_vector(in), any_vector(in), Vec3::Zero()};
  r.rotation = in.coin();
  if (r.rotation) r.command.torque = any_vector(in);
  r.delivered = {in.any_double(), in.any_double(), in.any_double()};
  r.bound.ratio = in.any_float();
  const unsigned flags = in.byte();
  r.bound.active = (flags & 1u) != 0;
  r.bound.saturated = (flags & 2u) != 0;
  r.bound.refused = (flags & 4u) != 0;
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
                      .seat = in.byte(),
                      .meets_surfaces = in.coin(),
                      .pose = {in.vector(kMaxPosition), orientation(in)},
                      .contact = contact(in),
                      .others = others(in),
                      .energy = energy(in),
                      .gripper = in.any_float(),
                      .gripper_force = in.any_float(),
                      .age = in.any_float()};
  if (r.remote && in.coin()) r.remote->turn = any_float_vector(in);
  for (int i = in.byte() % 4; i > 0; --i)
    r.normals.add((in.coin() ? 1.0 : -1.0) * Vec3::Unit(in.byte() % 3));
  if (r.normals.count < 2) r.normals = {};  // a single normal is not sent
  if (in.coin()) r.change = change(in);
  return r;
}

inline Pose seen_pose(Input& in) {
  const Vec3 position = in.vector(kMaxPosition);
  return {position, orientation(in)};
}

inline HandFigures figures(Input& in) {
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

/// Mostly as many hands and bodies as fit.
inline SceneView view(Input& in) {
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
  if (in.byte() == 0) std::swap(v.hands_from, v.hands_end);  // no server sends it
  return v;
}

}  // namespace feltwire::fuzz
