#pragma once
// A device that answers each command with its position at that moment. The answers set the pace,
// and a force is held from the next answer on.

#include <atomic>
#include <functional>

#include "client/device/device.hpp"
#include "core/device/spec_text.hpp"

namespace feltwire {

/// The common part of such devices, for every transport of messages. At most one command is without
/// an answer. After a missing or faulty answer it sends zero at once. It starts again 50 ms later,
/// when no old answer can come any more.
class LockStepDevice : public Device {
 public:
  /// Waits for the answer to the newest command. It returns no sooner than a millisecond after the
  /// command.
  bool await_tick(Nanoseconds latest) noexcept final;
  const DeviceSpec& spec() const override { return described_.spec; }
  Nanoseconds longest_tick() const override { return longest_tick_; }
  DeviceReading read(Nanoseconds) noexcept final { return reading_; }
  /// Returns the command that is held until the next answer: the one before.
  Command write(const Command& on_hand) noexcept final;
  void release() noexcept final;

 protected:
  /// The specification is the user's file, or `usual` with the user's numbers. It senses no
  /// rotation, and takes a force up one tick late (write()). Throws as requested_spec().
  LockStepDevice(const SourcedSpec& usual, const SpecRequest& request);

  /// For the user, beside the driver's other notes.
  static constexpr const char* kTickNote =
      "the device promises no longest tick: 1.25 times the usual one of 50 at the start is an "
      "assumption; a later tick is an overrun in the report";
  static constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);
  static constexpr Nanoseconds kQuiet = std::chrono::milliseconds(50);
  static constexpr Nanoseconds kSlowest = std::chrono::milliseconds(8);  // usual answer

  enum class Answer {
    none,     // no answer by the given time
    garbled,  // or an impossible answer
    gone,     // the device is gone for good
    whole
  };

  /// Sends a command without waiting. Returns the part of it that the device will hold. Empty: it
  /// could not be sent.
  virtual std::optional<Command> send(const Command& command) noexcept = 0;
  /// Receives an answer that has come, or that comes by `latest`. It fills in `reading` if the
  /// answer is complete. `held` in it is the command held until then; without it, that is
  /// `on_hand`.
  virtual Answer answer(const Command& on_hand, DeviceReading& reading,
                        Nanoseconds latest) noexcept = 0;
  /// Discards all received bytes and the remembered movement. False: the device is gone.
  virtual bool forget() noexcept = 0;
  /// Sends zero. It is async-signal-safe, for any thread and any signal handler.
  virtual void let_go() noexcept = 0;

  /// Calls `ask` several times, which sends a command without a force and waits for its answer.
  /// Returns the usual time of that, and sets longest_tick() from it. Before the servo runs.
  Nanoseconds measure_answers(const std::function<void()>& ask);

  /// Sleeps until then.
  static void rest(Nanoseconds until) noexcept;

  SourcedSpec described_;

 private:
  void give(const Command& command) noexcept;

  Nanoseconds longest_tick_{0};
  std::atomic<bool> released_{false};
  // Members of the servo's thread.
  bool asked_ = false;  // a command waits for its answer
  bool pulls_ = false;  // the newest command had a force, as far as is known
  bool lost_ = false;   // the force that the device holds is not known
  bool gone_ = false;
  Nanoseconds sent_at_{0};
  DeviceReading reading_;
  Command on_hand_, next_;  // held since the newest reading, and from the next one on
};

}  // namespace feltwire
