#include "client/c_api/open_hand.hpp"

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

#include "client/device/await_prepared.hpp"
#include "client/servo/stall_detector.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr double kTicksAhead = 2.0;  // of a simulator's time before the newest known tick
constexpr int kHousekeeping = 50;    // [ms] between two looks at the run

std::array<double, 3> numbers(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

/// [ms] for poll(), rounded up.
int milliseconds(double seconds) {
  constexpr double kMost = 1e6;
  return static_cast<int>(std::ceil(1e3 * std::clamp(seconds, 0.0, kMost)));
}

}  // namespace

OpenHand::OpenHand(ClientOptions options, std::unique_ptr<Device> device, CallerDevice* caller,
                   std::shared_ptr<SimulatorFeed> feed)
    : options_(std::move(options)), caller_(caller), feed_(std::move(feed)) {
  options_.listener = this;
  await_ready(*device);
  run_.emplace(std::move(device), options_, static_cast<RunOutlet&>(*this));
  const SessionParameters& granted = accepted().parameters;
  longest_tick_ = from_seconds(let_go_time(granted.servo_period, granted.hold_time,
                                           options_.let_go_after, run_->real_time().scheduler));
  try {
    attendant_ = std::thread([this] {
      pollfd waiting{run_->supervisor().over_descriptor(), POLLIN, 0};
      while (run_->supervisor().look()) ::poll(&waiting, 1, kHousekeeping);
      over_.set();
    });
  } catch (...) {
    run_.reset();
    throw;
  }
}

OpenHand::~OpenHand() { end(); }

bool OpenHand::latest(TickCopy& tick) const noexcept {
  if (latest_.get(tick) == 0) return false;
  const bool let_go = over() || (caller_ != nullptr && caller_->released()) ||
                      monotonic_now().count() - tick.clock > longest_tick_.count();
  if (!let_go) return true;
  tick.force = tick.torque = {};
  tick.zero_force_reason = static_cast<std::uint32_t>(ZeroForceReason::not_held);
  return true;
}

bool OpenHand::exchange(const CallerDevice::Move& move, TickCopy& tick) noexcept {
  const bool ticked = latest(tick);
  Command applied;
  if (ticked) {
    applied.elastic = {tick.force[0], tick.force[1], tick.force[2]};
    applied.torque = {tick.torque[0], tick.torque[1], tick.torque[2]};
  }
  caller_->exchange(move, monotonic_now(), applied);
  return ticked;
}

bool OpenHand::touch(SimulatorContact contact, double time) {
  TickCopy newest;
  if (latest_.get(newest) == 0) return false;
  const double age = newest.time - time;
  // The tick may be newer than the one that this thread knows.
  const double ahead = kTicksAhead * accepted().parameters.servo_period;
  if (age < -ahead)
    throw std::invalid_argument(
        "time is later than the newest tick; give fw_tick.time of the pose that the physics used");
  if (age > accepted().parameters.hold_time || time < touched_at_) return false;
  touched_at_ = time;
  contact.seen = Nanoseconds(newest.clock) - from_seconds(std::max(age, 0.0));
  return feed_->put(contact);
}

void OpenHand::await_ready(Device& device) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kPatience = std::chrono::minutes(1);
  const Clock::time_point latest = Clock::now() + kPatience;
  std::string wanted;
  const auto tell = [&](const std::string& text) { messages_.keep("no force yet: " + text); };
  const bool ready = await_prepared(device, tell, [&](const std::string& text) {
    wanted = text;
    ::poll(nullptr, 0, 10);
    return Clock::now() < latest;
  });
  if (!ready) throw std::runtime_error("the device is not ready for force: " + wanted);
}

void OpenHand::ticked(const TickRecord& tick, bool connected) noexcept {
  const TickCopy copy{.number = ++number_,
                      .clock = tick.clock,
                      .time = tick.time,
                      .position = numbers(tick.position),
                      .force = numbers(tick.held),
                      .torque = numbers(tick.torque),
                      .orientation = {tick.orientation.w(), tick.orientation.x(),
                                      tick.orientation.y(), tick.orientation.z()},
                      .reply_age = tick.age,
                      .balance = tick.balance.value_or(std::numeric_limits<double>::quiet_NaN()),
                      .account_cut = tick.account_cut,
                      .zero_force_reason = static_cast<std::uint32_t>(tick.no_force),
                      .connected = connected};
  latest_.put(copy);
  ticks_.push(copy);
}

void OpenHand::say(std::string_view line) noexcept {
  try {
    messages_.keep(std::string(line));
  } catch (const std::exception&) {  // no memory for it
  }
}

bool OpenHand::wait(double timeout) const noexcept {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point latest = Clock::now() + std::chrono::milliseconds(milliseconds(timeout));
  pollfd waiting{over_.descriptor(), POLLIN, 0};
  // A signal of the program may interrupt poll().
  while (!over_.is_set() && Clock::now() < latest) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(latest - Clock::now());
    ::poll(&waiting, 1, static_cast<int>(left.count()) + 1);
  }
  return over_.is_set();
}

std::string OpenHand::end() noexcept {
  if (!run_) return {};
  run_->supervisor().stop();
  if (attendant_.joinable()) attendant_.join();
  try {
    return run_->end();
  } catch (const std::exception&) {  // no memory for its texts
    return {};
  }
}

}  // namespace feltwire
