#include "client/servo/reply_intake.hpp"

#include <algorithm>

#include "protocol/session/deadband.hpp"

namespace feltwire {
namespace {

constexpr Nanoseconds kLate = std::chrono::milliseconds(1);

// Number of samples that the client remembers until their replies arrive: 8 s at 1 kHz, 0.8 s at 10
// kHz. Later replies still count as answered and late.
constexpr std::size_t kRemembered = 8192;

/// Returns whether the command is finite and so small that the force bound can process it.
bool believable(const Command& c) {
  const auto small = [](const Vec3& v) {
    return v.allFinite() && v.cwiseAbs().maxCoeff() <= kLargestForce;
  };
  return small(c.elastic) && small(c.frictional) && small(c.torque);
}

}  // namespace

ReplyIntake::ReplyIntake(double period, bool point)
    : period_(period), point_(point), sent_(kRemembered) {}

ReplyIntake::Taken ReplyIntake::take(const Reply& reply, Nanoseconds arrival, const State& servo,
                                     double hold_time, ReplyCounts& counts) noexcept {
  // Refuse a reply to a future sample. It would make all true replies stale.
  if (reply.sample_index == 0 || reply.sample_index > servo.newest_sample ||
      !believable(reply.command)) {
    ++counts.refused;
    return {};
  }
  count_answer(reply, arrival, counts);
  if (reply.sample_index <= newest_.sample_index) {
    ++counts.stale;
    return {};
  }
  Taken taken{.newest = true, .used = !servo.fades};
  const Command command = newest_.command, rates = newest_.rates;
  const bool predicted = newest_.predicted;
  counts.scene_resets += reply.recovering && !newest_.recovering ? 1 : 0;
  taken.scene_changed = has_reply() && !fresh_ && reply.reloads != newest_.reloads;
  fresh_ = false;
  newest_ = reply;
  if (point_) newest_.body_modelled = false;
  const Sent& sent = sent_[reply.sample_index % sent_.size()];
  const bool remembered = sent.index == reply.sample_index;
  if (remembered && sent.datagram > 0) datagram_ = sent.datagram;
  // The server may report any number, so count at most the sent datagrams.
  counts.withheld = withheld_before_ + std::min(reply.withheld, counts.datagrams);
  if (servo.fades) {
    newest_.command = command;
    newest_.predicted = predicted;
    newest_.rates = rates;
    return taken;
  }
  const bool out_of_date = reply.sample_index <= stood_still_after_;
  arrival_ = out_of_date ? arrival - from_seconds(hold_time)
                         : std::min(arrival, servo.last_tick + 2 * from_seconds(period_));
  sampled_ = remembered ? sent.time : arrival;
  // The server's force bound may have changed the command. Such a command does not show the depth
  // of the hand: at the first sample the bound gives no force, even inside an object.
  original_ = reply.sample_index > anew_after_ && !reply.bound.active && !reply.bound.saturated &&
              !reply.bound.refused;
  return taken;
}

void ReplyIntake::count_answer(const Reply& reply, Nanoseconds arrival,
                               ReplyCounts& counts) noexcept {
  const std::uint64_t index = reply.sample_index;
  Sent& sent = sent_[index % sent_.size()];
  if (sent.index != index) {  // a newer sample uses this entry
    ++counts.answered;
    ++counts.late;
    return;
  }
  if (sent.answered) return;
  sent.answered = true;
  const Nanoseconds round_trip = arrival - sent.time;
  ++counts.answered;
  if (round_trip > kLate) ++counts.late;
  counts.round_trip.record(round_trip.count());
  count(round_trips_, hand_time_limits::kRoundTrips, round_trip);
  server_clock_.take({sent.time, reply.server_times.received, reply.server_times.sent, arrival});
}

void ReplyIntake::begin_anew(std::uint64_t sample) noexcept {
  anew_after_ = sample;
  original_ = false;
}

void ReplyIntake::another_session(const ReplyCounts& counts) noexcept {
  withheld_before_ = counts.withheld;
  fresh_ = true;
}

void ReplyIntake::move_times(Nanoseconds by) noexcept {
  arrival_ += by;
  sampled_ += by;
}

void ReplyIntake::forget_command() noexcept {
  newest_.command = {};
  newest_.predicted = false;
}

Command ReplyIntake::command(Nanoseconds now, double keep_alive) const noexcept {
  if (!newest_.predicted) return newest_.command;
  const double ahead = std::min(seconds(now - sampled_), keep_alive);
  const Command later = extrapolated(newest_.command, newest_.rates, ahead);
  return believable(later) ? later : newest_.command;
}

std::uint64_t ReplyIntake::lost_so_far(const ReplyCounts& counts) const noexcept {
  const std::uint64_t heard_of = counts.answered + counts.withheld;
  return datagram_ - std::min(datagram_, heard_of);
}

std::uint64_t ReplyIntake::lost(const SessionParameters& p,
                                const ReplyCounts& counts) const noexcept {
  const double silent = p.keep_alive / (p.packet_interval * p.servo_period);
  const auto allowed = p.force_deadband > 0.0 ? static_cast<std::uint64_t>(silent) : 0;
  const std::uint64_t since = counts.datagrams - datagram_;
  return lost_so_far(counts) + since - std::min(since, allowed);
}

}  // namespace feltwire
