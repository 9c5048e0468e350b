#pragma once
// A hand of a program that uses the library.

#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "client/app/client_options.hpp"
#include "client/c_api/caller_device.hpp"
#include "client/c_api/feltwire.h"
#include "client/c_api/hand_recorder.hpp"
#include "client/c_api/message_queue.hpp"
#include "client/run/hand_run.hpp"
#include "client/servo/event.hpp"
#include "client/simulator/simulator_feed.hpp"
#include "core/base/latest_value.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// A tick as the program gets it.
struct TickCopy {
  fw_tick tick;
  std::int64_t clock;  // [ns] of the servo, monotonic
};

/// A run, and a thread that looks after it. Any thread may use it.
class OpenHand final : private RunOutlet, private TickListener {
 public:
  /// Joins the scene. `caller`: the device, if the program is the device itself; it lives as long
  /// as the run. `feed`: of the program's own simulator; null: a server has the scene. Throws
  /// as HandRun does, and std::runtime_error if the device is not ready for force within a minute.
  OpenHand(ClientOptions options, std::unique_ptr<Device> device, CallerDevice* caller,
           std::shared_ptr<SimulatorFeed> feed = nullptr);
  ~OpenHand() override;
  OpenHand(const OpenHand&) = delete;
  OpenHand& operator=(const OpenHand&) = delete;

  /// Null: the program is not the device.
  CallerDevice* caller() const noexcept { return caller_; }
  const control::JoinAccepted& accepted() const { return run_->accepted(); }
  /// Returns the newest tick in `tick`, with the force that is on the hand now: none where the
  /// device was let go, or the servo has made no tick for too long. False: there was no tick yet.
  /// It never waits.
  bool latest(fw_tick& tick) const noexcept;
  /// The program is the device. Gives a pose, and returns the force that the program must apply
  /// from now on, as latest() does. A single thread calls it; it never waits.
  bool exchange(const CallerDevice::Move& move, fw_tick& tick) noexcept;
  /// The program is the device, and makes the ticks. Gives a pose, waits for the tick with it, and
  /// returns that tick; the program applies its force from now on. False: the servo made none
  /// within a quarter of the hold time, and no force may be applied. A single thread calls it.
  bool step(const CallerDevice::Move& move, fw_tick& tick) noexcept;
  /// Whether the program's own simulator says what the hand touches.
  bool meets_simulator() const noexcept { return feed_ != nullptr; }
  /// Says what the tool touches, as it was at the tick with this time [s]. False, and nothing is
  /// said: there was no tick yet, that tick is older than the hold time or than the last contact,
  /// or the servo has not taken the contacts before this one. One thread at a time; it never waits.
  /// Throws std::invalid_argument if there was no such tick. Precondition: meets_simulator().
  bool touch(SimulatorContact contact, double time);
  /// The next tick that was not taken; false: there is none. One thread at a time.
  bool next(fw_tick& tick) noexcept { return ticks_.pop(tick); }
  /// Records its ticks from the next one on. Throws as HandRecorder does.
  std::unique_ptr<HandRecorder> record(RecordingTarget target);
  /// Its warnings and notes, for the program's people.
  MessageQueue& messages() noexcept { return messages_; }
  void stop() noexcept { run_->supervisor().stop(); }
  /// Set once the run has ended.
  const Event& over() const noexcept { return over_; }
  /// Ends the run, and waits for it. Returns the error that ended it too early; empty: none did.
  std::string end() noexcept;
  /// After end(): a call of the device does not return, so this must not be destroyed.
  bool is_stuck() const { return !run_->servo_ended(); }

 private:
  void say(std::string_view line) noexcept override;
  void show(const LiveStatus&, std::string_view) noexcept override {}
  void ticked(const TickRecord& tick, bool connected) noexcept override;
  void await_ready(Device& device);

  static constexpr std::size_t kTicks = 1 << 14;
  ClientOptions options_;
  CallerDevice* caller_;
  std::shared_ptr<SimulatorFeed> feed_;
  double touched_at_ = 0.0;  // [s] time of the last contact; thread of the simulator
  MessageQueue messages_;
  std::shared_ptr<RecorderPlace> recorder_ = std::make_shared<RecorderPlace>();
  std::uint64_t number_ = 0;  // of ticks; servo thread
  LatestValue<TickCopy> latest_;
  Ring<fw_tick> ticks_{kTicks};
  std::optional<HandRun> run_;
  Nanoseconds longest_tick_{0};  // after which the servo stands still
  Event over_;
  std::thread attendant_;
};

}  // namespace feltwire
