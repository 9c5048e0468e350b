#pragma once
// The reason for no force on the hand, one for every tick.

#include <array>
#include <cstdint>
#include <string_view>

#include "client/device/device.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// Below these limits a force counts as none; the status line prints it as 0.00 N.
inline constexpr double kFeltForce = 0.005;    // [N]
inline constexpr double kFeltTorque = 0.0005;  // [N m] the same at a lever of 0.1 m

/// Whether a command counts as a force or a torque.
bool is_felt(const Command& command) noexcept;

/// The reasons for no force, in the order in which they are checked: from the device's reading to
/// the force that it holds.
enum class ZeroForceReason : std::uint8_t {
  felt,             // there is force, and no wait takes most of it
  observer,         // an observer gets no force
  device_ended,     // the recording is over
  ending,           // the run ends and the hand is released
  device_fault,     // the device gave no usable position
  no_reply,         // the server has not answered yet
  reconnecting,     // the session was lost and continues: the held force fades first
  silent,           // the newest answer is too old: the command has faded
  recovering,       // the server has reset moving bodies
  server_bound,     // the server's bound allows no force
  touches_nothing,  // the scene asks for none
  too_little,       // the scene asks for less than kFeltForce
  not_actuated,     // the device cannot give the command of the scene
  waiting,          // --wait-for-small-force: it takes off most of the force or all
  refused,          // the command or the movement was out of range
  bound,            // this side's bound allows no force
  velocity_limit,   // --velocity-limit
  ramp,             // --ramp-up
  slew,             // --slew
  force_limit,      // --max-force
  account,          // the port has not burned enough
  not_held,         // the device does not hold its command
  law_change,       // an admin gave the session another law: the held force fades first
  clutched,         // the hand moves without the tool
  not_homed,        // the encoders of the device have not found their zero
  in_inkwell,       // the stylus is in its holder
  starting,         // the hand is not still yet, or the force for the tool's weight still grows
  emergency,        // the emergency stop was pressed
  jumped,           // no hand can have moved to the place that the device gave
  overdrawn,        // the hand got more energy than the device burned: the force has ended
  not_moved         // the program that moves the hand has given no pose for too long
};
inline constexpr std::size_t kZeroForceReasons =
    static_cast<std::size_t>(ZeroForceReason::not_moved) + 1;

/// The name in the report: "touches_nothing".
std::string_view name(ZeroForceReason reason);
/// The text for people: "touches nothing"; empty for `felt`.
std::string_view text(ZeroForceReason reason);

/// A command after each stage of its way to the hand.
struct CommandTrail {
  Command asked{};     // the scene's command
  Command actuated{};  // the part that the device can give
  Command faded{};     // after the fade by age
  Command bounded{}, safe{}, paid{}, held{};
};

/// The device's reading of one tick.
struct ReadingTrail {
  bool ended = false;     // the recording is over
  bool usable = true;     // its position
  bool jumped = false;    // no hand can have moved to that position
  bool clutched = false;  // no command was computed: the hand moves without the tool
  Withheld withheld = Withheld::nothing;  // no command was computed, for a reason of the device
};

/// The newest reply.
struct ReplyTrail {
  bool answered = false;      // at least one has come
  bool silent = false;        // it is older than the hold time
  bool recovering = false;    // it says so
  bool server_bound = false;  // it says that the server's bound reduced the force
};

/// The safety limits: they allow no force yet, or reduced it.
struct SafetyTrail {
  bool waits = false, too_fast = false, ramped = false, slewed = false;
};

/// The way of one command to the hand in one tick.
struct ForceTrail {
  bool observer = false, released = false, letting_go = false;
  bool law_change = false;  // the reason that the force fades
  bool overdrawn = false;   // a debt of the account has ended the force
  bool refused = false;     // the command or the movement was out of range
  bool in_debt = false;     // the bound says so
  ReadingTrail device{};
  ReplyTrail reply{};
  SafetyTrail safety{};
  CommandTrail command{};
};

/// The first stage after which there is no force any more.
ZeroForceReason zero_force_reason(const ForceTrail& trail) noexcept;

/// The reason of a whole run without force, from the ticks of each reason. A reason that kept a
/// force away counts before the absence of one, if it applied at one tick in a hundred or more.
ZeroForceReason prevailing(const std::array<std::uint64_t, kZeroForceReasons>& ticks) noexcept;

}  // namespace feltwire
