#pragma once
// A person steers a tool with an input device: the present state of its axes and buttons, and
// the movement of the tool that follows from it. It uses no descriptor and no clock: time is an
// argument.

#include <linux/input.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "client/input_devices/event_node.hpp"
#include "core/base/types.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct SteeringOptions {
  double speed = 0.1;      // [m/s] of the tool at full deflection, in every direction
  double turn = 0.8;       // [rad/s] the same for rotation
  double dead_zone = 0.1;  // share of an axis's range that counts as rest; the kernel's value is
                           // used if it is larger
};
/// Throws std::invalid_argument that names the option and the remedy.
void validate(const SteeringOptions& options);

/// The buttons without a meaning of their own, in the order of their numbers, by the kernel's
/// names. Makers disagree about which of a pad's buttons is north and which is west.
inline constexpr std::array<unsigned, 4> kPadButtons = {BTN_SOUTH, BTN_EAST, BTN_NORTH, BTN_WEST};
inline constexpr std::array<unsigned, 2> kMouseButtons = {BTN_2, BTN_3};

/// The wanted movement of the tool. World frame of devices: x towards the person, y right, z up.
struct Steering {
  Vec3 velocity = Vec3::Zero();     // [m/s]
  Vec3 turn = Vec3::Zero();         // [rad/s]
  bool enabled = false;             // the person holds the enabling switch
  bool clutched = false;            // the person holds the clutch: the tool stands still
  std::optional<double> gripper{};  // [m] opening of the gripper, if there is a lever
  std::uint32_t buttons = 0;        // the others, a bit each (kPadButtons, kMouseButtons)
};

/// The axes and buttons of a gamepad or a 3D mouse, from its events. An event takes effect with the
/// SYN_REPORT that ends its packet. After SYN_DROPPED the state is read from the node again.
class InputState {
 public:
  /// `kind` is a result of input_kind(). Reads the present state from the kernel. Throws
  /// std::runtime_error with the remedy if axes are missing, or have no range.
  InputState(const EventNode& node, std::string_view kind, const SteeringOptions& options);

  /// Takes one event, received at `now`, a monotonic time. False: the state had to be read again,
  /// and the node is gone.
  bool take(const input_event& event, Nanoseconds now, const EventNode& node) noexcept;

  /// Returns the wanted movement at `now`. If a deflected device sends nothing, the tool stands
  /// still: after 0.1 s for relative axes, because these never report zero; after 2 s otherwise,
  /// because the device may be out of reach. The tool also stands still from the start until the
  /// device was at rest once.
  Steering steering(Nanoseconds now) noexcept;

 private:
  static constexpr std::size_t kSix = 6;  // x, y, z of movement, then of turning
  /// An axis of the input device that moves the tool.
  struct Axis {
    unsigned code = 0;
    double sign = 0.0;                 // 0: there is no such axis
    double middle = 0.0, reach = 1.0;  // in the kernel's units
    double rest = 0.0;                 // as a share of `reach`
  };
  struct Values {
    std::array<std::int32_t, ABS_CNT> axes{};
    InputKeys keys;
  };

  void lay_out(const EventNode& node, std::string_view kind, double dead_zone);
  Axis absolute(const EventNode& node, unsigned code, double sign, double dead_zone) const;
  void lay_out_gripper(const EventNode& node, const InputAxes& has, bool right_stick_turns);
  bool read_all(const EventNode& node) noexcept;
  void end_packet(Nanoseconds now) noexcept;
  double deflection(const Axis& axis, Nanoseconds now) const noexcept;

  SteeringOptions options_;
  std::array<Axis, kSix> layout_;
  unsigned enable_ = 0, clutch_ = 0;                  // buttons
  std::span<const unsigned> others_;                  // buttons
  std::optional<unsigned> trigger_;                   // the axis that closes the gripper
  double trigger_open_ = 0.0, trigger_closed_ = 1.0;  // in the kernel's units
  bool relative_ = false;

  Values values_, coming_;
  std::array<bool, 2> moved_{};            // relative axes in the present packet: move, turn
  std::array<Nanoseconds, 2> moved_at_{};  // the time of their last event
  bool dropped_ = false;                   // events were lost, and the packet has not ended
  bool rested_ = false;
  std::optional<Nanoseconds> heard_;  // the time of the last event
};

}  // namespace feltwire
