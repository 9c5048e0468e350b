// The replies' way from the server to the servo: selects the newest, counts losses.

#include <algorithm>

#include "client/servo/servo.hpp"
#include "protocol/session/deadband.hpp"

namespace feltwire {
namespace {

/// Finite, and small enough for the bound.
bool believable(const Command& c) {
  const auto small = [](const Vec3& v) {
    return v.allFinite() && v.cwiseAbs().maxCoeff() <= kLargestForce;
  };
  return small(c.elastic) && small(c.frictional) && small(c.torque);
}

}  // namespace

bool Servo::take(const Reply& reply, Nanoseconds arrival) noexcept {
  // An answer to a sample that was never sent would lock out all true answers after it.
  if (reply.sample_index == 0 || reply.sample_index > sample_.index || !believable(reply.command)) {
    ++statistics_.replies_refused;
    return false;
  }
  count_answer(reply, arrival);
  if (reply.sample_index <= newest_.sample_index) {
    ++statistics_.replies_stale;
    return false;
  }
  const Command let_go = newest_.command, rates = newest_.rates;
  const bool predicted = newest_.predicted;
  statistics_.scene_resets += reply.recovering && !newest_.recovering ? 1 : 0;
  if (has_reply() && !fresh_ && reply.reloads != newest_.reloads) scene_changed();
  fresh_ = false;
  newest_ = reply;
  if (remote_) newest_.body_modelled = false;  // a point meets the robot
  const Sent& sent = sent_[reply.sample_index % sent_.size()];
  const bool remembered = sent.index == reply.sample_index;
  if (remembered && sent.datagram > 0) newest_datagram_ = sent.datagram;
  // A server may claim any number: never count more than were sent.
  statistics_.withheld = withheld_before_ + std::min(reply.withheld, statistics_.datagrams);
  if (letting_go_) {
    newest_.command = let_go;
    newest_.predicted = predicted;
    newest_.rates = rates;
    return true;
  }
  const bool out_of_date = reply.sample_index <= stood_still_after_;
  newest_arrival_ = out_of_date ? arrival - from_seconds(law_.parameters.hold_time)
                                : std::min(arrival, last_tick_ + 2 * from_seconds(period_));
  newest_sampled_ = remembered ? sent.time : arrival;
  // A command that the server's bound has changed does not tell how deep the hand is: at the first
  // sample the bound lets nothing through, even inside an object.
  newest_original_ =
      reply.sample_index > anew_after_ && !reply.active && !reply.saturated && !reply.refused;
  if (law_.parameters.local_model) take_model(reply, newest_arrival_);
  return true;
}

void Servo::scene_changed() noexcept {
  if (law_.scene_change_gate) law_.scene_change_gate->begin();
  law_.bounding.scene_changed();
  scene_was_changed_ = true;
}

void Servo::take_model(const Reply& reply, Nanoseconds arrival) noexcept {
  const bool body = newest_.body_modelled;
  if (!reply.modelled) local_.clear();
  if (!body) local_body_.clear();
  if (!reply.modelled && !body) return;
  if (reply.modelled) local_.take(reply.model, newest_original_ ? &reply.command : nullptr);
  if (body) local_body_.take(reply.body, sample_.index - reply.sample_index + 1);
  ++statistics_.models;
  statistics_.whole_models += local_.has_whole() || (body && local_body_.has_whole()) ? 1 : 0;
  statistics_.patches += reply.modelled ? reply.model.view().size() : reply.body.view().size();
  // Moving objects have moved since the server looked. The clocks give the time of the way back,
  // which is believed up to the hold time of a command.
  const double since = std::clamp(server_clock_.delay_down(), 0.0, law_.parameters.hold_time);
  model_time_ = arrival - from_seconds(since);
  if (!remote_) return;
  remote_->take(reply.remote.value_or(Remote{}));
  if (reply.remote) link_states_.take(reply.remote->state, reply.remote->seat, arrival);
  const double robot = std::min(remote_->remote().age, law_.parameters.hold_time);
  remote_time_ = model_time_ - from_seconds(robot);
}

void Servo::count_answer(const Reply& reply, Nanoseconds arrival) noexcept {
  const std::uint64_t index = reply.sample_index;
  Sent& sent = sent_[index % sent_.size()];
  if (sent.index != index) {  // so old that its place is taken
    ++statistics_.answered;
    ++statistics_.late;
    return;
  }
  if (sent.answered) return;
  sent.answered = true;
  const Nanoseconds round_trip = arrival - sent.time;
  ++statistics_.answered;
  if (round_trip > kLate) ++statistics_.late;
  statistics_.round_trip.record(round_trip.count());
  count(round_trips_, hand_time_limits::kRoundTrips, round_trip);
  server_clock_.take({sent.time, reply.server_receive_time, reply.server_send_time, arrival});
}

void Servo::sent() noexcept {
  sent_[sample_.index % sent_.size()].datagram = ++statistics_.datagrams;
}

std::uint64_t Servo::lost_so_far() const noexcept {
  const std::uint64_t heard_of = statistics_.answered + statistics_.withheld;
  return newest_datagram_ - std::min(newest_datagram_, heard_of);
}

std::uint64_t Servo::lost() const noexcept {
  const SessionParameters& p = law_.parameters;
  const double silent = p.keep_alive / (p.packet_interval * p.servo_period);
  const auto allowed = p.force_deadband > 0.0 ? static_cast<std::uint64_t>(silent) : 0;
  const std::uint64_t since = statistics_.datagrams - newest_datagram_;
  return lost_so_far() + since - std::min(since, allowed);
}

/// The newest command, extrapolated to now. For the samples since then the server withheld its
/// answer, because this is what it would have said.
Command Servo::reconstructed(Nanoseconds now) const noexcept {
  if (!newest_.predicted) return newest_.command;
  const double ahead = std::min(seconds(now - newest_sampled_), law_.parameters.keep_alive);
  const Command later = extrapolated(newest_.command, newest_.rates, ahead);
  return believable(later) ? later : newest_.command;
}

}  // namespace feltwire
