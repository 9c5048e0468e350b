#pragma once
// A device that answers each command with the position that it had when it took the command up:
// the answers set the pace, and a force is held from the next answer on.

#include <atomic>

#include "client/devices/device.hpp"

namespace feltwire {

/// The part of such devices that is the same for every carrier of messages. There is never more
/// than one command without an answer. After an answer that is missing or makes no sense zero is
/// sent at once, and 50 ms later, when no old answer can come any more, it is begun anew.
class LockStepDevice : public Device {
 public:
  /// The answer to the newest command, and no sooner than a millisecond after it.
  bool await_tick(Nanoseconds latest) noexcept final;
  DeviceReading read(Nanoseconds) noexcept final { return reading_; }
  /// Returns what is held until the next answer: the command before.
  Command write(const Command& on_hand) noexcept final;
  void release() noexcept final;

 protected:
  static constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
  static constexpr Nanoseconds kQuiet = std::chrono::milliseconds(50);
  static constexpr int kLateTicks = 1;  // DeviceSpec::late_ticks: write() says why

  enum class Answer {
    none,     // by the time that was given
    garbled,  // or impossible
    gone,     // the device is, for good
    whole
  };

  /// Sends it without waiting. Returns what of it the device will hold; none: it could not be sent.
  virtual std::optional<Command> send(const Command& command) noexcept = 0;
  /// What has come, or comes by `latest`. Where it is whole, `reading` is filled in. A `held` in it
  /// is what was held until then; without it `on_hand` was.
  virtual Answer answer(const Command& on_hand, DeviceReading& reading,
                        Nanoseconds latest) noexcept = 0;
  /// Throws away what has come, and what was remembered of the movement. False: it is gone.
  virtual bool forget() noexcept = 0;
  /// Sends zero; async-signal-safe. Any thread, any signal handler.
  virtual void let_go() noexcept = 0;

  /// Asleep until then.
  static void rest(Nanoseconds until) noexcept;
  Nanoseconds sent_at() const noexcept { return sent_at_; }

 private:
  void give(const Command& command) noexcept;

  std::atomic<bool> released_{false};
  // Of the servo's thread.
  bool asked_ = false;  // a command is to be answered
  bool pulls_ = false;  // as far as is known, by the newest command that was sent
  bool lost_ = false;   // what the device holds is not known
  bool gone_ = false;
  Nanoseconds sent_at_{0};
  DeviceReading reading_;
  Command on_hand_, next_;  // since the newest reading, and from the next one on
};

}  // namespace feltwire
