#pragma once
// A haptic device in a simulated hand. Another thread points to its target with a mouse, a finger
// on a screen, or a gamepad.

#include "client/hands/hand_device.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// A message to the hand: go to a target, or release.
struct PointerMessage {
  enum class Kind : std::uint8_t { to, let_go };
  Kind kind = Kind::to;
  Vec3 target = Vec3::Zero();  // [m] target of the hand, world frame; for `to`
};

struct PointerHandOptions {
  DeviceSpec spec;
  Hand hand;
  double speed = 0.5;   // [m/s] largest speed of the intended place
  double reach = 0.02;  // [m] largest distance from the hand to the intended place: it presses with
                        // stiffness * reach
  double smoothing = 0.015;  // [s] time constant towards a target, for targets that come in steps
  double patience = 1.0;     // [s] the hand is released after this time without a message
  double beginning = 5.0;    // [s] no release for a missing message in this time: a browser that
                             // draws a hand for the first time may pause for seconds
  double clearance = 0.02;   // [m] distance from the surface of the place where begin() puts it
};

/// The intended place of the hand follows the newest target smoothly, with at most the speed of the
/// options, also if the target jumps. The device ends (DeviceReading::ended) on a release message,
/// or if no message comes for the patience of the options, after its beginning.
class PointerDevice final : public HandDevice {
 public:
  /// The servo thread reads `messages`, which must outlive this object. Throws
  /// std::invalid_argument if a number is not usable.
  PointerDevice(const PointerHandOptions& options, Ring<PointerMessage>& messages);

  /// Puts the hand in front of the surface.
  void begin(const Vec3& position, const Vec3& normal) override;
  DeviceReading read(Nanoseconds now) noexcept override;

  /// Returns the place of the hand after begin() [m].
  const Vec3& start() const { return start_; }
  /// Whether it ended because messages were missing. Any thread may call it.
  bool neglected() const noexcept { return neglected_.load(); }

 private:
  Vec3 intended(double time) noexcept override;

  PointerHandOptions options_;
  Ring<PointerMessage>& messages_;
  Vec3 start_ = Vec3::Zero(), target_ = Vec3::Zero(), aim_ = Vec3::Zero();
  double aimed_at_ = 0.0;  // [s] the time of aim_
  bool started_ = false, ended_ = false;
  Nanoseconds began_{0}, heard_{0};
  std::atomic<bool> neglected_{false};
};

}  // namespace feltwire
