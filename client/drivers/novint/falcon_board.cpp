#include "client/drivers/novint/falcon_board.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace feltwire::falcon {
namespace {

constexpr std::uint8_t kFirst = '<', kLast = '>', kZero = 'A';
constexpr std::size_t kExtra = 13;  // index of the byte for lights (request) or buttons (reply)
constexpr std::uint8_t kHoming = 0x01;
constexpr unsigned kNibble = 0xF;

// [m] Dimensions of a leg that other users have measured: lengths of the arm, of the shin without
// its two joints, and of these joints together. The other values are offsets of the joints at the
// tool and at the base, along the leg and across it.
constexpr double kArm = 0.060, kShin = 0.1025, kJoints = 2.0 * 0.01125;
constexpr double kToolAlong = 0.01443, kToolAcross = -0.025, kBaseAlong = 0.0400,
                 kBaseAcross = -0.02309;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array<double, 3> kLegs = {105.0 * kDegree, -15.0 * kDegree, -135.0 * kDegree};
constexpr double kAtZero = 35.0 * kDegree;
constexpr double kScale = -10000.0;  // motor counts per N m at the arm
constexpr double kFastest = 60.0;    // [rad/s] largest speed of an arm; 3.6 m/s at the tool

/// Position (u, w) of a leg's wrist in the plane of its arm, and projected length of the shin in
/// this plane [m].
struct Leg {
  double u, w, shin;
  Vec3 of_u, of_shin;  // gradients of u and `shin` by the tool position; that of w is (0, 0, 1)
};

/// Returns leg `i` for the tool position p. Returns nothing if the wrist is farther from the leg's
/// plane than the length of the shin.
std::optional<Leg> leg(std::size_t i, const Vec3& p) noexcept {
  const double c = std::cos(kLegs[i]), s = std::sin(kLegs[i]);
  const double v = -s * p.x() + c * p.y() - kBaseAcross + kToolAcross;
  const double square = kShin * kShin - v * v;
  if (!(square > 0.0)) return std::nullopt;
  const double in_plane = std::sqrt(square);
  return Leg{.u = c * p.x() + s * p.y() - kBaseAlong + kToolAlong,
             .w = p.z(),
             .shin = kJoints + in_plane,
             .of_u = {c, s, 0.0},
             .of_shin = -v / in_plane * Vec3(-s, c, 0.0)};
}

bool is_digit(std::uint8_t byte) noexcept { return byte >= kZero && byte <= kZero + kNibble; }

}  // namespace

Packet request(const Counts& motors, Light light, bool homes) noexcept {
  Packet packet;
  packet.fill(kZero);
  packet.front() = kFirst;
  packet.back() = kLast;
  std::size_t at = 1;
  for (const int motor : motors)
    for (unsigned shift = 0; shift < 16; shift += 4)
      packet[at++] =
          static_cast<std::uint8_t>(kZero + (static_cast<unsigned>(motor) >> shift & kNibble));
  packet[kExtra] =
      static_cast<std::uint8_t>(kZero + (static_cast<unsigned>(light) | (homes ? kHoming : 0U)));
  return packet;
}

std::optional<BoardReply> parse_reply(const Packet& reply) noexcept {
  constexpr unsigned kButtons = 0xF;
  constexpr std::uint8_t kMostExtra = 0x7F;
  const bool framed = reply.front() == kFirst && reply.back() == kLast &&
                      std::all_of(reply.begin() + 1, reply.begin() + kExtra, is_digit);
  const unsigned extra = static_cast<unsigned>(reply[kExtra]) - kZero;
  if (!framed || extra > kMostExtra) return std::nullopt;
  BoardReply all;
  for (std::size_t i = 0; i < 3; ++i) {
    unsigned value = 0;
    for (std::size_t n = 4; n-- > 0;) value = value << 4 | (reply[1 + 4 * i + n] - kZero);
    all.encoders[i] = static_cast<std::int16_t>(value);
    all.homed[i] = (extra >> (4 + i) & 1U) != 0;
  }
  all.buttons = extra & kButtons;
  return all;
}

void Answer::add(std::span<const std::uint8_t> bytes) noexcept {
  for (const std::uint8_t byte : bytes) {
    if (size_ == kPacket || (size_ == 0 && byte != kFirst)) {
      garbled_ = true;
      return;
    }
    packet_[size_++] = byte;
  }
}

double arm_angle(int count) noexcept { return kAtZero + kCount * count; }

std::optional<Vec3> arm_angles(const Vec3& position) noexcept {
  Vec3 angles;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto l = leg(i, position);
    if (!l) return std::nullopt;
    // The distance from the end of the arm to the wrist at (u, w) is `shin`. The law of cosines
    // gives the angle of the arm.
    const double reach = std::hypot(l->u, l->w);
    const double cosine = (reach * reach + kArm * kArm - l->shin * l->shin) / (2.0 * kArm * reach);
    if (!(std::abs(cosine) < 1.0)) return std::nullopt;
    angles[static_cast<Eigen::Index>(i)] = std::atan2(l->w, l->u) - std::acos(cosine);
  }
  return angles;
}

std::optional<ToolPoint> tool_point(const Vec3& angles, const Vec3& near) noexcept {
  constexpr int kSteps = 12;
  constexpr double kExact = 1e-12;  // [m] length of the Newton step that ends the iteration
  constexpr double kStep = 0.1;     // [m] longest step; a longer step may find another solution
  constexpr double kSame = 1e-9;
  constexpr double kStretched = 1e-4;  // smallest determinant of `slope` divided by kArm^3
  // All positions in the maker's workspace, a cube of 100 mm, satisfy these limits.
  constexpr double kFarthest = 0.1;  // [m] largest distance from the centre of the workspace
  // [N] Largest tool force per N m at an arm, which is 50 mN per motor count.
  constexpr double kMostForce = 500.0;
  // [m/rad] Largest tool movement per arm angle, which is 0.5 mm per encoder count.
  constexpr double kMostWay = 0.75;
  ToolPoint tool{.position = near, .jacobian = Mat3::Zero()};
  for (int n = 0; n < kSteps; ++n) {
    Vec3 gap, turn;  // gap: g_i = |wrist - arm end|^2 - shin^2; turn: d g_i / d angle_i
    Mat3 slope;      // row i: gradient of g_i by the tool position
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto l = leg(static_cast<std::size_t>(i), tool.position);
      if (!l) return std::nullopt;
      const double c = std::cos(angles[i]), s = std::sin(angles[i]);
      const double u = l->u - kArm * c, w = l->w - kArm * s;
      gap[i] = u * u + w * w - l->shin * l->shin;
      slope.row(i) = 2.0 * (u * l->of_u + w * Vec3::UnitZ() - l->shin * l->of_shin).transpose();
      turn[i] = 2.0 * kArm * (l->u * s - l->w * c);
    }
    const double size = slope.determinant() / (kArm * kArm * kArm);
    if (!(std::abs(size) > kStretched)) return std::nullopt;
    const Mat3 inverse = slope.inverse();
    const Vec3 step = inverse * gap;
    if (!(step.norm() < kStep)) return std::nullopt;
    tool.position -= step;
    if (step.norm() > kExact) continue;
    tool.jacobian = -inverse * turn.asDiagonal();
    const Vec3 forces = slope.rowwise().norm().cwiseQuotient(turn.cwiseAbs());
    if (!((tool.position - kMiddle).norm() < kFarthest && forces.maxCoeff() < kMostForce &&
          tool.jacobian.cwiseAbs().maxCoeff() < kMostWay))
      return std::nullopt;
    // Refuse a solution in which a leg bends the wrong way.
    const auto back = arm_angles(tool.position);
    if (!back || !back->isApprox(angles, kSame)) return std::nullopt;
    return tool;
  }
  return std::nullopt;
}

Counts motors_of(const ToolPoint& tool, const Vec3& force, int most) noexcept {
  const Vec3 wanted = kScale * (tool.jacobian.transpose() * force);
  if (!wanted.allFinite()) return {};
  const double largest = wanted.cwiseAbs().maxCoeff();
  const double share = largest > most ? most / largest : 1.0;
  Counts counts{};
  for (Eigen::Index i = 0; i < 3; ++i)
    counts[static_cast<std::size_t>(i)] = static_cast<int>(std::trunc(share * wanted[i]));
  return counts;
}

Vec3 force_of(const ToolPoint& tool, const Counts& motors) noexcept {
  const Vec3 torque = Vec3(motors[0], motors[1], motors[2]) / kScale;
  return tool.jacobian.transpose().inverse() * torque;
}

bool TrackedTool::take(const Counts& encoders, Nanoseconds now) noexcept {
  if (taken_at_) {
    const double most = kFastest * seconds(now - *taken_at_) / kCount;
    for (std::size_t i = 0; i < 3; ++i)
      if (std::abs(encoders[i] - encoders_[i]) > most) return false;
  }
  const Vec3 angles(arm_angle(encoders[0]), arm_angle(encoders[1]), arm_angle(encoders[2]));
  auto found = tool_point(angles, point_.position);
  if (!found) found = tool_point(angles, kMiddle);
  if (!found) found = tool_point(angles, kFarOut);
  if (!found) return false;
  taken_at_ = now;
  encoders_ = encoders;
  point_ = *found;
  return true;
}

}  // namespace feltwire::falcon
