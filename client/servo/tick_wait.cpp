#include "client/servo/tick_wait.hpp"

#include <algorithm>
#include <ctime>

#include "core/base/numeric.hpp"
#include "protocol/net/busy_poll.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

timespec to_timespec(Nanoseconds time) noexcept {
  const auto whole = std::chrono::duration_cast<std::chrono::seconds>(time);
  return {.tv_sec = static_cast<time_t>(whole.count()),
          .tv_nsec = static_cast<long>((time - whole).count())};
}

}  // namespace

TickWait::TickWait(DatagramPort& port, const Event& stop, Nanoseconds start, Nanoseconds period,
                   Nanoseconds busy_poll, bool paced) noexcept
    : port_(port),
      period_(period),
      busy_poll_(busy_poll),
      paced_(paced),
      deadlines_(start, period),
      waiting_{{{port.descriptor(), POLLIN, 0}, {stop.descriptor(), POLLIN, 0}}} {}

int TickWait::wait(Device& device, const Moments& moments, For what) noexcept {
  const std::size_t count = what == For::replies ? 1 : waiting_.size();
  if (paced_) return await_device(device, moments, count);
  const auto due = port_.next_due();
  while (true) {
    const Nanoseconds now = monotonic_now();
    const bool late = now >= deadlines_.next() || (due && *due <= now);
    if (late || looks_busily(now, moments)) {
      const int ready = ::poll(waiting_.data(), count, 0);
      if (late || ready != 0) return ready;
      continue;
    }
    Nanoseconds wake = deadlines_.next() - std::max(busy_poll_, deadlines_.lead());
    if (due) wake = std::min(wake, *due);
    const timespec left = to_timespec(std::max(wake - now, Nanoseconds(0)));
    const int woken = ::ppoll(waiting_.data(), count, &left, nullptr);
    if (woken == 0) deadlines_.woken(monotonic_now() - wake);
    if (woken != 0 || due == wake) return woken;
  }
}

int TickWait::wait_for_reply(Nanoseconds latest) noexcept {
  const timespec left = to_timespec(std::max(latest - monotonic_now(), Nanoseconds(0)));
  return ::ppoll(waiting_.data(), 1, &left, nullptr);
}

/// Waits for the tick of the device. It counts as missed if it is late by a quarter of the hold
/// time. After a return without a tick, the loop waits again after a servo period.
int TickWait::await_device(Device& device, const Moments& moments, std::size_t count) noexcept {
  constexpr double kPatience = 0.25;
  overdue_at_ = moments.last_tick + from_seconds(kPatience * moments.hold_time);
  device_ticked_ = device.await_tick(overdue_at_);
  Nanoseconds rest{0};
  if (!device_ticked_) rest = std::clamp(overdue_at_ - monotonic_now(), Nanoseconds(0), period_);
  const timespec sleeps = to_timespec(rest);
  return ::ppoll(waiting_.data(), count, &sleeps, nullptr);
}

bool TickWait::looks_busily(Nanoseconds now, const Moments& moments) const noexcept {
  if (busy_poll_ == kForever) return true;
  const bool reply_near = moments.reply_awaited && now - moments.last_tick < busy_poll_;
  return reply_near || deadlines_.next() - now <= std::max(busy_poll_, deadlines_.lead());
}

TickWait::Due TickWait::due(Nanoseconds now, Nanoseconds last_tick, bool ticked) noexcept {
  Due found;
  if (paced_) {
    found = device_due(now, last_tick, ticked);
  } else if (const std::uint64_t passed = deadlines_.passed(now); passed > 0) {
    found = {true, passed - 1, now - deadlines_.latest()};
  }
  if (found.late) count(wakeups_, hand_time_limits::kWakeups, *found.late);
  return found;
}

/// Time beyond one period counts as late.
TickWait::Due TickWait::device_due(Nanoseconds now, Nanoseconds last_tick, bool ticked) noexcept {
  if (!device_ticked_ && now < overdue_at_) return {};
  if (!ticked) return {.due = true};
  const Nanoseconds interval = now - last_tick;
  const std::int64_t passed = interval / period_;
  return {true, static_cast<std::uint64_t>(std::max<std::int64_t>(0, passed - 1)),
          std::max(interval - period_, Nanoseconds(0))};
}

}  // namespace feltwire
