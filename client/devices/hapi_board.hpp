#pragma once
// The frames of the 2-dof open board (hAPI) on its serial port, and the geometry of the pantograph
// that its motors move. No port, no clock: bytes and geometry.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace feltwire::hapi {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

/// The number of the device that has the pantograph's two motors, at the ports 1 and 2 of the
/// board.
inline constexpr std::uint8_t kDevice = 5;
inline constexpr std::size_t kSetupBytes = 18, kTorqueBytes = 10;
inline constexpr std::size_t kSetupReplyBytes = 5, kAngleReplyBytes = 9;

/// Tells the board its encoders: from now on the arms stand at 180 and 0 degrees.
std::array<std::uint8_t, kSetupBytes> setup_frame() noexcept;
/// Sets both torques, in the board's own unit, and asks for the angles.
std::array<std::uint8_t, kTorqueBytes> torque_frame(const Vec2& torque) noexcept;

/// Collects the bytes that answer one frame.
class Reply {
 public:
  void clear() noexcept { size_ = 0; }
  /// Takes bytes; those for which there is no room are counted all the same.
  void add(std::span<const std::uint8_t> bytes) noexcept;
  std::size_t size() const noexcept { return size_; }
  /// More than the answer, or not of this device: nothing that follows can be trusted.
  bool garbled(std::size_t expected) const noexcept;
  /// Of both arms [rad]; none where the answer is not whole, is garbled, or tells angles that no
  /// arm can have.
  std::optional<Vec2> angles() const noexcept;

 private:
  std::array<std::uint8_t, kAngleReplyBytes> bytes_{};
  std::size_t size_ = 0;
};

/// The tool of the pantograph, in the maker's axes, from the shaft of the first motor.
struct ToolPoint {
  Vec2 position;  // [m]
  Mat2 jacobian;  // [m/rad] of the position by the two angles
};

/// None where the elbows meet: the lower links then turn about them as they like.
std::optional<ToolPoint> tool_point(const Vec2& angles) noexcept;

/// In the board's unit, of a force [N] at the tool in the maker's axes. The unit is the maker's own
/// and is not calibrated.
Vec2 torque_of(const ToolPoint& tool, const Vec2& force) noexcept;

}  // namespace feltwire::hapi
