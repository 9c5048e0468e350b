#pragma once
// How a person steers a tool with an input device: what its axes and buttons are now, and which
// movement of the tool they mean. No descriptor, no clock: time is an argument.

#include <linux/input.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "client/devices/event_node.hpp"
#include "core/base/types.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct SteeringOptions {
  double speed = 0.1;      // [m/s] of the tool at full deflection, in whatever direction
  double turn = 0.8;       // [rad/s] likewise
  double dead_zone = 0.1;  // share of the way of an axis that counts as rest; the kernel's where
                           // that is more
};
/// Throws std::invalid_argument with the option's name and the remedy.
void validate(const SteeringOptions& options);

/// What the tool shall do. World frame of devices: x towards the person, y right, z up.
struct Steering {
  Vec3 velocity = Vec3::Zero();     // [m/s]
  Vec3 turn = Vec3::Zero();         // [rad/s]
  bool enabled = false;             // the enabling switch is held
  bool clutched = false;            // the clutch is held: the tool stands still
  std::optional<double> gripper{};  // [m] opening, of a lever
};

/// The axes and buttons of a gamepad or a 3D mouse, as its events tell them. Events count from the
/// SYN_REPORT that ends their packet on. After SYN_DROPPED the state is read from the node anew.
class InputState {
 public:
  /// `kind` as input_kind() names it. Reads what the kernel knows. Throws std::runtime_error with
  /// the remedy where axes are missing, or have no range.
  InputState(const EventNode& node, std::string_view kind, const SteeringOptions& options);

  /// One event, which came at `now`, a monotonic time. False: the state had to be read anew, and
  /// the node is not there any more.
  bool take(const input_event& event, Nanoseconds now, const EventNode& node) noexcept;

  /// What it means at `now`. A device that tells nothing while it is deflected stands still: after
  /// 0.1 s where its axes are relative, for these never tell zero; after 2 s otherwise, for it may
  /// be out of reach. It also does so from the start until it was at rest once.
  Steering steering(Nanoseconds now) noexcept;

 private:
  static constexpr std::size_t kSix = 6;  // x, y, z of movement, then of turning
  /// An axis of the input device that moves the tool.
  struct Axis {
    unsigned code = 0;
    double sign = 0.0;                 // 0: it has none for this
    double middle = 0.0, reach = 1.0;  // in the kernel's numbers
    double rest = 0.0;                 // share of the reach
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
  std::optional<unsigned> trigger_;                   // axis that closes the gripper
  double trigger_open_ = 0.0, trigger_closed_ = 1.0;  // in the kernel's numbers
  bool relative_ = false;

  Values values_, coming_;
  std::array<bool, 2> moved_{};            // relative axes in the packet that comes: move, turn
  std::array<Nanoseconds, 2> moved_at_{};  // likewise, when told last
  bool dropped_ = false;                   // events were lost, and the packet has not ended
  bool rested_ = false;
  std::optional<Nanoseconds> heard_;  // when something came last
};

}  // namespace feltwire
