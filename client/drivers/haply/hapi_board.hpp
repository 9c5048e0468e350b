#pragma once
// The frames of the 2-dof open board (hAPI) on its serial port, and the geometry of the pantograph
// that its motors move. This file has only bytes and geometry: no port and no clock.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace feltwire::hapi {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

/// The number of the device with the pantograph's two motors, which are at the ports 1 and 2 of the
/// board.
inline constexpr std::uint8_t kDevice = 5;
inline constexpr std::size_t kSetupBytes = 18, kTorqueBytes = 10;
inline constexpr std::size_t kSetupReplyBytes = 5, kAngleReplyBytes = 9;

/// Builds the frame that configures the encoders: the arms stand at 180 and 0 degrees now.
std::array<std::uint8_t, kSetupBytes> setup_frame() noexcept;
/// Builds the frame that sets both torques, in the board's own unit, and asks for the angles.
std::array<std::uint8_t, kTorqueBytes> torque_frame(const Vec2& torque) noexcept;

/// Collects the bytes of the answer to one frame.
class Reply {
 public:
  void clear() noexcept { size_ = 0; }
  /// Takes bytes. It counts also those that do not fit.
  void add(std::span<const std::uint8_t> bytes) noexcept;
  std::size_t size() const noexcept { return size_; }
  /// True if there were too many bytes, or bytes of another device. Then no later byte can be
  /// trusted.
  bool garbled(std::size_t expected) const noexcept;
  /// Returns the angles of both arms [rad]. Empty if the answer is incomplete or garbled, or if no
  /// arm can have these angles.
  std::optional<Vec2> angles() const noexcept;

 private:
  std::array<std::uint8_t, kAngleReplyBytes> bytes_{};
  std::size_t size_ = 0;
};

/// The tool of the pantograph in the maker's axes. The origin is the shaft of the first motor.
struct ToolPoint {
  Vec2 position;  // [m]
  Mat2 jacobian;  // [m/rad] of the position by the two angles
};

/// Empty if the elbows meet: the lower links can then turn freely about them.
std::optional<ToolPoint> tool_point(const Vec2& angles) noexcept;

/// Returns the torques in the board's unit for a force [N] at the tool in the maker's axes. The
/// unit is the maker's own and is not calibrated.
Vec2 torque_of(const ToolPoint& tool, const Vec2& force) noexcept;

}  // namespace feltwire::hapi
