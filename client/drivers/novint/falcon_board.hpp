#pragma once
// The packets of the Falcon's firmware, and the geometry of its three legs. No USB, no clock: bytes
// and geometry.

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <span>

#include "core/base/types.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire::falcon {

using Counts = std::array<int, 3>;  // of the encoders, or of the motors, a leg each

inline constexpr std::size_t kPacket = 16;
using Packet = std::array<std::uint8_t, kPacket>;

enum class Light : std::uint8_t { none = 0, red = 2, green = 4, blue = 8 };

/// Sets the motors and asks for the encoders. Each number must be within 16 bits. `homes`: the
/// firmware looks for the encoders' zero.
Packet request(const Counts& motors, Light light, bool homes) noexcept;

struct BoardReply {
  Counts encoders{};
  std::uint32_t buttons = 0;  // a bit each, four of them
  std::array<bool, 3> homed{};
};
/// None: it is no answer of this firmware.
std::optional<BoardReply> parse_reply(const Packet& reply) noexcept;

/// Collects the answer from what comes in pieces. A byte that cannot stand where it stands makes it
/// garbled: nothing that follows can be trusted.
class Answer {
 public:
  void clear() noexcept { size_ = 0, garbled_ = false; }
  void add(std::span<const std::uint8_t> bytes) noexcept;
  bool whole() const noexcept { return size_ == kPacket && !garbled_; }
  bool garbled() const noexcept { return garbled_; }
  const Packet& packet() const noexcept { return packet_; }

 private:
  Packet packet_{};
  std::size_t size_ = 0;
  bool garbled_ = false;
};

/// [rad] of a leg's upper arm, by its encoder.
double arm_angle(int count) noexcept;
/// [rad] of the arm, a count of the encoder: 320 slots, read four times, on a shaft of 14.25 mm
/// that turns a sector of 110 mm.
inline constexpr double kCount = 2.0 * std::numbers::pi / (4.0 * 320.0) * (14.25 / 110.0);

/// The tool, in the maker's axes: x right, y up, z towards the user, from the middle of the legs.
struct ToolPoint {
  Vec3 position;  // [m]
  Mat3 jacobian;  // [m/rad] of the position by the angles of the three arms
};

/// Solves the three legs' equations, |knee - wrist| = the shin's length, by Newton's method from
/// `near` [m], to 1e-12 m. None: there is no such place, Newton's method does not find it from
/// there, it is more than 100 mm from the middle, or a leg is so straight there that a count of its
/// motor is more than 50 mN, or a count of an encoder more than 0.5 mm.
/// After R. E. Stamper, "A three degree of freedom parallel manipulator with only translational
/// degrees of freedom", PhD thesis 97-4, University of Maryland, 1997.
std::optional<ToolPoint> tool_point(const Vec3& angles, const Vec3& near) noexcept;
/// The angles [rad] of the arms with which the tool is there; none: no leg reaches.
std::optional<Vec3> arm_angles(const Vec3& position) noexcept;
/// A place [m] in the middle of the workspace.
inline const Vec3 kMiddle{0.0, 0.0, 0.12};
/// And near its end: from here the corners are found that are not from the middle.
inline const Vec3 kFarOut{0.0, 0.0, 0.16};

/// The motors' numbers of a force [N] at the tool: -10000 J^T F, cut to `most` with all three in
/// proportion and rounded towards zero; zeros for a force that is not finite. The scale is what
/// others use; it is not calibrated.
inline constexpr int kMostMotor = 4096;
Counts motors_of(const ToolPoint& tool, const Vec3& force, int most = kMostMotor) noexcept;
/// [N] of these.
Vec3 force_of(const ToolPoint& tool, const Counts& motors) noexcept;

/// The tool by the newest answer. Time is an argument.
class TrackedTool {
 public:
  /// False: no arm moves like this since the answer before, or there is no such place. Then nothing
  /// changes.
  bool take(const Counts& encoders, Nanoseconds now) noexcept;
  /// The next answer may be of any place.
  void forget() noexcept { taken_at_.reset(); }
  const ToolPoint& point() const noexcept { return point_; }

 private:
  ToolPoint point_{.position = kMiddle, .jacobian = Mat3::Zero()};
  Counts encoders_{};
  std::optional<Nanoseconds> taken_at_;
};

}  // namespace feltwire::falcon
