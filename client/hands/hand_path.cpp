#include "client/hands/hand_path.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/base/enum_names.hpp"
#include "core/base/splitmix.hpp"

namespace feltwire {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

double uniform(std::uint64_t& state) {
  return static_cast<double>(splitmix::mix(state += splitmix::kStep) >> 11) * 0x1.0p-53;
}

}  // namespace

double smoothstep(double s) noexcept {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * (3.0 - 2.0 * s);
}

HandPath hand_path(std::string_view given) {
  return enum_from_name<HandPath>("path", given, kHandPathNames);
}

void go_round(HandTask& task, double radius) {
  task.path = HandPath::orbit;
  task.normal = Vec3::UnitY();
  task.radius = radius - task.depth;
  task.depth = 0.0;
  task.frequency = 0.25;
}

void set_normal(HandTask& task, const Vec3& normal) {
  task.normal = normal;
  // Use the x axis, or the y axis if the normal is almost parallel to x.
  task.along = std::abs(normal.x()) > 0.9 * normal.norm() ? Vec3::UnitY() : Vec3::UnitX();
}

IntendedMotion::IntendedMotion(const HandTask& task) : task_(task) {
  const bool finite = task.center.allFinite() && task.normal.allFinite() &&
                      task.along.allFinite() && std::isfinite(task.radius) &&
                      std::isfinite(task.frequency) && std::isfinite(task.depth) &&
                      std::isfinite(task.clearance) && std::isfinite(task.tremor) &&
                      std::isfinite(task.speed) && std::isfinite(task.air);
  if (!finite) throw std::invalid_argument("the hand's task has a number that is not finite");
  if (!(task.lead_in > 0.0))
    throw std::invalid_argument("the hand's lead-in must be above zero [s]");
  task_.normal.normalize();
  task_.along -= task_.along.dot(task_.normal) * task_.normal;
  if (!(task_.normal.norm() > 0.5) || !(task_.along.norm() > 1e-9))
    throw std::invalid_argument("the hand's normal and along must not be zero or parallel");
  task_.along.normalize();
  across_ = task_.normal.cross(task_.along);

  std::uint64_t state = task.seed;
  for (auto& axis : tremor_)
    for (auto& tone : axis) tone = {8.0 + 4.0 * uniform(state), kTurn * uniform(state)};
}

/// Returns the intended position at the time t [s]. Until the time `air`, the hand moves away from
/// the surface and back once per second. Then it begins its path.
Vec3 IntendedMotion::position(double t) const noexcept {
  if (t >= task_.air) return with_tremor(on_path(t - task_.air), t);
  constexpr double kOut = 0.06;  // [m] distance of the movement away from the surface
  const bool from_circle = task_.path == HandPath::orbit && task_.depth == 0.0;
  const Vec3& outward = from_circle ? task_.along : task_.normal;
  const double out = 0.5 * kOut * (1.0 - std::cos(kTurn * t));
  return with_tremor(on_path(0.0) + out * outward, t);
}

/// Adds the tremor along each axis: three sine waves. Three sine waves of amplitude a have together
/// the RMS value a sqrt(3/2).
Vec3 IntendedMotion::with_tremor(Vec3 p, double t) const noexcept {
  if (!(task_.tremor > 0.0)) return p;
  const double amplitude = task_.tremor * std::sqrt(2.0 / kTones);
  for (int i = 0; i < 3; ++i)
    for (const Tone& tone : tremor_[static_cast<std::size_t>(i)])
      p[i] += amplitude * std::sin(kTurn * tone.frequency * t + tone.phase);
  return p;
}

Vec3 IntendedMotion::on_path(double t) const noexcept {
  const double angle = kTurn * task_.frequency * t;
  const double outside = task_.clearance * (1.0 - smoothstep(t / task_.lead_in));
  const double in = smoothstep(t / task_.lead_in);
  Vec3 p = task_.center;
  switch (task_.path) {
    case HandPath::press:
      p += (outside - in * task_.depth) * task_.normal;
      break;
    case HandPath::slide:
      p += (outside - in * task_.depth) * task_.normal +
           task_.radius * std::sin(angle) * task_.along;
      break;
    case HandPath::orbit: {
      // The hand approaches a flat surface along the normal. It approaches a ball (depth 0) from
      // outside the circle.
      const double radius = task_.radius + (task_.depth == 0.0 ? outside : 0.0);
      const double height = task_.depth == 0.0 ? 0.0 : outside - in * task_.depth;
      p += radius * (std::cos(angle) * task_.along + std::sin(angle) * across_) +
           height * task_.normal;
      break;
    }
    case HandPath::figure_eight:
      p += (outside - in * task_.depth) * task_.normal +
           task_.radius * (std::sin(angle) * task_.along + 0.5 * std::sin(2.0 * angle) * across_);
      break;
    case HandPath::taps: {
      const double half = 0.5 * (task_.clearance + task_.depth);
      p += (task_.clearance - half + half * std::cos(angle)) * task_.normal;
      break;
    }
    case HandPath::strike: {
      // Relative time; `way` is the integral of a smoothstep speed.
      const double s = std::min(1.0, t / task_.lead_in);
      const double way = task_.speed * (task_.lead_in * (s * s * s - 0.5 * s * s * s * s) +
                                        std::max(0.0, t - task_.lead_in));
      const double start = task_.clearance + 0.5 * task_.speed * task_.lead_in;
      p += std::max(-task_.depth, start - way) * task_.normal;
      break;
    }
  }
  return p;
}

}  // namespace feltwire
