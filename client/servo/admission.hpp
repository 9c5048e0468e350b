#pragma once
// How the force of a scene that was changed under a hand comes through to a hand that presses.

#include "core/base/types.hpp"
#include "core/bounding/account.hpp"

namespace feltwire {

/// The contact frame's bound lets a force rise only as the hand presses on, so a hand that rests in
/// a wall does not feel that the wall has become stiffer. What it pressed into that wall is there
/// to pay for more (docs/bounding.md, "A scene that changes under a hand"): for one second after
/// the change the bound's storage is raised by it, step by step, so that the force rises no faster
/// than a fade falls.
///
/// The energy that is let in never exceeds what the hand has pressed into the contact it is in, nor
/// what the port has to spare. That the port stays passive is the account's doing, behind the
/// bound.
class Admission {
 public:
  struct Tick {
    const Command& held;     // over the movement
    Vec3 displacement;       // [m]
    double hold_time;        // [s]
    const Command& command;  // that the bound is asked for next
    double margin;           // [J] of the port
  };

  /// `slew` [N/s]: how fast a force may rise.
  explicit Admission(double slew) : slew_(slew) {}

  /// The scene is another from this tick's command on.
  void begin() noexcept {
    open_ = true;
    since_ = 0.0;
  }
  /// Forgets how far the hand has pressed: the surface under it is unknown.
  void forget() noexcept {
    open_ = false;
    pressed_ = 0.0;
  }

  /// The energy [J] to add to the bound's storage for its next step. Call it at every tick.
  double energy(const Tick& tick, const PortAccount& account) noexcept;

  /// Tell it what the bound rendered of the command's elastic part. When the bound renders all of
  /// it, the change of the scene is felt in full.
  void given(const Vec3& rendered, const Vec3& commanded) noexcept;

  /// The scene has changed, and the bound still keeps some of it from the hand.
  bool withheld() const noexcept { return open_; }

 private:
  static constexpr double kOpen = 1.0;  // [s]
  double slew_;
  double pressed_ = 0.0;  // [J] by the hand into the contact that it is in
  bool open_ = false;
  double since_ = 0.0;  // [s] the change
};

}  // namespace feltwire
