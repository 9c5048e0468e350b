#pragma once
// One servo tick: the position of the device goes in, the command that it holds until the next tick
// comes out. No socket, no clock, no thread: time is an argument, so that every property can be
// tested and replayed.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "client/devices/device.hpp"
#include "client/servo/admission.hpp"
#include "client/servo/clock_estimate.hpp"
#include "client/servo/hand_measures.hpp"
#include "client/servo/no_force.hpp"
#include "client/servo/remote_hand.hpp"
#include "client/servo/rise_limit.hpp"
#include "core/base/histogram.hpp"
#include "core/bounding/account.hpp"
#include "core/bounding/bounding.hpp"
#include "core/bounding/hold_reserve.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/bounding/velocity.hpp"
#include "core/local_model/local_body.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/safety/safety.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct ServoOptions {
  /// Between the bound and the device. None here, so that what is measured is the bound;
  /// protect_hand() gives those that a person's hand should have.
  SafetyLimits safety;
  bool observes = false;           // given no force by its role: said where the reason is asked for
  bool learns_hand_force = false;  // the account counts on the largest force from outside that it
                                   // saw lately (core/bounding/outside_force.hpp)
  /// The hand leads the scene's robot, and believes this much of what the robot says of energy.
  /// Needs a local model.
  std::optional<RemoteTrust> leads{};
  double scene_stiffness = 0.0;  // [N/m] of the stiffest surface, for methods that shape; 0: not
                                 // known
  std::shared_ptr<const ToolBody> body{};  // in the hand, for a local model; null: not known
};

/// Throws std::invalid_argument naming the limit, its value and the remedy: a slew, ramp or speed
/// limit cannot follow a bound that does not admit reductions, on whichever side it stands.
void validate(const ServoOptions& options, const SessionParameters& parameters);

/// The safety limits that protect a hand and are not felt in normal use (docs/devices.md has the
/// measurements): the wait for a small force; the speed limit, where the session's bound admits it;
/// a ramp, where the client does not bound.
ServoOptions protect_hand(const SessionParameters& parameters);

/// What bounds the force of a servo, as one thing: a law is made where memory may be taken, and put
/// into a servo that runs by exchange, which takes none (Servo::adopt()).
struct ServoLaw {
  /// Throws std::invalid_argument naming the parameter and the remedy.
  ServoLaw(const DeviceSpec& spec, const SessionParameters& in_force, const ServoOptions& options);
  SessionParameters parameters;  // in force with it
  Bounding bounding;
  std::optional<PortAccount> account;
  std::optional<Admission> admission;  // where this side bounds by contact_frame
  bool shapes, counts_on_mass;
};

/// Plain numbers of one run. Times in [ns], angles in [1e-6 deg] (whole numbers for the
/// histograms).
struct ServoStatistics {
  std::uint64_t samples = 0;           // made by hold()
  std::uint64_t datagrams = 0;         // of these, newest of a datagram that was due: sent()
  std::uint64_t answered = 0;          // replies that came, each sample once
  std::uint64_t withheld = 0;          // datagrams that the server says it needed not answer
  std::uint64_t late = 0;              // of the answered, after more than kLate
  std::uint64_t replies_stale = 0;     // not newer than the reply in use: ignored
  std::uint64_t replies_refused = 0;   // answering no sample that was made, not finite or absurd
  std::uint64_t faded = 0;             // ticks at which an old command was faded, wholly or in part
  std::uint64_t device_faults = 0;     // readings or held forces that were faulty or not finite
  std::uint64_t stale_readings = 0;    // that told nothing new: the force went on being held
  std::uint64_t forces_corrected = 0;  // readings that told of a force held that differs, by more
                                       // than is felt, from what write() had told
  std::uint64_t bound_active = 0;      // ticks at which the bound changed the command
  std::uint64_t saturated = 0;         // ticks at which the device's limits did
  std::uint64_t account_cut = 0;       // ticks at which the port had no energy for all of it
  std::uint64_t refused = 0;           // ticks at which the bound met an absurd command or movement
  // Ticks at which these safety limits took something off what the bound let through.
  std::uint64_t waiting = 0, ramped = 0, slewed = 0, too_fast = 0, force_limited = 0;
  std::uint64_t scene_resets = 0;  // times that replies began to say that what moves was put back
  // With a local model: models that came, their surfaces, and ticks at which the command was the
  // model's alone, its and the reply's together, and the reply's alone for want of reach.
  std::uint64_t models = 0, patches = 0, modelled = 0, half_modelled = 0, beyond_model = 0;
  std::uint64_t hand_overs = 0;  // times that the model's alone began or ended
  std::array<std::uint64_t, kNoForceReasons> no_force{};  // ticks by why there was none; felt too
  double max_force = 0.0;                                 // [N] held
  Histogram round_trip;       // [ns] from the sample's reading to the reply's arrival
  Histogram direction_error;  // [1e-6 deg] force held against the command it came from
};

/// The client's half of the haptic loop. A tick is render(), the device's write(), hold(); replies
/// are given to it whenever they arrive. Neither allocates, throws or reads a clock.
class Servo {
 public:
  static constexpr Nanoseconds kLate = std::chrono::milliseconds(1);

  /// Throws std::invalid_argument naming the parameter and the remedy.
  Servo(const DeviceSpec& spec, const SessionParameters& parameters,
        const ServoOptions& options = {});

  /// A reply that was found at `arrival`. The one to the newest sample is used; true when this is
  /// it. One that cannot be changes nothing. What is found after the servo stood still may have
  /// come at any time since, and counts as that old.
  bool take(const Reply& reply, Nanoseconds arrival) noexcept;

  /// What to write to the device now. The newest command, carried on along its rates where the
  /// server sends them (for keep_alive at most), or with a local model what that answers where the
  /// device is now, counts in full until it is hold_time / 2 old, falls linearly to nothing at
  /// hold_time, is then bounded (docs/bounding.md) and last goes through the safety stage
  /// (core/safety/safety.hpp). A fall by age or by release() takes at most the device's largest
  /// force off in half the hold time; at its end there is none, whatever the bound would hold on
  /// to. A reading that is faulty or not finite gives none at once (nobody knows what force would
  /// be safe at an unknown place), and what follows begins anew as after reconnected(). A clock
  /// that was set back is no reason to hold anything longer.
  Command render(const DeviceReading& reading, Nanoseconds now) noexcept;

  /// Says what the device's write() returned, which is all that is accounted, and returns the
  /// sample to send; null until the first good reading. It stays valid until the next call.
  const Sample* hold(const Command& held) noexcept;

  /// One whole tick. Null, and no tick, where the device has nothing new to tell
  /// (DeviceReading::fresh): what is held stays, and the tick that comes then is as much longer.
  /// After a quarter of the hold time a device that tells nothing new has a fault.
  const Sample* tick(Device& device, Nanoseconds now) noexcept;
  /// The device's tick has not come: a tick whose reading is faulty.
  const Sample* missed_tick(Device& device, Nanoseconds now) noexcept {
    DeviceReading none;
    none.ok = false;
    return hold(device.write(render(none, now)));
  }

  /// The last sample made was the newest of a datagram that was sent: an answer to it is awaited.
  void sent() noexcept;
  /// An answer may still come. With a force deadband it may also have been withheld.
  bool awaits_answer() const noexcept {
    return statistics_.answered + statistics_.withheld < statistics_.datagrams;
  }
  /// Datagrams that, or whose answers, never came: sent, neither answered nor withheld. What the
  /// server withheld since its newest reply is not known; of those datagrams as many as keep_alive
  /// allows are taken for withheld.
  std::uint64_t lost() const noexcept;
  /// Lost datagrams, up to the newest one that was answered: later answers may still be on their
  /// way.
  std::uint64_t lost_so_far() const noexcept;

  /// The session was lost and goes on: the hand may be anywhere by now. What is still held fades to
  /// nothing within half the hold time; then the safety limits that belong to a connection (wait
  /// for small force, ramp-up) begin anew, a local model of before is forgotten and the replies
  /// count again. `fresh`: it is another session, whose server counts from zero.
  void reconnected(bool fresh) noexcept;

  /// Another law bounds from now on. What is held fades to nothing within half the hold time; then
  /// the new law begins from zero force, with nothing stored and an account of nothing, so that the
  /// exchange can give the hand no energy: the force comes back as the hand presses on. Behind a
  /// law without an account the wait for a small force begins anew as well. `next` gets the law
  /// before; it must outlive the servo. Precondition: it was made for this device, with parameters
  /// that differ in the law alone, and both methods admit reductions. Never allocates.
  void adopt(ServoLaw& next) noexcept;

  /// The force fades to nothing within half the hold time, and stays there.
  void release() noexcept;
  /// Nothing is on the hand any more, and nothing will be.
  bool let_go() const { return released_ && !pulls(held_); }
  /// The device said that it has ended; it has been given nothing since.
  bool device_ended() const { return device_ended_; }

  const DeviceSpec& spec() const { return spec_; }
  const SessionParameters& parameters() const { return law_.parameters; }
  const ServoOptions& options() const { return options_; }
  const ServoStatistics& statistics() const { return statistics_; }
  const PortEnergy& port() const { return port_; }
  /// The account stands last before the device. Empty: the device is given what the bound and the
  /// safety stage let through.
  const std::optional<PortAccount>& account() const { return law_.account; }
  /// The share of the last tick's command that it took off, 0 to 1.
  double account_cut() const noexcept;
  /// The command of the last tick was made here, from the local model alone.
  bool near() const { return near_; }
  /// A law that was adopted waits until the force has faded.
  bool changes_law() const { return next_law_ != nullptr; }
  /// The session's method shapes the force (BoundingMethod::shapes).
  bool shapes() const { return law_.shapes; }
  /// The hand's damping that the methods `credited` and `shaped` count on; empty in other modes.
  std::optional<HandCredit> hand_credit() const { return law_.bounding.hand_credit(); }
  /// The last tick's part for the robot that the hand leads; empty: the hand leads no robot.
  std::optional<Lead> lead() const noexcept;
  /// The robot as the replies tell of it; empty: the hand leads no robot.
  const std::optional<RemoteHand>& remote() const { return remote_; }
  /// The state of the last tick, for observers of the scene.
  HandReport report() const noexcept;
  const ClockEstimate& server_clock() const { return server_clock_; }

  const Sample& sample() const { return sample_; }  // the last one made
  /// The command of the scene, before fade and bound: that of the newest reply, or with a local
  /// model what the model computed at the last tick.
  const Command& command() const {
    return law_.parameters.local_model ? environment_ : newest_.command;
  }
  const Command& held() const { return held_; }  // on the hand since the last tick
  /// Why there is no force on the hand since the last tick; NoForce::felt: there is.
  NoForce no_force() const { return no_force_; }
  /// Oscillation and displayed stiffness so far.
  const HandMeasures& measures() const { return measures_; }
  const Reply& newest_reply() const { return newest_; }
  bool has_reply() const { return newest_.sample_index > 0; }
  /// The scene was changed under the hand, and the bound still keeps some of its force back.
  bool withholds_change() const { return law_.admission && law_.admission->withheld(); }
  /// [s] since the newest reply came, at the last tick.
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
    std::uint64_t datagram = 0;  // whose newest it was, counted from 1; 0: of none
    bool answered = false;
  };

  static bool pulls(const Command& c) { return !c.force().isZero(0.0) || !c.torque.isZero(0.0); }
  bool waits_for_news(const DeviceReading& reading, Nanoseconds now) noexcept;
  void correct(const Command& held) noexcept;
  double time_since_last_tick(Nanoseconds now) noexcept;
  Movement moved_to(const DeviceReading& reading) noexcept;
  void take_model(const Reply& reply, Nanoseconds arrival) noexcept;
  void scene_changed() noexcept;
  bool follow_model(const BoundingStep& step, Nanoseconds now, Command& command) noexcept;
  bool count_modelled(double weight) noexcept;
  double follow_body(const BoundingStep& step, double age, Command& command) noexcept;
  Command rise_limited(const BoundingStep& step) noexcept;
  Command meet_robot(const Tool& tool, const Command& scene, Nanoseconds now,
                     double elapsed) noexcept;
  Command environment(BoundingStep& step, Nanoseconds now) noexcept;
  double fade_factor() const noexcept;
  Command faded(const Command& command, double factor) const noexcept;
  void start_letting_go() noexcept;
  void exchange_law() noexcept;
  void forget_surfaces() noexcept;
  void begin_anew(std::uint64_t last_sample_before) noexcept;
  void let_in(const BoundingStep& step) noexcept;
  Command safeguard(const Command& bounded, const BoundingStep& step, bool original) noexcept;
  Command paid_for(const Command& command, BoundingStep step, bool moved_known) noexcept;
  void observe_direction(const Command& held) noexcept;
  void explain(const Command& held) noexcept;
  void count_answer(const Reply& reply, Nanoseconds arrival) noexcept;
  Command reconstructed(Nanoseconds now) const noexcept;

  DeviceSpec spec_;
  ServoOptions options_;
  ServoLaw law_;
  ServoLaw* next_law_ = nullptr;    // waits until nothing is held
  bool scene_was_changed_ = false;  // since the session was joined
  SafetyStage safety_;
  PortEnergy port_;
  HoldReserve reserve_;
  bool torque_;
  double period_;  // T [s]

  ClockEstimate server_clock_;
  Reply newest_;
  Nanoseconds newest_arrival_{0};
  Nanoseconds newest_sampled_{0};        // when the sample was read that it answers
  std::uint64_t newest_datagram_ = 0;    // in which that sample went
  std::uint64_t withheld_before_ = 0;    // by the servers of sessions before this one
  bool newest_original_ = false;         // its command is the scene's as it was
  bool fresh_ = false;                   // no reply of another session has come yet
  std::uint64_t anew_after_ = 0;         // replies to samples up to this one end no wait
  std::uint64_t stood_still_after_ = 0;  // replies to samples up to this one are out of date
  double command_age_ = 0.0;
  ForceTrail trail_;  // of this tick
  NoForce no_force_ = NoForce::no_reply;
  HandMeasures measures_;
  Vec3 displacement_ = Vec3::Zero();  // [m] of this tick

  // Of sessions with a local model only.
  LocalContact local_;
  LocalBody local_body_;  // of a tool with a body
  VelocityEstimate velocity_;
  RiseLimit rise_;                    // where the method shapes
  std::optional<RemoteHand> remote_;  // where the hand leads
  Nanoseconds remote_time_{0};        // our time of the robot's state
  bool deadman_ = false;              // of the last tick
  std::optional<double> gripper_;     // [m] likewise
  bool near_ = false;
  Vec3 model_moved_ = Vec3::Zero();  // [m] the place where the model was asked
  Vec3 last_offset_ = Vec3::Zero();  // [m] of where the model was asked, to the device
  Nanoseconds model_time_{0};        // our time of the state that the model describes
  Command environment_;              // command(), model and reply together

  Nanoseconds last_tick_{0};
  bool ticked_ = false;          // last_tick_ counts
  bool position_known_ = false;  // sample_.pose was read at the last tick
  bool posed_ = false;           // some reading was good
  bool released_ = false, device_ended_ = false;
  bool letting_go_ = false;   // no reply is used, what is held fades from let_go_from_ on
  bool found_again_ = false;  // for the session was lost: then all begins anew
  Nanoseconds let_go_from_{0};
  Command wanted_;  // the device's part of the command that this tick's force comes from
  Command held_;    // on the hand since the last tick
  Sample sample_;

  std::vector<Sent> sent_;
  ServoStatistics statistics_;
};

}  // namespace feltwire
