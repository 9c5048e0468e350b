#include "client/servo/servo_loop.hpp"

#include <poll.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <ctime>

#include "client/servo/deadlines.hpp"
#include "core/base/enum_names.hpp"
#include "core/base/numeric.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

// Period of the search for another route to a silent server. It leaves time for an answer over the
// last route.
constexpr Nanoseconds kReroutePeriod = std::chrono::seconds(1);
constexpr Nanoseconds kStatusPeriod = std::chrono::milliseconds(250);
constexpr Nanoseconds kFarewell = std::chrono::milliseconds(100);  // longest wait for replies
constexpr Nanoseconds kLowering = std::chrono::seconds(2);  // longest time to lower a tool's weight
// Check the deadline after this number of datagrams. Dropped datagrams count too, so that a sender
// cannot delay a tick.
constexpr int kDatagramsAtOnce = 64;

timespec to_timespec(Nanoseconds time) noexcept {
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(time);
  return {.tv_sec = static_cast<time_t>(whole.count()),
          .tv_nsec = static_cast<long>((time - whole).count())};
}

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
        start_(monotonic_now()),
        period_(from_seconds(servo.parameters().servo_period)),
        paced_(device.longest_tick().count() > 0),
        deadlines_(start_, period_),
        waiting_{{{port_.descriptor(), POLLIN, 0}, {stop.descriptor(), POLLIN, 0}}},
        last_tick_(start_),
        last_heard_(start_),
        next_status_(start_) {}

  void run() noexcept {
    result_.paced = paced_;
    for (bool running = true; running;) {
      if (wait(waiting_.size()) < 0) {
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
  /// Waits until one of the first `count` descriptors is ready, a tick is due, or a datagram of the
  /// emulated link is due. Sleeps if neither a reply nor a deadline is near. Uses no other timer,
  /// because its interrupt would delay the tick.
  int wait(std::size_t count) noexcept {
    if (paced_) return await_device(count);
    const auto due = port_.next_due();
    while (true) {
      const Nanoseconds now = monotonic_now();
      const bool late = now >= deadlines_.next() || (due && *due <= now);
      if (late || looks_busily(now)) {
        const int ready = ::poll(waiting_.data(), count, 0);
        if (late || ready != 0) return ready;
        continue;
      }
      Nanoseconds wake = deadlines_.next() - std::max(options_.busy_poll, deadlines_.lead());
      if (due) wake = std::min(wake, *due);
      const timespec left = to_timespec(std::max(wake - now, Nanoseconds(0)));
      const int woken = ::ppoll(waiting_.data(), count, &left, nullptr);
      if (woken == 0) deadlines_.woken(monotonic_now() - wake);
      if (woken != 0 || due == wake) return woken;
    }
  }
  /// Waits for the tick of the device. It counts as missed if it is late by a quarter of the hold
  /// time. After a return without a tick, the loop waits again after a servo period.
  int await_device(std::size_t count) noexcept {
    constexpr double kPatience = 0.25;
    overdue_at_ = last_tick_ + from_seconds(kPatience * servo_.parameters().hold_time);
    device_ticked_ = device_.await_tick(overdue_at_);
    Nanoseconds rest{0};
    if (!device_ticked_) rest = std::clamp(overdue_at_ - monotonic_now(), Nanoseconds(0), period_);
    const timespec sleeps = to_timespec(rest);
    return ::ppoll(waiting_.data(), count, &sleeps, nullptr);
  }
  bool looks_busily(Nanoseconds now) const noexcept {
    if (options_.busy_poll == kForever) return true;
    const bool reply_near = servo_.newest_reply().sample_index < servo_.sample().index &&
                            now - last_tick_ < options_.busy_poll;
    return reply_near || deadlines_.next() - now <= std::max(options_.busy_poll, deadlines_.lead());
  }

  /// Handles a wake-up. Returns false at the end of the loop.
  bool step(Nanoseconds now) noexcept {
    if (waiting_[0].revents != 0 || delayed_) take_replies(now);
    if (server_left_ && !lose(now, EndReason::server_goodbye)) return false;
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
    if (options_.silence_timeout.count() > 0 && now - last_heard_ > options_.silence_timeout &&
        !lose(now, EndReason::server_silent))
      return false;
    return !lost_ || now - lost_at_ < options_.patience || end(lost_by_);
  }

  /// Returns whether the device's tick came or is overdue. Time beyond one period counts as late.
  bool device_is_due(Nanoseconds now) noexcept {
    if (!device_ticked_ && now < overdue_at_) return false;
    const Nanoseconds interval = now - last_tick_;
    if (!ticked_) return true;
    if (interval >= 2 * period_) {
      ++result_.overruns;
      result_.missed_deadlines += static_cast<std::uint64_t>(interval / period_ - 1);
    }
    woke(std::max(interval - period_, Nanoseconds(0)));
    return true;
  }

  /// Returns whether a deadline has passed.
  bool is_due(Nanoseconds now) noexcept {
    if (paced_) return device_is_due(now);
    const std::uint64_t passed = deadlines_.passed(now);
    if (passed == 0) return false;
    if (passed > 1) {
      ++result_.overruns;
      result_.missed_deadlines += passed - 1;
    }
    woke(now - deadlines_.latest());
    return true;
  }

  void woke(Nanoseconds late) noexcept {
    result_.wakeup_late.record(late.count());
    count(wakeups_, hand_time_limits::kWakeups, late);
  }

  /// Handles the loss of the session by a goodbye or by silence. Returns false if the loop ends.
  bool lose(Nanoseconds now, EndReason reason) noexcept {
    if (options_.rejoined == nullptr || options_.patience.count() <= 0) return end(reason);
    if (lost_) return true;
    lost_ = true;
    lost_at_ = now;
    lost_by_ = reason;
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
      ++session_;
    }
    if (lost_ && !fresh && now >= next_reroute_) {
      next_reroute_ = now + kReroutePeriod;
      if (!server_left_) port_.reroute();
    }
    // Accept a late session too. Otherwise the server would keep a session without a client.
    if (fresh) last_heard_ = now;
    const bool answered = lost_ && !server_left_ && last_heard_ > lost_at_;
    if (!fresh && !answered) return;
    server_left_ = false;
    if (fresh) heard_ = dealt_with_ = 0;  // a new session counts changes from 1
    servo_.reconnected(fresh);
    next_status_ = now;
    if (!lost_) return;
    lost_ = false;
    ++result_.reconnections;
    result_.disconnected += seconds(now - lost_at_);
  }

  /// Applies the prepared changes that an admin requested.
  void change(Nanoseconds now) noexcept {
    PreparedChange* next = nullptr;
    while (options_.changes->pop(next)) {
      if (!next->refused && next->link) port_.set_link(*next->link);
      if (!next->refused && next->law) servo_.adopt(*next->law);
      next->taken = ticked_ ? seconds(now - first_tick_) : 0.0;
      if (next->session != session_) continue;  // the present server does not know this change
      dealt_with_ = next->number;
      refused_ = next->refused;
      reported_ = Nanoseconds{0};  // the next sample reports the change to the server
    }
  }

  void take_fetched() noexcept {
    const FetchedScene* fetched = nullptr;
    while (options_.fetched->pop(fetched)) servo_.use(fetched);
  }

  /// Queues a requested change once. Replies repeat the request until the server has the answer.
  void hear(const std::optional<ClientChange>& wanted) noexcept {
    if (!wanted || wanted->number == heard_) return;
    if (outputs_.wanted->push({*wanted, session_})) heard_ = wanted->number;
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
        paced_ && !device_ticked_ ? servo_.missed_tick(device_, now) : servo_.tick(device_, now);
    if (sample != nullptr && !server_left_) send(*sample);
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
      report.times = {wakeups_, servo_.round_trips()};
    report.late_ticks = static_cast<std::uint32_t>(result_.overruns) & HandReport::kLateTicksMask;
    report.change = dealt_with_;
    report.change_refused = refused_;
    return report;
  }

  void take_replies(Nanoseconds now) noexcept {
    for (int left = kDatagramsAtOnce; left > 0;) {
      const Transport::Arrival arrival = transport_.receive(reply_, result_.goodbye, left);
      if (arrival == Transport::Arrival::nothing) return;
      if (arrival == Transport::Arrival::goodbye) {
        server_left_ = true;
        return;
      }
      // Only a reply to a newer sample shows that the server is alive.
      if (!servo_.take(reply_, now)) continue;
      last_heard_ = now;
      if (outputs_.wanted != nullptr) hear(reply_.change);
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
    if (lost_) {
      result_.lost_for = seconds(now - lost_at_);
      result_.lost_by = lost_by_;
      result_.disconnected += result_.lost_for;
    }
    servo_.release();
    if (delayed_) port_.pass(now);
    tick(now);
    constexpr std::size_t kWithoutStop = 1;
    // Stop waiting if the device holds a force against all commands.
    const Nanoseconds latest = now + from_seconds(servo_.parameters().hold_time);
    while (!servo_.let_go() && now < latest) {
      if (wait(kWithoutStop) < 0 && errno != EINTR) return tick(latest);  // waiting failed
      now = monotonic_now();
      if (delayed_) port_.pass(now);
      take_replies(now);
      if (is_due(now)) tick(now);
    }
    lower_tool();
  }

  /// Continues the ticks until the hand carries the weight of the tool.
  void lower_tool() noexcept {
    constexpr std::size_t kWithoutStop = 1;
    const Nanoseconds latest = monotonic_now() + kLowering;
    Nanoseconds now = monotonic_now();
    bool lowered = device_.lower_tool(now);
    while (!lowered && now < latest) {
      if (wait(kWithoutStop) < 0 && errno != EINTR) return;
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
    while (!server_left_ && servo_.awaits_answer() && now < latest) {
      // The server may still answer a datagram that leaves the port now.
      const auto due = port_.next_due();
      if (due) latest = std::max(latest, *due + kFarewell);
      const Nanoseconds wake = due ? std::min(latest, *due) : latest;
      const timespec left = to_timespec(std::max(wake - now, Nanoseconds(0)));
      if (::ppoll(waiting_.data(), 1, &left, nullptr) < 0 && errno != EINTR) break;
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
    if (outputs_.listener != nullptr) outputs_.listener->ticked(row, !lost_);
  }

  void report_status(Nanoseconds now) noexcept {
    next_status_ = now + kStatusPeriod;
    if (outputs_.status == nullptr) return;
    LiveStatus status = live_status(servo_, seconds(now - first_tick_), !lost_);
    status.slow_ticks = result_.device.slow;
    status.device_took = seconds(device_.take_longest());
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
  Nanoseconds start_;
  Nanoseconds period_;
  bool paced_;  // whether the device sets the tick rate; else the deadlines do
  Deadlines deadlines_;
  bool device_ticked_ = false;
  Nanoseconds overdue_at_{0};
  std::array<pollfd, 2> waiting_;  // descriptors for replies and for the stop event
  Reply reply_;
  bool ticked_ = false, server_left_ = false;
  bool lost_ = false;
  Nanoseconds lost_at_{0}, next_reroute_{0};
  EndReason lost_by_ = EndReason::server_silent;
  std::uint8_t heard_ = 0, dealt_with_ = 0;  // admin changes: newest received, newest answered
  bool refused_ = false;                     // whether the newest answered change was refused
  std::uint32_t session_ = 0;                // number of the session, as in WantedChange
  Nanoseconds first_tick_{0}, last_tick_, last_heard_, next_status_, reported_{0}, times_told_{0};
  HandTimes::Counts wakeups_{};
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
