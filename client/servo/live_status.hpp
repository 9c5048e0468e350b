#pragma once
// The output of the servo's thread for other threads: a state a few times a second, a row each
// tick.

#include <cstdint>
#include <optional>
#include <string_view>

#include "client/servo/servo.hpp"
#include "client/servo/tick_record.hpp"

namespace feltwire {

/// The way of the datagrams.
struct NetworkStatus {
  std::uint64_t lost = 0;                             // datagrams, up to the newest answered
  double round_trip_p50 = 0.0, round_trip_p99 = 0.0;  // [ns]
  bool clock_known = false;                           // false: the four below are not valid
  double delay_up = 0.0, delay_down = 0.0;            // [s] one way, of the last exchange
  double jitter_up = 0.0, jitter_down = 0.0;          // [s] their mean variation
};

/// The device and its calls.
struct DeviceStatus {
  std::uint64_t faults = 0, jumps = 0;  // as in DeviceCounts
  std::uint64_t slow_ticks = 0;         // DeviceTimes::slow
  double took = 0.0;                    // [s] of its calls in the slowest tick since the last state
};

/// The scene at the server, and the parts of it that are here.
struct SceneStatus {
  bool recovering = false;        // moving objects were put back, and are felt in part
  bool withholds_change = false;  // it was changed, and the hand does not yet feel all of it
  std::uint32_t reloads = 0;      // Reply::reloads of the newest reply
  const FetchedScene* fetched = nullptr;  // in use; null: nothing
};

/// The robot that the hand leads.
struct RobotStatus {
  std::optional<LinkState> state{};  // of the hand and the robot; empty: the hand leads none
  std::string_view name{};           // of its seat; empty: the only one; lives as the servo does
  std::optional<double> turn{};      // [rad] that is missing until the hand is aligned with it
};

/// The energy account.
struct AccountStatus {
  std::optional<double> balance{};  // [J]; empty: there is none
  std::uint64_t cuts = 0;           // ticks at which it reduced the force
};

/// The state of the loop, which the thread publishes a few times a second.
struct LiveStatus {
  double time = 0.0;  // [s] since the first tick
  std::uint64_t samples = 0;
  NetworkStatus network{};
  double force = 0.0;                                    // [N] held now
  ZeroForceReason no_force = ZeroForceReason::no_reply;  // the reason for no force
  FeelMetrics::Squares oscillation{};                    // so far
  std::optional<double> displayed_stiffness{};           // [N/m] so far
  double energy = 0.0;                                   // [J] delivered to the hand so far
  bool answered_lately = false;                          // the command in use is not fading
  bool connected = true;                                 // the session is not lost
  SceneStatus scene{};
  bool shapes = false;                      // the method shapes, and the two below are valid
  bool near = false;                        // this tick's force was made here, from the local model
  std::optional<HandCredit> hand_credit{};  // of a method that adapts to the hand
  std::uint64_t contact_cuts = 0;  // ticks whose contact took too much work, and was cut off
  AccountStatus account{};
  RobotStatus robot{};
  DeviceStatus device{};
};

/// `time` [s] since the first tick; `connected`: the session is not lost.
LiveStatus live_status(const Servo& servo, double time, bool connected) noexcept;

/// The state after the last tick, `time` [s] since the first one, at `now` of the monotonic clock.
TickRecord tick_record(const Servo& servo, double time, Nanoseconds now) noexcept;

}  // namespace feltwire
