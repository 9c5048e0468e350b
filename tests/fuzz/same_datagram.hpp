#pragma once
// Compares two datagrams to the bit.

#include "protocol/wire/scene_view.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/same_robot.hpp"

namespace feltwire::fuzz {

inline bool same(const std::optional<HandTimes>& a, const std::optional<HandTimes>& b) {
  if (a.has_value() != b.has_value()) return false;
  return !a || (a->wakeups == b->wakeups && a->round_trips == b->round_trips);
}

inline bool same(const SampleBatch& a, const SampleBatch& b) {
  if (a.count != b.count || a.rotation != b.rotation || a.previous != b.previous ||
      a.report.has_value() != b.report.has_value() || !same(a.lead, b.lead))
    return false;
  if (a.report &&
      !(a.report->reasons == b.report->reasons && a.report->has_account == b.report->has_account &&
        same(a.report->balance, b.report->balance) &&
        same(a.report->round_trip, b.report->round_trip) &&
        same(a.report->hand_damping, b.report->hand_damping) &&
        a.report->change == b.report->change &&
        a.report->change_refused == b.report->change_refused &&
        a.report->late_ticks == b.report->late_ticks && same(a.report->times, b.report->times)))
    return false;
  for (int i = 0; i < a.count; ++i) {
    const Sample &x = a.samples[static_cast<std::size_t>(i)],
                 &y = b.samples[static_cast<std::size_t>(i)];
    if (x.index != y.index || x.client_time != y.client_time ||
        !same(x.pose.position, y.pose.position) || !same(x.pose.orientation, y.pose.orientation) ||
        !same(x.held, y.held))
      return false;
  }
  return true;
}

inline bool same(const std::optional<ClientChange>& a, const std::optional<ClientChange>& b) {
  if (a.has_value() != b.has_value()) return false;
  if (!a) return true;
  const auto same_link = [](const LinkQuality& x, const LinkQuality& y) {
    return same(x.delay, y.delay) && same(x.jitter, y.jitter) && same(x.loss, y.loss);
  };
  return a->number == b->number && a->law == b->law && a->link.has_value() == b->link.has_value() &&
         (!a->link || same_link(*a->link, *b->link));
}

/// Compares all but the model.
inline bool same_but_model(const Reply& a, const Reply& b) {
  return a.sample_index == b.sample_index && a.client_time == b.client_time &&
         a.server_times.received == b.server_times.received &&
         a.server_times.sent == b.server_times.sent && same(a.command, b.command) &&
         a.rotation == b.rotation && same(a.delivered.elastic, b.delivered.elastic) &&
         same(a.delivered.frictional, b.delivered.frictional) &&
         same(a.delivered.torque, b.delivered.torque) && same(a.bound.ratio, b.bound.ratio) &&
         a.bound.active == b.bound.active && a.bound.saturated == b.bound.saturated &&
         a.bound.refused == b.bound.refused && a.gap == b.gap && a.reloads == b.reloads &&
         a.withheld == b.withheld && a.predicted == b.predicted && same(a.rates, b.rates) &&
         a.modelled == b.modelled && a.normals.count == b.normals.count &&
         a.normals.unit == b.normals.unit && same(a.remote, b.remote) && same(a.change, b.change);
}

inline bool same(const Pose& a, const Pose& b) {
  return same(a.position, b.position) && same(a.orientation, b.orientation);
}
inline bool same(const HandFigures& a, const HandFigures& b) {
  return a.samples == b.samples && a.missed == b.missed && same(a.proxy, b.proxy) &&
         same(a.elastic, b.elastic) && same(a.frictional, b.frictional) && same(a.depth, b.depth) &&
         same(a.delivered, b.delivered) && same(a.burned, b.burned) && a.states == b.states &&
         a.tool == b.tool && a.report.has_value() == b.report.has_value() &&
         (!a.report || (a.report->reasons == b.report->reasons &&
                        a.report->has_account == b.report->has_account &&
                        same(a.report->balance, b.report->balance) &&
                        same(a.report->round_trip, b.report->round_trip)));
}
/// Compares the hands, bodies and robots of both views.
inline bool same(const SceneView& a, const SceneView& b) {
  if (a.present != b.present) return false;
  if (!a.present) return true;
  const auto hand = [](const SeenHand& x, const SeenHand& y) {
    return x.number == y.number && same(x.pose, y.pose) && same(x.force, y.force) &&
           x.figures.has_value() == y.figures.has_value() &&
           (!x.figures || same(*x.figures, *y.figures));
  };
  const auto body = [](const SeenBody& x, const SeenBody& y) {
    return x.object == y.object && same(x.pose, y.pose);
  };
  return a.hands_from == b.hands_from && a.hands_end == b.hands_end &&
         a.bodies_from == b.bodies_from && a.bodies_end == b.bodies_end &&
         std::ranges::equal(a.hands(), b.hands(), hand) &&
         std::ranges::equal(a.bodies(), b.bodies(), body);
}

inline constexpr double kFloatRounding = 0x1p-23;  // relative, of float32 on the wire

inline bool near(double a, double b) { return std::abs(a - b) <= kFloatRounding * std::abs(a); }
inline bool near(const Vec3& a, const Vec3& b) {
  return near(a.x(), b.x()) && near(a.y(), b.y()) && near(a.z(), b.z());
}
inline bool near(const std::optional<HandFigures>& a, const std::optional<HandFigures>& b) {
  if (a.has_value() != b.has_value()) return false;
  if (!a) return true;
  return a->samples == b->samples && a->states == b->states && a->tool == b->tool &&
         near(a->proxy, b->proxy) && near(a->elastic, b->elastic) && near(a->depth, b->depth) &&
         a->report.has_value() == b->report.has_value() &&
         (!a->report || (a->report->has_account == b->report->has_account &&
                         near(a->report->balance, b->report->balance)));
}
/// Compares points within metres of a center that is within kilometres.
inline bool near_point(const Vec3& a, const Vec3& b) {
  return (a - b).cwiseAbs().maxCoeff() <= 4.0 * kFloatRounding;
}
inline bool near(const SurfacePatch& a, const SurfacePatch& b) {
  const Material &m = a.material, &n = b.material;
  return near_point(a.point, b.point) && near_point(a.anchor, b.anchor) &&
         near(a.normal, b.normal) && near(a.axis, b.axis) && near(a.velocity, b.velocity) &&
         near(a.curvature, b.curvature) && near(a.radius, b.radius) &&
         near(m.stiffness, n.stiffness) && near(m.damping, n.damping) &&
         near(m.static_friction, n.static_friction) &&
         near(m.dynamic_friction, n.dynamic_friction) &&
         near(m.viscous_friction, n.viscous_friction) && a.touching == b.touching &&
         a.slipping == b.slipping && a.joined == b.joined && a.object == b.object &&
         a.feature == b.feature;
}
inline bool near(const LocalModel& a, const LocalModel& b) {
  if (a.count != b.count || a.scene != b.scene || !same(a.center, b.center) ||
      !near(a.reach, b.reach))
    return false;
  for (std::size_t i = 0; i < a.view().size(); ++i)
    if (!near(a.patches[i], b.patches[i])) return false;
  return true;
}

}  // namespace feltwire::fuzz
