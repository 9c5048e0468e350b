#include "client/device/lock_step.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <utility>

#include "core/base/numeric.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr int kTrials = 50;           // number of answers to measure
constexpr double kLongerTick = 1.25;  // ratio of the longest tick to the usual tick

}  // namespace

LockStepDevice::LockStepDevice(const SourcedSpec& usual, const SpecRequest& request)
    : described_(request.name_or_file.empty() ? overruled(usual, request)
                                              : requested_spec(request, "")) {
  DeviceSpec& spec = described_.spec;
  spec.rotation_sensed = spec.rotation_actuated = 0;
  spec.max_torque = 0.0;
  spec.actuation.late_ticks = 1;
}

Nanoseconds LockStepDevice::measure_answers(const std::function<void()>& ask) {
  std::array<Nanoseconds, kTrials> took{};
  for (Nanoseconds& one : took) {
    const Nanoseconds start = monotonic_now();
    ask();
    one = monotonic_now() - start;
  }
  auto* const middle = took.begin() + kTrials / 2;
  std::nth_element(took.begin(), middle, took.end());
  longest_tick_ = from_seconds(kLongerTick * seconds(std::max(*middle, kPeriod)));
  return *middle;
}

void LockStepDevice::rest(Nanoseconds until) noexcept {
  std::this_thread::sleep_for(std::max(until - monotonic_now(), Nanoseconds(0)));
}

void LockStepDevice::give(const Command& command) noexcept {
  sent_at_ = monotonic_now();
  asked_ = true;
  const auto taken = send(command);
  lost_ |= !taken;
  next_ = taken.value_or(Command{});
  // `pulls_` is true if the device may hold a force. A command that was not sent changes nothing on
  // the device, so write() sends a failed zero command again.
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
  let_go();  // release() ran during the write
  return {};
}

void LockStepDevice::release() noexcept {
  released_.store(true);
  let_go();
}

}  // namespace feltwire
