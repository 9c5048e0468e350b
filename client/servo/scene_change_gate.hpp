#pragma once
// Lets a hand that presses on a changed surface feel the new force.

#include "core/base/types.hpp"
#include "core/bounding/account.hpp"

namespace feltwire {

/// The contact frame's bound lets a force rise only as the hand presses on. So a hand that rests in
/// a wall does not feel that the wall has become stiffer. The energy that it pressed into that wall
/// can pay for more (docs/bounding.md, "A scene that changes under a hand"): for one second after
/// the change it is added to the bound's storage, step by step, so that the force rises no faster
/// than a fade falls.
///
/// The added energy never exceeds the energy that the hand has pressed into its present contact, or
/// the margin of the port. The account behind the bound keeps the port passive.
class SceneChangeGate {
 public:
  struct Tick {
    const Command& held;     // during the movement
    Vec3 displacement;       // [m]
    double hold_time;        // [s]
    const Command& command;  // the next command for the bound
    double margin;           // [J] of the port
  };

  /// `slew` [N/s]: the largest rate at which a force may rise.
  explicit SceneChangeGate(double slew) : slew_(slew) {}

  /// The scene is a new one from this tick's command on.
  void begin() noexcept {
    open_ = true;
    since_ = 0.0;
  }
  /// Forgets the pressed energy: the surface under the hand is unknown.
  void forget() noexcept {
    open_ = false;
    pressed_ = 0.0;
  }

  /// The energy [J] to add to the bound's storage for its next step. Call it at every tick.
  double energy(const Tick& tick, const PortAccount& account) noexcept;

  /// Takes the rendered part of the command's elastic part. When the bound renders all of it, the
  /// hand feels the change of the scene in full.
  void given(const Vec3& rendered, const Vec3& commanded) noexcept;

  /// Whether the scene has changed, and the bound still withholds some of the change from the hand.
  bool withheld() const noexcept { return open_; }

 private:
  static constexpr double kOpen = 1.0;  // [s]
  double slew_;
  double pressed_ = 0.0;  // [J] that the hand pressed into its present contact
  bool open_ = false;
  double since_ = 0.0;  // [s] since the change
};

}  // namespace feltwire
