#pragma once
// The servo tick: its input is the position of the device, its output the command that the device
// holds until the next tick. It has no socket, clock or thread. Time is an argument, so every
// property can be tested and replayed.

#include <cstdint>
#include <optional>
#include <string_view>

#include "client/device/device.hpp"
#include "client/servo/device_input.hpp"
#include "client/servo/explanation.hpp"
#include "client/servo/force_fade.hpp"
#include "client/servo/force_law.hpp"
#include "client/servo/reply_intake.hpp"
#include "client/servo/servo_law.hpp"
#include "client/servo/servo_options.hpp"
#include "client/servo/servo_statistics.hpp"
#include "client/servo/virtual_environment.hpp"

namespace feltwire {

/// The client's half of the haptic loop. A tick is render(), the device's write(), hold(); replies
/// are given to it whenever they arrive. Neither allocates, throws or reads a clock.
///
/// render() is five stages, each a class of its own: DeviceInput, ReplyIntake, VirtualEnvironment,
/// ForceLaw, Explanation.
class Servo {
 public:
  /// Throws std::invalid_argument that names the parameter and the remedy.
  Servo(const DeviceSpec& spec, const SessionParameters& parameters,
        const ServoOptions& options = {});

  /// Takes a reply that was found at `arrival`. The reply to the newest sample is used; then the
  /// result is true. An impossible reply changes nothing. After the servo stood still, a found
  /// reply may have come at any time since, and counts as that old.
  bool take(const Reply& reply, Nanoseconds arrival) noexcept;

  /// The command to write to the device now: the newest command, extrapolated along its rates if
  /// the server sends them (for keep_alive at most), or the command of the local model at the
  /// device's current position. It holds in full until it is hold_time / 2 old, and falls linearly
  /// to zero at hold_time. Then it is bounded (docs/bounding.md) and passes the safety stage
  /// (core/safety/safety.hpp). A fall by age or by release() takes at most the device's largest
  /// force off in half the hold time; at its end there is none, whatever force the bound would
  /// hold. A reading that is faulty or not finite gives none at once (no force is known to be safe
  /// at an unknown place), and the servo then starts again as after reconnected(). So does a
  /// reading that no hand can have moved to (core/device/possible_movement.hpp). A force that has
  /// faded to zero for want of answers comes back as after reconnected(), and every faded force
  /// comes back no faster than it fades. A clock that was set back is no reason to hold anything
  /// longer.
  Command render(const DeviceReading& reading, Nanoseconds now) noexcept;

  /// Takes the result of the device's write(), which alone is accounted for, and returns the
  /// sample to send; null until the first good reading. It stays valid until the next call.
  const Sample* hold(const Command& held) noexcept;

  /// Makes a tick. Null, and no tick, if the device has no newer reading (DeviceReading::fresh):
  /// the held force stays, and the next tick is longer by that time. After a quarter of the hold
  /// time without a newer reading the device has a fault.
  const Sample* tick(Device& device, Nanoseconds now) noexcept;
  /// The device's tick has not come: a tick whose reading is faulty.
  const Sample* missed_tick(Device& device, Nanoseconds now) noexcept {
    DeviceReading none;
    none.ok = false;
    return hold(device.write(render(none, now)));
  }

  /// The last sample was the newest of a datagram that was sent, so a reply is expected.
  void sent() noexcept { replies_.sent(sample_.index, statistics_.replies); }
  /// Whether a reply may still come. With a force deadband it may also have been withheld.
  bool awaits_answer() const noexcept {
    return statistics_.replies.answered + statistics_.replies.withheld <
           statistics_.replies.datagrams;
  }
  /// Datagrams that were lost, or whose replies were lost: sent, neither answered nor withheld. The
  /// number that the server withheld since its newest reply is not known; as many of those
  /// datagrams as keep_alive allows count as withheld.
  std::uint64_t lost() const noexcept { return replies_.lost(parameters(), statistics_.replies); }
  /// Lost datagrams, up to the newest one that was answered; later replies may still come.
  std::uint64_t lost_so_far() const noexcept { return replies_.lost_so_far(statistics_.replies); }

  /// The session was lost and continues: the hand may be anywhere. The held force fades to zero
  /// within half the hold time. Then the safety limits of a connection (wait for small force,
  /// ramp-up) begin anew, the old local model is forgotten and the replies count again. `fresh`: it
  /// is another session, whose server counts from zero.
  void reconnected(bool fresh) noexcept;

  /// Another law bounds from now on. The held force fades to zero within half the hold time. Then
  /// the new law begins from zero force, with nothing stored, and the limits of a connection (wait
  /// for small force, ramp-up) begin anew. The account goes on from that of the old law: the
  /// exchange forgives no debt and makes no energy. A debt also outlives a law that has no account.
  /// Energy that is given and taken under such a law counts in none. `next` receives the old
  /// law; it must outlive the servo. Precondition: it was made for this device, with parameters
  /// that differ only in the law, and both methods admit reductions. It never allocates.
  void adopt(ServoLaw& next) noexcept;

  /// The force fades to zero within half the hold time, and stays there.
  void release() noexcept;
  /// There is no force on the hand any more, and there will be none.
  bool let_go() const { return released_ && !law_.holds(); }
  /// The account got into a debt above kLargestDebt: there is no force any more, whatever law
  /// bounds. Empty: it did not.
  const std::optional<Overdraft>& overdraft() const { return law_.overdraft(); }
  /// [J] that the hand got beyond what the device has burned until now.
  double owed() const noexcept { return law_.owed(); }
  /// The device reported its end; it has received no command since.
  bool device_ended() const { return input_.ended(); }
  /// The device has kept all force from the hand for a quarter of the hold time or longer, until
  /// the last tick or until release().
  struct DeviceTrouble {
    ZeroForceReason reason = ZeroForceReason::device_fault;  // or jumped, or not_held
    double time = 0.0;                                       // [s] for which it has lasted
  };
  std::optional<DeviceTrouble> device_trouble() const noexcept;

  const DeviceSpec& spec() const { return spec_; }
  const SessionParameters& parameters() const { return law_.law().parameters; }
  const ServoOptions& options() const { return options_; }
  const ServoStatistics& statistics() const { return statistics_; }
  /// Replies so far, by their round trip.
  const HandTimes::Counts& round_trips() const { return replies_.round_trips(); }
  const PortEnergy& port() const { return law_.port(); }
  /// The account is the last stage before the device. Empty: the device gets the result of the
  /// bound and the safety stage.
  const std::optional<PortAccount>& account() const { return law_.law().account; }
  /// The share of the last tick's command that the account took off, 0 to 1.
  double account_cut() const noexcept { return explanation_.account_cut(); }
  /// The command of the last tick was made here, from the local model alone.
  bool near() const { return environment_.near(); }
  /// A law that was adopted waits until the force has faded.
  bool changes_law() const { return law_.changes(); }
  /// Whether the session's method shapes the force (BoundingMethod::shapes).
  bool shapes() const { return law_.law().shapes; }
  /// The hand's damping that the methods `credited` and `shaped` assume; empty in other modes.
  std::optional<HandCredit> hand_credit() const { return law_.law().bounding.hand_credit(); }
  /// The part of the last tick for the robot that the hand leads; empty: the hand leads no robot.
  std::optional<Lead> lead() const noexcept;
  /// The robot's data in the replies; null: the hand leads no robot.
  const RemoteHand* remote() const noexcept {
    return environment_.robot() != nullptr ? &environment_.robot()->hand() : nullptr;
  }
  /// The states between this hand and its robot so far; none: the hand leads no robot.
  LinkStates link_states() const noexcept {
    return environment_.robot() != nullptr ? environment_.robot()->states() : LinkStates{};
  }
  /// The name of the seat of the robot that the hand leads; empty: the only one, or it leads none.
  std::string_view robot_name() const noexcept {
    return remote() != nullptr && remote()->seat() < options_.seats.size()
               ? std::string_view(options_.seats[remote()->seat()])
               : std::string_view();
  }
  /// Renders with this scene until the next call; null: nothing was fetched. It must live so long.
  void use(const FetchedScene* fetched) noexcept { environment_.use(fetched); }
  const FetchedScene* fetched() const noexcept { return environment_.fetched(); }
  /// The state of the last tick, for observers of the scene.
  HandReport report() const noexcept;
  const ClockEstimate& server_clock() const { return replies_.server_clock(); }

  const Sample& sample() const { return sample_; }  // the last one made
  /// The command of the scene, before fade and bound: from the newest reply, or with a local model
  /// the model's result at the last tick.
  const Command& command() const {
    return parameters().local_model ? environment_.last_command() : newest_reply().command;
  }
  /// On the hand since the last tick.
  const Command& held() const { return law_.held(); }
  /// The result of the last render(). A device with late_ticks takes it up later.
  const Command& given() const { return given_; }
  /// The reason for no force on the hand since the last tick; ZeroForceReason::felt: there is
  /// force.
  ZeroForceReason no_force() const { return explanation_.reason(); }
  /// Oscillation and displayed stiffness so far.
  const FeelMetrics& measures() const { return explanation_.measures(); }
  const Reply& newest_reply() const { return replies_.newest(); }
  bool has_reply() const { return replies_.has_reply(); }
  /// The scene was changed under the hand, and the bound still withholds some of its force.
  bool withholds_change() const { return law_.withholds_change(); }
  /// [s] from the arrival of the newest reply to the last tick.
  double command_age() const { return command_age_; }

 private:
  double time_since_last_tick(Nanoseconds now) noexcept;
  void begin_trail(const DeviceReading& reading, const DeviceMovement& movement) noexcept;
  void begin_anew(std::uint64_t last_sample_before) noexcept;
  ForceLaw::Asked ask(BoundingStep& step, const DeviceMovement& movement, Nanoseconds now) noexcept;
  void end_fade() noexcept;
  void exchange_law() noexcept;
  bool feels_scene() const noexcept;

  DeviceSpec spec_;
  ServoOptions options_;
  ForceLaw law_;
  DeviceInput input_;
  ReplyIntake replies_;
  VirtualEnvironment environment_;
  Explanation explanation_;
  ForceFade fade_;

  Nanoseconds last_tick_{0};
  bool ticked_ = false;  // last_tick_ counts
  bool released_ = false;
  bool found_again_ = false;  // the force fades because the session was lost
  double command_age_ = 0.0;
  Explanation::Tick tick_;  // what render() knows of it
  Command given_;           // the last result of render()
  Sample sample_;
  ServoStatistics statistics_;
};

}  // namespace feltwire
