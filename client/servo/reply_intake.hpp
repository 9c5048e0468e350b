#pragma once
// Second stage of a tick: the replies' way from the server to the servo. Selects the newest, counts
// round trips and losses, and estimates the server's clock.

#include <cstdint>
#include <vector>

#include "client/servo/clock_estimate.hpp"
#include "client/servo/servo_statistics.hpp"
#include "protocol/session/session_parameters.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Keeps the newest reply and the samples that wait for theirs. Allocates only when it is made.
class ReplyIntake {
 public:
  /// The servo's state when a reply comes.
  struct State {
    std::uint64_t newest_sample = 0;  // index of the newest sample
    Nanoseconds last_tick{0};
    bool fades = false;  // the held force fades: the reply's command is not used
  };
  /// The use of a reply.
  struct Taken {
    bool newest = false;         // it is the newest so far
    bool used = false;           // its command counts from now on
    bool scene_changed = false;  // the scene was loaded anew since the reply before
  };

  /// `point`: replies for a tool with a body are read as those for a point.
  ReplyIntake(double period, bool point);

  /// Takes a reply that was found at `arrival`. One that is not finite, out of range, or answers no
  /// sample that was made changes nothing but a count.
  Taken take(const Reply& reply, Nanoseconds arrival, const State& servo, double hold_time,
             ReplyCounts& counts) noexcept;

  /// A sample was made at this time.
  void made(std::uint64_t sample, Nanoseconds time) noexcept {
    sent_[sample % sent_.size()] = {sample, time, 0, false};
  }
  /// That sample was the newest of a datagram that was sent.
  void sent(std::uint64_t sample, ReplyCounts& counts) noexcept {
    sent_[sample % sent_.size()].datagram = ++counts.datagrams;
  }

  /// The servo stood still. A reply to a sample up to this one may have come at any time since.
  void stood_still(std::uint64_t sample) noexcept { stood_still_after_ = sample; }
  /// Replies to samples up to this one do not tell where the hand is now.
  void begin_anew(std::uint64_t sample) noexcept;
  /// Replies are those of another session from now on.
  void another_session(const ReplyCounts& counts) noexcept;
  /// The clock was set back: what was remembered moves by `by`.
  void move_times(Nanoseconds by) noexcept;
  /// Forgets the command of the newest reply.
  void forget_command() noexcept;

  /// The newest command, extrapolated to now, for `keep_alive` [s] at most. The server withheld its
  /// answers since then because they would say this.
  Command command(Nanoseconds now, double keep_alive) const noexcept;

  bool has_reply() const noexcept { return newest_.sample_index > 0; }
  const Reply& newest() const noexcept { return newest_; }
  /// Whether the newest command is the scene's own: no bound of the server changed it, and it is of
  /// the present contact.
  bool original() const noexcept { return original_; }
  Nanoseconds arrival() const noexcept { return arrival_; }
  /// [s] since the newest reply arrived; 0: none has.
  double age(Nanoseconds now) const noexcept { return has_reply() ? seconds(now - arrival_) : 0.0; }
  /// [s] from the reading of the answered sample to the arrival.
  double round_trip() const noexcept { return has_reply() ? seconds(arrival_ - sampled_) : 0.0; }
  const ClockEstimate& server_clock() const noexcept { return server_clock_; }
  /// Replies so far, by their round trip.
  const HandTimes::Counts& round_trips() const noexcept { return round_trips_; }

  /// Lost datagrams, up to the newest one that was answered.
  std::uint64_t lost_so_far(const ReplyCounts& counts) const noexcept;
  /// Datagrams that were lost, or whose replies were lost (Servo::lost()).
  std::uint64_t lost(const SessionParameters& parameters, const ReplyCounts& counts) const noexcept;

 private:
  /// A sample that waits for its reply.
  struct Sent {
    std::uint64_t index = 0;
    Nanoseconds time{0};
    std::uint64_t datagram = 0;  // the datagram whose newest sample it was, counted from 1; 0: none
    bool answered = false;
  };

  void count_answer(const Reply& reply, Nanoseconds arrival, ReplyCounts& counts) noexcept;

  double period_;
  bool point_;
  ClockEstimate server_clock_;
  Reply newest_;
  Nanoseconds arrival_{0};
  Nanoseconds sampled_{0};               // the time of the reading of the answered sample
  std::uint64_t datagram_ = 0;           // the datagram with that sample
  std::uint64_t withheld_before_ = 0;    // withheld in earlier sessions
  bool original_ = false;                // original()
  bool fresh_ = false;                   // no reply of another session has come yet
  std::uint64_t anew_after_ = 0;         // replies to samples up to this one end no wait
  std::uint64_t stood_still_after_ = 0;  // replies to samples up to this one are out of date
  std::vector<Sent> sent_;
  HandTimes::Counts round_trips_{};
};

}  // namespace feltwire
