#include "client/c_api/open_hand.hpp"

#include <poll.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>
#include <stdexcept>
#include <utility>

#include "client/c_api/c_values.hpp"
#include "client/device/await_prepared.hpp"
#include "client/servo/device_input.hpp"
#include "client/servo/stall_detector.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr double kTicksAhead = 2.0;  // of a simulator's time before the newest known tick
constexpr int kHousekeeping = 50;    // [ms] between two looks at the run

}  // namespace

OpenHand::OpenHand(ClientOptions options, std::unique_ptr<Device> device, CallerDevice* caller,
                   std::shared_ptr<SimulatorFeed> feed)
    : options_(std::move(options)), caller_(caller), feed_(std::move(feed)) {
  options_.hooks.listener = this;
  await_ready(*device);
  run_.emplace(std::move(device), options_, static_cast<RunOutlet&>(*this));
  const SessionParameters& granted = accepted().parameters;
  longest_tick_ =
      from_seconds(let_go_time(granted.servo_period, granted.hold_time, options_.hold.let_go_after,
                               run_->real_time().scheduler));
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

bool OpenHand::latest(fw_tick& tick) const noexcept {
  TickCopy newest{};
  const bool ticked = latest_.get(newest) != 0;
  tick = newest.tick;
  if (!ticked) return false;
  const bool let_go = over_.is_set() || (caller_ != nullptr && caller_->released()) ||
                      monotonic_now().count() - newest.clock > longest_tick_.count();
  if (!let_go) return true;
  put(Vec3::Zero(), tick.force);
  put(Vec3::Zero(), tick.torque);
  tick.zero_force_reason = static_cast<std::uint32_t>(ZeroForceReason::not_held);
  return true;
}

bool OpenHand::exchange(const CallerDevice::Move& move, fw_tick& tick) noexcept {
  const bool ticked = latest(tick);
  Command applied;
  if (ticked) {
    applied.elastic = vector(tick.force);
    applied.torque = vector(tick.torque);
  }
  caller_->exchange(move, monotonic_now(), applied);
  return ticked;
}

bool OpenHand::step(const CallerDevice::Move& move, fw_tick& tick) noexcept {
  const Nanoseconds now = monotonic_now();
  const double patience = kDevicePatience * accepted().parameters.hold_time;
  const bool ticked =
      !over_.is_set() && caller_->step(move, now, now + from_seconds(patience)) && latest(tick);
  Command applied;
  if (ticked) {
    applied.elastic = vector(tick.force);
    applied.torque = vector(tick.torque);
  } else {
    tick = {};
    tick.zero_force_reason = static_cast<std::uint32_t>(ZeroForceReason::not_held);
  }
  caller_->applies(applied);
  return ticked;
}

bool OpenHand::touch(SimulatorContact contact, double time) {
  TickCopy newest{};
  if (latest_.get(newest) == 0) return false;
  const double age = newest.tick.time - time;
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

std::unique_ptr<HandRecorder> OpenHand::record(RecordingTarget target) {
  target.about = recording_about(options_);
  return std::make_unique<HandRecorder>(target, recorder_);
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
  TickCopy copy{{}, tick.clock};
  fw_tick& out = copy.tick;
  out.number = ++number_;
  out.time = tick.time;
  put(tick.position, out.position);
  put(tick.orientation, out.orientation);
  put(tick.held, out.force);
  put(tick.torque, out.torque);
  out.reply_age = tick.age;
  out.balance = tick.balance.value_or(std::numeric_limits<double>::quiet_NaN());
  out.account_cut = tick.account_cut;
  out.zero_force_reason = static_cast<std::uint32_t>(tick.no_force);
  out.connected = connected ? 1 : 0;
  out.lead_state = static_cast<std::uint32_t>(tick.robot);
  put(tick.elastic + tick.frictional, out.scene_force);
  recorder_->add(tick);
  latest_.put(copy);
  ticks_.push(out);
  if (caller_ != nullptr) caller_->ticked();
}

void OpenHand::say(std::string_view line) noexcept {
  try {
    messages_.keep(std::string(line));
  } catch (const std::exception&) {  // no memory for it
  }
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
