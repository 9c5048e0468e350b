#pragma once
// The servo tick: its input is the position of the device, its output the command that the device
// holds until the next tick. It has no socket, clock or thread. Time is an argument, so every
// property can be tested and replayed.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/devices/actuation_lag.hpp"
#include "client/devices/device.hpp"
#include "client/servo/clock_estimate.hpp"
#include "client/servo/feel_metrics.hpp"
#include "client/servo/overdraft.hpp"
#include "client/servo/remote_hand.hpp"
#include "client/servo/rise_limit.hpp"
#include "client/servo/scene_change_gate.hpp"
#include "client/servo/zero_force_reason.hpp"
#include "core/base/histogram.hpp"
#include "core/bounding/account.hpp"
#include "core/bounding/bounding.hpp"
#include "core/bounding/hold_time_margin.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/bounding/velocity.hpp"
#include "core/device/possible_movement.hpp"
#include "core/local_model/local_body.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/safety/safety.hpp"
#include "core/teleoperation/link_states.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct ServoOptions {
  /// Between the bound and the device. None by default, so that measurements show the bound;
  /// protect_hand() gives the limits for a person's hand.
  SafetyLimits safety;
  bool observes = false;  // its role gets no force: used for the no-force reason
  /// The account stands behind the law. False: a law of a paper as it was published.
  bool account = true;
  bool learns_hand_force = false;  // the account relies on the largest recent force from
                                   // outside (core/bounding/hand_force_bound.hpp)
  /// The hand leads the scene's robot, and trusts this share of the energy that the robot reports.
  /// Needs a local model.
  std::optional<RemoteTrust> leads{};
  /// Names of the scene's seats for robots, in the order of JoinAccepted, and the number of the one
  /// whose robot the hand leads first.
  std::vector<std::string> seats{};
  std::uint8_t seat = 0;
  /// The button of the device, from 1, that chooses the next robot; 0: none.
  int seat_button = 0;
  double motion_scale = 1.0;     // Device::motion_scale()
  double owed = 0.0;             // [J] debt of the device's account when the servo begins
  double scene_stiffness = 0.0;  // [N/m] of the stiffest surface, for methods that shape; 0: not
                                 // known
};

/// Throws std::invalid_argument that names the limit, its value and the remedy: a slew, ramp or
/// speed limit cannot follow a bound that does not admit reductions, at the client or the server;
/// a force cannot do without the account where nothing else makes it passive.
void validate(const ServoOptions& options, const SessionParameters& parameters);

/// The safety limits that protect a hand and are not felt in normal use (docs/devices.md has the
/// measurements): the wait for a small force; the speed limit, if the session's bound admits it; a
/// ramp, if the client does not bound.
ServoOptions protect_hand(const SessionParameters& parameters);

/// The bound of a servo as one object. A law is made where memory may be allocated; then it is
/// exchanged into a running servo, which allocates none (Servo::adopt()).
struct ServoLaw {
  /// Throws std::invalid_argument that names the parameter and the remedy.
  ServoLaw(const DeviceSpec& spec, const SessionParameters& in_force, const ServoOptions& options);
  SessionParameters parameters;  // in force with this law
  Bounding bounding;
  std::optional<PortAccount> account;
  std::optional<SceneChangeGate> scene_change_gate;  // if this side bounds by contact_frame
  bool shapes, counts_on_mass;
};

/// Plain numbers of one run. Times in [ns], angles in [1e-6 deg] (whole numbers for the
/// histograms).
struct ServoStatistics {
  std::uint64_t samples = 0;        // made by hold()
  std::uint64_t datagrams = 0;      // newest samples of a due datagram: sent()
  std::uint64_t answered = 0;       // replies that came, each sample once
  std::uint64_t withheld = 0;       // datagrams that the server says it needed not answer
  std::uint64_t late = 0;           // of the answered, after more than kLate
  std::uint64_t replies_stale = 0;  // not newer than the reply in use: ignored
  std::uint64_t replies_refused =
      0;  // they answer no sample that was made, or are not finite or out of range
  std::uint64_t faded = 0;             // ticks at which an old command was faded, wholly or in part
  std::uint64_t device_faults = 0;     // readings or held forces that were faulty or not finite
  std::uint64_t jumps = 0;             // of these, readings that no hand can have moved to
  std::uint64_t stale_readings = 0;    // repeated readings: the force stayed held
  std::uint64_t forces_corrected = 0;  // readings with a held force that differs, by more than can
                                       // be felt, from the result of write()
  std::uint64_t bound_active = 0;      // ticks at which the bound changed the command
  std::uint64_t saturated = 0;         // ticks at which the device's limits changed it
  std::uint64_t account_cut = 0;  // ticks at which the port had not enough energy for all of it
  std::uint64_t refused = 0;      // ticks at which the bound got a command or movement out of range
  // Ticks at which these safety limits reduced the bound's force.
  std::uint64_t waiting = 0, ramped = 0, slewed = 0, too_fast = 0, force_limited = 0;
  std::uint64_t scene_resets =
      0;  // times that replies began to report that moving objects were put back
  // With a local model: received models, their surfaces, and ticks by the source of the command:
  // the model alone, the model and the reply, or the reply alone because the model did not reach.
  std::uint64_t whole_models = 0;  // models with a surface or solids that are here in full
  std::uint64_t models = 0, patches = 0, modelled = 0, half_modelled = 0, beyond_model = 0;
  std::uint64_t contact_cut = 0;  // of those beyond: the model's contact took too much work
  std::uint64_t most_work = 0;    // units of work (core/base/work_limit.hpp) of a tick's contact
  std::uint64_t hand_overs = 0;   // times that the use of the model alone began or ended
  std::array<std::uint64_t, kZeroForceReasons> no_force{};  // ticks by reason; `felt` too
  double max_force = 0.0;                                   // [N] held
  Histogram round_trip;       // [ns] from the sample's reading to the reply's arrival
  Histogram direction_error;  // [1e-6 deg] held force against its command
};

/// The client's half of the haptic loop. A tick is render(), the device's write(), hold(); replies
/// are given to it whenever they arrive. Neither allocates, throws or reads a clock.
class Servo {
 public:
  static constexpr Nanoseconds kLate = std::chrono::milliseconds(1);

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
  void sent() noexcept;
  /// Whether a reply may still come. With a force deadband it may also have been withheld.
  bool awaits_answer() const noexcept {
    return statistics_.answered + statistics_.withheld < statistics_.datagrams;
  }
  /// Datagrams that were lost, or whose replies were lost: sent, neither answered nor withheld. The
  /// number that the server withheld since its newest reply is not known; as many of those
  /// datagrams as keep_alive allows count as withheld.
  std::uint64_t lost() const noexcept;
  /// Lost datagrams, up to the newest one that was answered; later replies may still come.
  std::uint64_t lost_so_far() const noexcept;

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
  bool let_go() const { return released_ && !holds(); }
  /// The account got into a debt above kLargestDebt: there is no force any more, whatever law
  /// bounds. Empty: it did not.
  const std::optional<Overdraft>& overdraft() const { return overdraft_; }
  /// [J] that the hand got beyond what the device has burned until now.
  double owed() const noexcept {
    return law_.account ? std::max(0.0, -law_.account->balance()) : owed_;
  }
  /// The device reported its end; it has received no command since.
  bool device_ended() const { return device_ended_; }
  /// The device has kept all force from the hand for a quarter of the hold time or longer, until
  /// the last tick or until release().
  struct DeviceTrouble {
    ZeroForceReason reason = ZeroForceReason::device_fault;  // or jumped, or not_held
    double time = 0.0;                                       // [s] for which it has lasted
  };
  std::optional<DeviceTrouble> device_trouble() const noexcept;

  const DeviceSpec& spec() const { return spec_; }
  const SessionParameters& parameters() const { return law_.parameters; }
  const ServoOptions& options() const { return options_; }
  const ServoStatistics& statistics() const { return statistics_; }
  /// Replies so far, by their round trip.
  const HandTimes::Counts& round_trips() const { return round_trips_; }
  const PortEnergy& port() const { return port_; }
  /// The account is the last stage before the device. Empty: the device gets the result of the
  /// bound and the safety stage.
  const std::optional<PortAccount>& account() const { return law_.account; }
  /// The share of the last tick's command that the account took off, 0 to 1.
  double account_cut() const noexcept;
  /// The command of the last tick was made here, from the local model alone.
  bool near() const { return near_; }
  /// A law that was adopted waits until the force has faded.
  bool changes_law() const { return next_law_ != nullptr; }
  /// Whether the session's method shapes the force (BoundingMethod::shapes).
  bool shapes() const { return law_.shapes; }
  /// The hand's damping that the methods `credited` and `shaped` assume; empty in other modes.
  std::optional<HandCredit> hand_credit() const { return law_.bounding.hand_credit(); }
  /// The part of the last tick for the robot that the hand leads; empty: the hand leads no robot.
  std::optional<Lead> lead() const noexcept;
  /// The robot's data in the replies; empty: the hand leads no robot.
  const std::optional<RemoteHand>& remote() const { return remote_; }
  /// The states between this hand and its robot so far.
  const LinkStates& link_states() const { return link_states_; }
  /// The name of the seat of the robot that the hand leads; empty: the only one, or it leads none.
  std::string_view robot_name() const noexcept {
    return remote_ && remote_->seat() < options_.seats.size()
               ? std::string_view(options_.seats[remote_->seat()])
               : std::string_view();
  }
  /// Renders with this scene until the next call; null: nothing was fetched. It must live so long.
  void use(const FetchedScene* fetched) noexcept {
    fetched_ = fetched;
    local_.use(fetched != nullptr ? fetched->surfaces.get() : nullptr);
    local_body_.use(fetched != nullptr ? fetched->body.get() : nullptr);
  }
  const FetchedScene* fetched() const noexcept { return fetched_; }
  /// The state of the last tick, for observers of the scene.
  HandReport report() const noexcept;
  const ClockEstimate& server_clock() const { return server_clock_; }

  const Sample& sample() const { return sample_; }  // the last one made
  /// The command of the scene, before fade and bound: from the newest reply, or with a local model
  /// the model's result at the last tick.
  const Command& command() const {
    return law_.parameters.local_model ? environment_ : newest_.command;
  }
  const Command& held() const { return held_; }  // on the hand since the last tick
  const Command& given() const {
    return given_;
  }  // the result of the last render(): a device with
     // late_ticks takes it up later
  /// The reason for no force on the hand since the last tick; ZeroForceReason::felt: there is
  /// force.
  ZeroForceReason no_force() const { return no_force_; }
  /// Oscillation and displayed stiffness so far.
  const FeelMetrics& measures() const { return measures_; }
  const Reply& newest_reply() const { return newest_; }
  bool has_reply() const { return newest_.sample_index > 0; }
  /// The scene was changed under the hand, and the bound still withholds some of its force.
  bool withholds_change() const {
    return law_.scene_change_gate && law_.scene_change_gate->withheld();
  }
  /// [s] from the arrival of the newest reply to the last tick.
  double command_age() const { return command_age_; }

 private:
  struct Movement {
    Vec3 displacement = Vec3::Zero(), rotation = Vec3::Zero();
    bool known = false;
  };
  /// A sample that waits for its reply.
  struct Sent {
    std::uint64_t index = 0;
    Nanoseconds time{0};
    std::uint64_t datagram = 0;  // the datagram whose newest sample it was, counted from 1; 0: none
    bool answered = false;
  };

  static bool pulls(const Command& c) { return !c.force().isZero(0.0) || !c.torque.isZero(0.0); }
  bool waits_for_news(const DeviceReading& reading, Nanoseconds now) noexcept;
  bool jumps(const DeviceReading& reading, double elapsed) noexcept;
  /// A force is on the hand, or will be without another write.
  bool holds() const { return pulls(held_) || !actuation_lag_.nothing_left(); }
  void correct(const Command& held) noexcept;
  void account_for(const Command& held) noexcept;
  double time_since_last_tick(Nanoseconds now) noexcept;
  Movement moved_to(const DeviceReading& reading) noexcept;
  void take_model(const Reply& reply, Nanoseconds arrival) noexcept;
  void scene_changed() noexcept;
  bool follow_model(const BoundingStep& step, Nanoseconds now, Command& command) noexcept;
  bool count_modelled(double weight) noexcept;
  double follow_body(const BoundingStep& step, double age, Command& command) noexcept;
  WorkLimit contact_work() const noexcept;
  void count_work(const WorkLimit& work) noexcept;
  Command rise_limited(const BoundingStep& step) noexcept;
  void choose_robot(const DeviceReading& reading) noexcept;
  Command meet_robot(const Tool& tool, const Command& scene, Nanoseconds now,
                     double elapsed) noexcept;
  Command environment(BoundingStep& step, Nanoseconds now) noexcept;
  double fade_factor() const noexcept;
  double share_of_command(double elapsed) noexcept;
  Command faded(const Command& command, double factor) const noexcept;
  void start_letting_go() noexcept;
  void exchange_law() noexcept;
  void forget_surfaces() noexcept;
  void begin_anew(std::uint64_t last_sample_before) noexcept;
  void admit_change(const BoundingStep& step) noexcept;
  Command safeguard(const Command& bounded, const BoundingStep& step, bool original) noexcept;
  Command paid_for(const Command& command, BoundingStep step, bool moved_known) noexcept;
  void judge_debt(double hold_time, std::uint64_t strong_hand_before) noexcept;
  void observe_direction(const Command& held) noexcept;
  void explain(const Command& held) noexcept;
  bool feels_scene() const noexcept;
  void follow_trouble(const Command& held) noexcept;
  void count_answer(const Reply& reply, Nanoseconds arrival) noexcept;
  Command reconstructed(Nanoseconds now) const noexcept;

  DeviceSpec spec_;
  ServoOptions options_;
  ServoLaw law_;
  ServoLaw* next_law_ = nullptr;    // waits until no force is held
  bool scene_was_changed_ = false;  // since the session was joined
  SafetyStage safety_;
  PortEnergy port_;
  HoldTimeMargin reserve_;
  std::optional<Overdraft> overdraft_;
  double owed_;      // [J] while no account stands
  double forgiven_;  // [J] of the balance, 0 or less: no less is a fault
  bool torque_;
  double period_;  // T [s]

  ClockEstimate server_clock_;
  Reply newest_;
  Nanoseconds newest_arrival_{0};
  Nanoseconds newest_sampled_{0};        // the time of the reading of the answered sample
  std::uint64_t newest_datagram_ = 0;    // the datagram with that sample
  std::uint64_t withheld_before_ = 0;    // withheld in earlier sessions
  bool newest_original_ = false;         // its command is the scene's, unchanged
  bool fresh_ = false;                   // no reply of another session has come yet
  std::uint64_t anew_after_ = 0;         // replies to samples up to this one end no wait
  std::uint64_t stood_still_after_ = 0;  // replies to samples up to this one are out of date
  double command_age_ = 0.0;
  double share_ = 1.0;  // of the command, in the last tick: less while it fades and comes back
  ForceTrail trail_;    // of this tick
  ZeroForceReason no_force_ = ZeroForceReason::no_reply;
  FeelMetrics measures_;
  Vec3 displacement_ = Vec3::Zero();  // [m] of this tick

  // Only for sessions with a local model.
  const FetchedScene* fetched_ = nullptr;
  LocalContact local_;
  LocalBody local_body_;  // for a tool with a body
  VelocityEstimate velocity_;
  RiseLimit rise_;                    // if the method shapes
  std::optional<RemoteHand> remote_;  // if the hand leads a robot
  LinkStates link_states_;
  Nanoseconds remote_time_{0};     // our time of the robot's state
  bool deadman_ = false;           // in the last tick
  std::uint8_t wanted_seat_ = 0;   // of the robot that the hand wants to lead
  bool seat_pressed_ = false;      // the button that chooses another, in the last tick
  std::optional<double> gripper_;  // [m] in the last tick
  bool near_ = false;
  Vec3 model_moved_ = Vec3::Zero();  // [m] movement of the place where the model was evaluated
  Vec3 last_offset_ = Vec3::Zero();  // [m] from that place to the device
  Nanoseconds model_time_{0};        // our time of the state that the model describes
  Command environment_;              // command(), model and reply together

  Nanoseconds last_tick_{0};
  bool ticked_ = false;   // last_tick_ counts
  double elapsed_ = 0.0;  // [s] from the tick before
  PossibleMovement moves_, turns_;
  double no_position_for_ = 0.0, not_held_for_ = 0.0;  // [s] until the last tick
  bool position_known_ = false;                        // sample_.pose was read at the last tick
  bool posed_ = false;                                 // some reading was good
  bool released_ = false, device_ended_ = false;
  bool letting_go_ = false;   // no reply is used, and the held force fades from let_go_from_ on
  bool found_again_ = false;  // because the session was lost: then everything begins anew
  Nanoseconds let_go_from_{0};
  Command wanted_;  // the device's part of the command from which this tick's force comes
  Command given_;   // the last result of render()
  ActuationLag actuation_lag_;
  Command held_;  // on the hand since the last tick
  Sample sample_;

  std::vector<Sent> sent_;
  ServoStatistics statistics_;
  HandTimes::Counts round_trips_{};
};

}  // namespace feltwire
