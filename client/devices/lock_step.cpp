#include "client/devices/lock_step.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "protocol/net/clock.hpp"

namespace feltwire {

void LockStepDevice::rest(Nanoseconds until) noexcept {
  std::this_thread::sleep_for(std::max(until - monotonic_now(), Nanoseconds(0)));
}

void LockStepDevice::give(const Command& command) noexcept {
  sent_at_ = monotonic_now();
  asked_ = true;
  const auto taken = send(command);
  lost_ |= !taken;
  next_ = taken.value_or(Command{});
  // What could not be sent changes nothing on the device: zero is sent again, until it goes out.
  pulls_ = taken ? next_ != Command{} : pulls_ || command != Command{};
}

bool LockStepDevice::await_tick(Nanoseconds latest) noexcept {
  reading_ = {.pose = {}, .ok = false};
  if (gone_ || (lost_ && sent_at_ + kQuiet > latest)) {
    rest(latest);
    return false;
  }
  if (lost_) {
    rest(sent_at_ + kQuiet);
    gone_ = !forget();
    if (gone_) return false;
    lost_ = asked_ = false;
    on_hand_ = {};
  }
  if (!asked_) give({});
  rest(std::min(latest, sent_at_ + kPeriod));
  DeviceReading reading;
  const Answer got = answer(on_hand_, reading, latest);
  gone_ = got == Answer::gone;
  lost_ |= got != Answer::whole;
  if (lost_) return got != Answer::none;
  asked_ = false;
  reading_ = reading;
  return true;
}

Command LockStepDevice::write(const Command& on_hand) noexcept {
  if (lost_ || gone_ || released_.load()) {
    if (pulls_) give({});
    on_hand_ = next_ = {};
    return {};
  }
  on_hand_ = next_;
  give(on_hand);
  if (!released_.load()) return on_hand_;
  let_go();  // release() came while it was sent
  return {};
}

void LockStepDevice::release() noexcept {
  released_.store(true);
  let_go();
}

}  // namespace feltwire
