#pragma once
// Last stage of a tick: why the hand feels what it feels, and what it felt over the run.

#include "client/servo/feel_metrics.hpp"
#include "client/servo/servo_statistics.hpp"
#include "client/servo/zero_force_reason.hpp"
#include "protocol/wire/hand_report.hpp"

namespace feltwire {

/// Follows the command of each tick on its way to the hand. Allocates only when it is made.
class Explanation {
 public:
  /// A tick whose force is on the hand.
  struct Tick {
    Vec3 displacement = Vec3::Zero();  // [m] since the tick before
    Command wanted{};                  // the device's part of the scene's command
    Command held{};                    // on the hand from now on
    double elapsed = 0.0;              // [s] since the tick before
    bool known = false;                // the device's position
    bool feels_scene = false;          // only bound, account and device's limits reduce the command
    bool released = false;
  };
  /// The state beside the trail that a report tells of.
  struct State {
    bool near = false;    // the local model alone gave the command
    bool shapes = false;  // the session's method
    bool fades = false, law_changes = false, released = false, in_debt = false;
    bool withholds_change = false;
    bool on_time = true;  // the device takes forces up without late ticks
  };

  /// `period` of the servo [s].
  explicit Explanation(double period) : measures_(period) {}

  /// The stages of this tick, which fill it in.
  ForceTrail& trail() noexcept { return trail_; }
  const ForceTrail& trail() const noexcept { return trail_; }
  /// The place of the device is not known.
  void lose() noexcept { measures_.lose(); }
  /// Ends a tick.
  void take(const Tick& tick, ServoStatistics& statistics) noexcept;

  /// The reason for no force on the hand since the last tick; ZeroForceReason::felt: there is
  /// force.
  ZeroForceReason reason() const noexcept { return reason_; }
  const FeelMetrics& measures() const noexcept { return measures_; }
  /// [s] for which the device has held no force although it was given some.
  double not_held_for() const noexcept { return not_held_for_; }
  /// The share of the last tick's command that the account took off, 0 to 1.
  double account_cut() const noexcept;
  /// The reasons of the last tick, a bit each (HandReport::reasons).
  std::uint32_t reasons(const State& state) const noexcept;

 private:
  ForceTrail trail_;
  ZeroForceReason reason_ = ZeroForceReason::no_reply;
  FeelMetrics measures_;
  double not_held_for_ = 0.0;
};

}  // namespace feltwire
