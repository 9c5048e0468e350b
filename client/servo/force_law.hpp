#pragma once
// Fourth stage of a tick: the scene's command becomes the force for the hand. The bound, the safety
// limits and the energy account, one after the other.

#include <algorithm>
#include <optional>

#include "client/device/command_delay.hpp"
#include "client/servo/device_input.hpp"
#include "client/servo/overdraft.hpp"
#include "client/servo/servo_law.hpp"
#include "client/servo/servo_statistics.hpp"
#include "client/servo/zero_force_reason.hpp"
#include "core/bounding/hold_time_margin.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/safety/safety.hpp"

namespace feltwire {

/// Owns the law in force, and what it accounts for: the force on the hand, and the port's energy.
/// Allocates and throws only when it is made.
class ForceLaw {
 public:
  /// The command of a tick.
  struct Asked {
    Command wanted{};             // the device's part of the scene's command
    double share = 0.0;           // of it, that fades leave
    bool original = false;        // the scene's own, of the present contact
    bool movement_known = false;  // the step's movement was measured
  };

  /// Throws std::invalid_argument that names the parameter and the remedy.
  ForceLaw(const DeviceSpec& spec, const SessionParameters& parameters,
           const ServoOptions& options);

  const ServoLaw& law() const noexcept { return law_; }
  const PortEnergy& port() const noexcept { return port_; }
  const std::optional<Overdraft>& overdraft() const noexcept { return debt_.overdraft(); }
  /// [J] that the hand got beyond what the device has burned until now.
  double owed() const noexcept {
    return law_.account ? std::max(0.0, -law_.account->balance()) : owed_;
  }
  /// On the hand since the last hold().
  const Command& held() const noexcept { return held_; }
  /// A force is on the hand, or will be without another write.
  bool holds() const noexcept;

  /// Takes a usable movement: what was on the hand during it is accounted for.
  void moved(const DeviceReading& reading, const DeviceMovement& movement, double hold_time,
             DeviceCounts& counts) noexcept;
  /// Energy [J] that the account may spend besides.
  void credit(double energy) noexcept {
    if (law_.account) law_.account->credit(energy);
  }
  /// Takes the hold time of a tick, whether or not its movement was usable.
  void saw(const BoundingStep& step, bool movement_known) noexcept;

  /// Returns the force for the hand. `step.command`: what is left of `asked.wanted`.
  Command apply(const BoundingStep& step, const Asked& asked, ForceTrail& trail,
                ForceLawCounts& counts) noexcept;
  /// The device was given `given`, and its write() returned `told`.
  void hold(const Command& given, const Command& told) noexcept;

  /// The hand may be anywhere: the limits of a connection begin anew.
  void begin_anew() noexcept { safety_.begin_anew(); }
  /// The surface under the hand is unknown.
  void forget_contact() noexcept {
    if (law_.scene_change_gate) law_.scene_change_gate->forget();
  }
  void scene_changed() noexcept;
  /// The scene was changed under the hand, and the bound still withholds some of its force.
  bool withholds_change() const noexcept {
    return law_.scene_change_gate && law_.scene_change_gate->withheld();
  }

  /// `next` waits for exchange(). It must outlive this object.
  void adopt(ServoLaw& next) noexcept { next_ = &next; }
  bool changes() const noexcept { return next_ != nullptr; }
  /// The law that waits is in force from now on, and gets the old one. Precondition: changes(), and
  /// no force is given. A late device may still hold some.
  void exchange() noexcept;

 private:
  void account_for(const Command& held) noexcept;
  void set_held() noexcept;
  void admit_change(const BoundingStep& step) noexcept;
  Command safeguard(const Command& bounded, const BoundingStep& step, const Asked& asked,
                    ForceTrail& trail, ForceLawCounts& counts) noexcept;
  Command paid_for(const Command& command, BoundingStep step, bool movement_known,
                   ForceTrail& trail, ForceLawCounts& counts) noexcept;

  DeviceSpec spec_;
  ServoLaw law_;
  ServoLaw* next_ = nullptr;        // waits until no force is held
  bool scene_was_changed_ = false;  // since the session was joined
  SafetyStage safety_;
  PortEnergy port_;
  HoldTimeMargin margin_;
  double owed_;  // [J] while no account stands
  DebtGuard debt_;
  CommandDelay command_delay_;
  Command held_;
};

}  // namespace feltwire
