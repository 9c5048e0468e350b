#include "client/servo/servo_loop.hpp"

#include <algorithm>
#include <array>
#include <cerrno>

#include "client/servo/lost_session.hpp"
#include "client/servo/requested_changes.hpp"
#include "client/servo/tick_wait.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/numeric.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr Nanoseconds kStatusPeriod = std::chrono::milliseconds(250);
constexpr Nanoseconds kFarewell = std::chrono::milliseconds(100);  // longest wait for replies
constexpr Nanoseconds kLowering = std::chrono::seconds(2);  // longest time to lower a tool's weight
// Check the deadline after this number of datagrams. Dropped datagrams count too, so that a sender
// cannot delay a tick.
constexpr int kDatagramsAtOnce = 64;

class Loop {
 public:
  Loop(Device& device, Servo& servo, Transport& transport, const LoopOptions& options,
       const Event& stop, const LoopOutputs& outputs, LoopResult& result) noexcept
      : device_(device, from_seconds(servo.parameters().servo_period), result.device),
        servo_(servo),
        transport_(transport),
        options_(options),
        stop_(stop),
        outputs_(outputs),
        result_(result),
        port_(transport.port()),
        delayed_(port_.delays()),
        last_tick_(monotonic_now()),
        wait_(port_, stop, last_tick_, from_seconds(servo.parameters().servo_period),
              options.busy_poll, device.longest_tick().count() > 0),
        session_(last_tick_),
        next_status_(last_tick_) {}

  void run() noexcept {
    result_.paced = wait_.paced();
    for (bool running = true; running;) {
      if (wait(TickWait::For::replies_and_stop) < 0) {
        if (errno == EINTR) continue;
        break;
      }
      const Nanoseconds now = monotonic_now();
      if (delayed_) port_.pass(now);
      running = step(now);
    }
    let_go();
    device_.release();
    take_leave(monotonic_now());
  }

 private:
  int wait(TickWait::For what) noexcept {
    return wait_.wait(device_,
                      {.last_tick = last_tick_,
                       .hold_time = servo_.parameters().hold_time,
                       .reply_awaited = servo_.newest_reply().sample_index < servo_.sample().index},
                      what);
  }

  /// Handles a wake-up. Returns false at the end of the loop.
  bool step(Nanoseconds now) noexcept {
    if (wait_.reply_is_there() || delayed_) take_replies(now);
    if (session_.server_left() && !lose(now, EndReason::server_goodbye)) return false;
    if (stop_.is_set()) return end(EndReason::requested);
    if (!is_due(now)) return true;

    // Restore the session before the tick. The hand must not feel a force from before the loss.
    if (options_.rejoined != nullptr) regain(now);
    if (options_.changes != nullptr) change(now);
    if (options_.fetched != nullptr) take_fetched();
    tick(now);
    if (servo_.device_ended()) return end(EndReason::device_ended);
    if (options_.duration.count() > 0 && now - first_tick_ >= options_.duration)
      return end(EndReason::duration);
    if (options_.silence_timeout.count() > 0 &&
        session_.silent_for(now) > options_.silence_timeout && !lose(now, EndReason::server_silent))
      return false;
    return !session_.lost() || session_.lost_for(now) < options_.patience ||
           end(session_.lost_by());
  }

  /// Returns whether a tick is due.
  bool is_due(Nanoseconds now) noexcept {
    const TickWait::Due tick = wait_.due(now, last_tick_, ticked_);
    if (!tick.due) return false;
    result_.overruns += tick.missed > 0 ? 1 : 0;
    result_.missed_deadlines += tick.missed;
    if (tick.late) result_.wakeup_late.record(tick.late->count());
    return true;
  }

  /// Handles the loss of the session by a goodbye or by silence. Returns false if the loop ends.
  bool lose(Nanoseconds now, EndReason reason) noexcept {
    if (options_.rejoined == nullptr || options_.patience.count() <= 0) return end(reason);
    if (!session_.lose(now, reason)) return true;
    ++result_.disconnections;
    next_status_ = now;
    return true;
  }

  /// Continues with a new session, or with the old one if the server answers again.
  void regain(Nanoseconds now) noexcept {
    SessionAddress to;
    bool fresh = false;
    while (options_.rejoined->pop(to)) {
      fresh = transport_.resume(to);
      requested_.next_session();
    }
    if (!fresh && session_.may_reroute(now)) port_.reroute();
    // Accept a late session too. Otherwise the server would keep a session without a client.
    if (fresh) session_.heard(now);
    if (!fresh && !session_.answered_again()) return;
    if (fresh) requested_.begin_anew();
    servo_.reconnected(fresh);
    next_status_ = now;
    const Nanoseconds lost_for = session_.lost_for(now);
    if (!session_.found()) return;
    ++result_.reconnections;
    result_.disconnected += seconds(lost_for);
  }

  /// Applies the prepared changes that an admin requested.
  void change(Nanoseconds now) noexcept {
    PreparedChange* next = nullptr;
    while (options_.changes->pop(next)) {
      if (!next->refused && next->link) port_.set_link(*next->link);
      if (!next->refused && next->law) servo_.adopt(*next->law);
      next->taken = ticked_ ? seconds(now - first_tick_) : 0.0;
      if (requested_.answered(*next)) reported_ = Nanoseconds{0};  // with the next sample
    }
  }

  void take_fetched() noexcept {
    const FetchedScene* fetched = nullptr;
    while (options_.fetched->pop(fetched)) servo_.use(fetched);
  }

  bool end(EndReason reason) noexcept {
    result_.end = reason;
    return false;
  }

  void tick(Nanoseconds now) noexcept {
    if (!ticked_) first_tick_ = now;
    ticked_ = true;
    last_tick_ = now;
    // Stop sending after a goodbye. Keep sending to a silent server: only the return path may be
    // down.
    const Sample* sample =
        wait_.device_missed() ? servo_.missed_tick(device_, now) : servo_.tick(device_, now);
    if (sample != nullptr && !session_.server_left()) send(*sample);
    result_.duration = seconds(now - first_tick_);
    record(now);
    if (now >= next_status_) report_status(now);
  }

  /// Sends the sample, and periodically a report for observers.
  void send(const Sample& sample) noexcept {
    std::optional<HandReport> report;
    if (seconds(sample.client_time - reported_) >= kBetweenReports && !servo_.options().observes)
      report = told();
    if (!transport_.send(sample, report, servo_.lead())) return;
    servo_.sent();
    if (report) reported_ = sample.client_time;
    if (report && report->times) times_told_ = sample.client_time;
  }

  HandReport told() const noexcept {
    HandReport report = servo_.report();
    if (seconds(servo_.sample().client_time - times_told_) >= kBetweenTimes)
      report.times = {wait_.wakeups(), servo_.round_trips()};
    report.late_ticks = static_cast<std::uint32_t>(result_.overruns) & HandReport::kLateTicksMask;
    requested_.tell(report);
    return report;
  }

  void take_replies(Nanoseconds now) noexcept {
    for (int left = kDatagramsAtOnce; left > 0;) {
      const Transport::Arrival arrival = transport_.receive(reply_, result_.goodbye, left);
      if (arrival == Transport::Arrival::nothing) return;
      if (arrival == Transport::Arrival::goodbye) {
        session_.server_leaves();
        return;
      }
      if (!servo_.take(reply_, now)) continue;
      session_.heard(now);
      if (outputs_.wanted != nullptr) requested_.hear(reply_.change, *outputs_.wanted);
      if (outputs_.views != nullptr) show(now);
    }
  }

  void show(Nanoseconds now) noexcept {
    const SceneView* view = transport_.view();
    if (view != nullptr && !outputs_.views->push({seconds(now - first_tick_), *view}))
      ++result_.views_dropped;
  }

  /// Continues the ticks until the force has faded to zero, then lowers the tool.
  void let_go() noexcept {
    Nanoseconds now = monotonic_now();
    if (session_.lost()) {
      result_.lost_for = seconds(session_.lost_for(now));
      result_.lost_by = session_.lost_by();
      result_.disconnected += result_.lost_for;
    }
    servo_.release();
    if (delayed_) port_.pass(now);
    tick(now);
    // Stop waiting if the device holds a force against all commands.
    const Nanoseconds latest = now + from_seconds(servo_.parameters().hold_time);
    while (!servo_.let_go() && now < latest) {
      if (wait(TickWait::For::replies) < 0 && errno != EINTR)
        return tick(latest);  // waiting failed
      now = monotonic_now();
      if (delayed_) port_.pass(now);
      take_replies(now);
      if (is_due(now)) tick(now);
    }
    lower_tool();
  }

  /// Continues the ticks until the hand carries the weight of the tool.
  void lower_tool() noexcept {
    const Nanoseconds latest = monotonic_now() + kLowering;
    Nanoseconds now = monotonic_now();
    bool lowered = device_.lower_tool(now);
    while (!lowered && now < latest) {
      if (wait(TickWait::For::replies) < 0 && errno != EINTR) return;
      now = monotonic_now();
      if (delayed_) port_.pass(now);
      take_replies(now);
      if (!is_due(now)) continue;
      lowered = device_.lower_tool(now);
      tick(now);
    }
  }

  /// Waits for the replies in transit, so that they count, then sends the goodbye.
  void take_leave(Nanoseconds now) noexcept {
    Nanoseconds latest = now + kFarewell;
    while (!session_.server_left() && servo_.awaits_answer() && now < latest) {
      // The server may still answer a datagram that leaves the port now.
      const auto due = port_.next_due();
      if (due) latest = std::max(latest, *due + kFarewell);
      const Nanoseconds wake = due ? std::min(latest, *due) : latest;
      if (wait_.wait_for_reply(wake) < 0 && errno != EINTR) break;
      now = monotonic_now();
      if (delayed_) port_.pass(now);
      take_replies(now);
    }
    transport_.goodbye();
    report_status(now);
  }

  void record(Nanoseconds now) noexcept {
    if (outputs_.record == nullptr && outputs_.listener == nullptr) return;
    const TickRecord row = tick_record(servo_, seconds(now - first_tick_), now);
    if (outputs_.record != nullptr && !outputs_.record->push(row)) ++result_.records_dropped;
    if (outputs_.listener != nullptr) outputs_.listener->ticked(row, !session_.lost());
  }

  void report_status(Nanoseconds now) noexcept {
    next_status_ = now + kStatusPeriod;
    if (outputs_.status == nullptr) return;
    LiveStatus status = live_status(servo_, seconds(now - first_tick_), !session_.lost());
    status.device.slow_ticks = result_.device.slow;
    status.device.took = seconds(device_.take_longest());
    outputs_.status->push(status);
  }

  TimedDevice device_;
  Servo& servo_;
  Transport& transport_;
  const LoopOptions& options_;
  const Event& stop_;
  const LoopOutputs& outputs_;
  LoopResult& result_;
  DatagramPort& port_;
  bool delayed_;
  Nanoseconds last_tick_;
  TickWait wait_;
  LostSession session_;
  RequestedChanges requested_;
  Reply reply_;
  bool ticked_ = false;
  Nanoseconds first_tick_{0}, next_status_, reported_{0}, times_told_{0};
};

}  // namespace

std::string_view name(EndReason reason) {
  static constexpr std::array<std::string_view, 7> names = {
      "duration",      "device_ended", "requested", "server_goodbye",
      "server_silent", "refused",      "failed"};
  return enum_name(names, reason);
}

bool never_sleeps(Nanoseconds busy_poll, Nanoseconds period) noexcept {
  return busy_poll >= period / 2;
}

void run_servo_loop(Device& device, Servo& servo, Transport& transport, const LoopOptions& options,
                    const Event& stop, const LoopOutputs& outputs, LoopResult& result) noexcept {
  Loop(device, servo, transport, options, stop, outputs, result).run();
}

}  // namespace feltwire
