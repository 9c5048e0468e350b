#pragma once
// A haptic device in a simulated hand that another thread points with: a mouse, a finger on a
// screen, a gamepad.

#include "client/devices/hand_device.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// A message to the hand: go to a target, or let go.
struct Pointing {
  enum class Kind : std::uint8_t { to, let_go };
  Kind kind = Kind::to;
  Vec3 target = Vec3::Zero();  // [m] where the hand shall be, world frame; of `to`
};

struct PointedHandOptions {
  DeviceSpec spec;
  Hand hand;
  double speed = 0.5;   // [m/s] at most, of where the hand means to be
  double reach = 0.02;  // [m] at most, from the hand to where it means to be: so it presses with
                        // stiffness * reach
  double smoothing = 0.015;  // [s] time constant towards a target, for targets that come in steps
  double patience = 1.0;     // [s] without a word; then the hand lets go
  double beginning = 5.0;    // [s] in which it does not let go for want of a word: a browser that
                             // draws a hand for the first time may pause for seconds
  double clearance = 0.02;   // [m] from the surface where begin() puts it
};

/// The hand means to be at the newest target: it goes there smoothly, with at most the speed of the
/// options, whatever the target jumps. It ends (DeviceReading::ended) when it is told to let go, or
/// is told nothing for the patience of the options, after its beginning.
class PointedDevice final : public HandDevice {
 public:
  /// The reader of `pointings` is the servo thread. It must outlive this. Throws
  /// std::invalid_argument when a number is not usable.
  PointedDevice(const PointedHandOptions& options, Ring<Pointing>& pointings);

  /// Puts the hand before the surface.
  void begin(const Vec3& position, const Vec3& normal) override;
  DeviceReading read(Nanoseconds now) noexcept override;

  /// Where begin() put the hand [m].
  const Vec3& start() const { return start_; }
  /// It ended for want of a word. Any thread.
  bool neglected() const noexcept { return neglected_.load(); }

 private:
  Vec3 intended(double time) noexcept override;

  PointedHandOptions options_;
  Ring<Pointing>& pointings_;
  Vec3 start_ = Vec3::Zero(), target_ = Vec3::Zero(), aim_ = Vec3::Zero();
  double aimed_at_ = 0.0;  // [s] the time of aim_
  bool started_ = false, ended_ = false;
  Nanoseconds began_{0}, heard_{0};
  std::atomic<bool> neglected_{false};
};

}  // namespace feltwire
