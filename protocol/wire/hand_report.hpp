#pragma once
// The report of a client about its hand, for observers. No force depends on it.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <utility>

#include "protocol/wire/hand_times.hpp"

namespace feltwire {

/// The reasons of the force on a hand, as its client knows them. Several may apply at once. The
/// order is that of the bits on the wire.
enum class HandReason : std::uint8_t {
  near,          // the force is computed beside the device, from the local model
  late,          // it comes from the server, as late as the network
  bound,         // the client's bound reduced it
  account,       // its account reduced it: the device had not burned enough
  limits,        // its safety limits reduced it
  saturated,     // the device cannot give so much
  faded,         // the newest answer is old, so the force fades
  reconnecting,  // the session was lost; the held force fades
  scene_change,  // the scene changed under the hand, and the force comes back gradually
  device_fault,  // the device gave no usable position, or did not hold its command
  law_change,    // an admin gave the session another law; the held force fades first
  // The reasons from here on detail another one that is set too, or stand alone.
  ramp,                  // of limits: the force still grows after the first contact
  slew,                  // of limits: the force rises no faster
  velocity_limit,        // of limits: the device is too fast
  wait_for_small_force,  // of limits: the hand has to move out of contact first
  shaping,               // of bound: the method shapes the force, and reduced it
  debt,                  // the hand got more energy than the device had burned
  clutched,              // the hand moves without the tool
  not_ready,             // the device is not homed, in its inkwell, or has to be held still
  emergency,             // the emergency stop was pressed
  ending,                // the client ends; the held force fades first
  count_of_reasons
};
inline constexpr std::size_t kHandReasons = static_cast<std::size_t>(HandReason::count_of_reasons);
/// The bits that are known.
inline constexpr std::uint32_t kAllHandReasons = (1u << kHandReasons) - 1;
constexpr std::uint32_t bit(HandReason reason) { return 1u << static_cast<unsigned>(reason); }

/// By HandReason: a name, and a sentence for people.
inline constexpr std::array<std::pair<std::string_view, std::string_view>, kHandReasons>
    kHandReasonTexts = {{
        {"near", "The force is computed beside the device, from a local model of the surface."},
        {"late", "The force comes from the server, as late as the network is."},
        {"bound", "The client's energy bound takes something off the force."},
        {"account",
         "The energy account takes something off the force: the device has not burned enough yet."},
        {"limits", "A safety limit of the client takes something off the force."},
        {"saturated", "The device cannot give so much force."},
        {"faded", "The server's newest answer is old, so the force fades."},
        {"reconnecting", "The session was lost. The force fades until it goes on."},
        {"scene_change",
         "The scene changed under the hand. The force comes back little by little."},
        {"device_fault", "The device gave no usable position, or did not hold its force."},
        {"law_change",
         "An admin gave the session another law. The force fades, then the hand has to press on."},
        {"ramp", "The force still grows after the first contact (--ramp-up)."},
        {"slew", "The force may rise only slowly (--slew)."},
        {"velocity_limit", "The hand is faster than --velocity-limit allows."},
        {"wait_for_small_force",
         "The force waits: the hand has to move out of contact first (--wait-for-small-force)."},
        {"shaping",
         "The client's shaping takes something off the force, so that it does not "
         "oscillate."},
        {"debt",
         "The hand got more energy than the device had burned. The device has to burn it first."},
        {"clutched", "The clutch is held: the hand moves without the tool."},
        {"not_ready",
         "The device gives no force yet: it must be homed, taken out of its inkwell or held "
         "still."},
        {"emergency", "The emergency stop was pressed."},
        {"ending", "The client ends. The force fades out."},
    }};

/// Calls visit(name) for each reason of a report.
template <class Visit>
void for_each_reason(std::uint32_t reasons, Visit visit) {
  for (std::size_t i = 0; i < kHandReasons; ++i)
    if ((reasons >> i & 1u) != 0) visit(std::string_view(kHandReasonTexts[i].first));
}

/// [J] An account that is overdrawn by less is not said to be in debt, and no flight record is
/// written for it: a tick that is nanoseconds late overdraws it, and nobody feels so little. It is
/// a hundredth of the energy of a touch of 0.1 N over 1 mm.
inline constexpr double kSmallDebt = 1e-6;
constexpr bool is_debt(double balance) { return balance < -kSmallDebt; }

struct HandReport {
  std::uint32_t reasons = 0;  // bits of HandReason
  bool has_account = false;
  double balance =
      0.0;  // [J] of its account: the energy that may still leave; 0 without an account
  double round_trip = 0.0;    // [s] of the newest answer; 0: none has come
  double hand_damping = 0.0;  // [N s/m] of the hand that its shaping assumes now
  /// Servo ticks so far that came a whole period late or more, modulo 2^24.
  std::uint32_t late_ticks = 0;
  static constexpr std::uint32_t kLateTicksMask = (1u << 24) - 1;
  /// The number of the newest change that the client has handled (ClientChange), and whether it
  /// refused it; 0: none.
  std::uint8_t change = 0;
  bool change_refused = false;
  std::optional<HandTimes> times{};  // mostly empty

  bool finite() const noexcept {
    return std::isfinite(balance) && std::isfinite(round_trip) && std::isfinite(hand_damping);
  }
};

/// [s] A report travels at most once in this time.
inline constexpr double kBetweenReports = 0.03;

}  // namespace feltwire
