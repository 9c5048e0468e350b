#include "client/drivers/haply/hapi_board.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <numbers>

namespace feltwire::hapi {
namespace {

constexpr std::uint8_t kPorts = 0b0011;  // bit mask of the ports 1 and 2
// Kinds of a frame. The kind is in the bits above the port bits of the same byte.
constexpr std::uint8_t kSetup = 0x00, kTorques = 0x10;
constexpr float kCountsPerTurn = 13824.0F;                     // counts per turn of an encoder
constexpr std::array<float, 2> kSetupAngles = {180.0F, 0.0F};  // [deg] arm angles at the setup
constexpr double kMostTurned = 720.0;                          // [deg] largest angle of an arm
// [m] Lengths of the upper and lower link, and distance between the motor shafts.
constexpr double kUpper = 0.05, kLower = 0.07, kApart = 0.02;
constexpr double kGain = 0.1;      // board torque for a force of 1 N at a lever of one upper link
constexpr double kNearest = 2e-3;  // [m] smallest distance between the elbows
constexpr double kDegree = std::numbers::pi / 180.0;

static_assert(std::endian::native == std::endian::little, "frames are little-endian");

void put(float value, std::span<std::uint8_t> bytes) noexcept {
  std::memcpy(bytes.data(), &value, sizeof value);
}

}  // namespace

std::array<std::uint8_t, kSetupBytes> setup_frame() noexcept {
  std::array<std::uint8_t, kSetupBytes> frame{kSetup | kPorts, kDevice};
  std::span<std::uint8_t> rest = std::span(frame).subspan(2);
  for (const float angle : kSetupAngles)
    for (const float value : {angle, kCountsPerTurn}) {
      put(value, rest);
      rest = rest.subspan(sizeof value);
    }
  return frame;
}

std::array<std::uint8_t, kTorqueBytes> torque_frame(const Vec2& torque) noexcept {
  std::array<std::uint8_t, kTorqueBytes> frame{kTorques | kPorts, kDevice};
  put(static_cast<float>(torque.x()), std::span(frame).subspan(2));
  put(static_cast<float>(torque.y()), std::span(frame).subspan(2 + sizeof(float)));
  return frame;
}

void Reply::add(std::span<const std::uint8_t> bytes) noexcept {
  const std::span<std::uint8_t> room = std::span(bytes_).subspan(std::min(size_, bytes_.size()));
  std::copy_n(bytes.begin(), std::min(bytes.size(), room.size()), room.begin());
  size_ += bytes.size();
}

bool Reply::garbled(std::size_t expected) const noexcept {
  return size_ > expected || (size_ > 0 && bytes_.front() != kDevice);
}

std::optional<Vec2> Reply::angles() const noexcept {
  if (size_ != kAngleReplyBytes || garbled(kAngleReplyBytes)) return std::nullopt;
  std::array<float, 2> degrees{};
  std::memcpy(degrees.data(), bytes_.data() + 1, sizeof degrees);
  const Vec2 told(static_cast<double>(degrees[0]), static_cast<double>(degrees[1]));
  if (!told.allFinite() || told.cwiseAbs().maxCoeff() > kMostTurned) return std::nullopt;
  return kDegree * told;
}

/// Computes the tool position and its jacobian from the arm angles. The tool is one lower link away
/// from both elbows a and b, on the far side of the shafts.
std::optional<ToolPoint> tool_point(const Vec2& angles) noexcept {
  const Vec2 along_a(std::cos(angles.x()), std::sin(angles.x()));
  const Vec2 along_b(std::cos(angles.y()), std::sin(angles.y()));
  const Vec2 a = kUpper * along_a, b = Vec2(kApart, 0.0) + kUpper * along_b;
  const Vec2 between = b - a;
  const double half = 0.5 * between.norm();
  if (!(2.0 * half > kNearest)) return std::nullopt;
  const Vec2 across = Vec2(-between.y(), between.x()) / (2.0 * half);
  const Vec2 tool = 0.5 * (a + b) + std::sqrt(kLower * kLower - half * half) * across;

  // The lower links have constant length, so (tool - a) (d tool - d a) = 0 as a dot product. This
  // equation also holds for b.
  Mat2 links;
  links << (tool - a).transpose(), (tool - b).transpose();
  const Vec2 turned_a = kUpper * Vec2(-along_a.y(), along_a.x());
  const Vec2 turned_b = kUpper * Vec2(-along_b.y(), along_b.x());
  const Vec2 pull((tool - a).dot(turned_a), (tool - b).dot(turned_b));
  return ToolPoint{tool, links.inverse() * pull.asDiagonal().toDenseMatrix()};
}

Vec2 torque_of(const ToolPoint& tool, const Vec2& force) noexcept {
  return kGain / kUpper * (tool.jacobian.transpose() * force);
}

}  // namespace feltwire::hapi
