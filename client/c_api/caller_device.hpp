#pragma once
// A device that the program which uses the library is itself: it gives the pose, and applies the
// force that it is given.

#include <array>
#include <atomic>

#include "client/device/device.hpp"
#include "core/base/event_descriptor.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// The program's thread gives poses, and applies the force that it is given until its next one. The
/// account hears of the force that was really applied, so a program that is late makes no energy
/// that nobody has paid for. The servo ticks by its own timer, or each pose makes a tick: a step.
class CallerDevice final : public Device {
 public:
  struct Move {
    Pose pose;  // world frame
    std::uint32_t buttons = 0;
    bool deadman = false;
    double gripper = -1.0;  // [m] wanted opening of the robot's gripper; < 0: there is no lever
  };

  /// `stale_after` [s]: without a move for this time the hand gets no force. `step` [s]: the
  /// program makes the ticks, each at most so long after the last; 0: the servo's timer makes them.
  CallerDevice(const DeviceSpec& spec, double stale_after, double step = 0.0)
      : spec_(spec), stale_after_(from_seconds(stale_after)), step_(from_seconds(step)) {}

  /// Gives a pose at `now` (monotonic), and says which force the program applies from now on. A
  /// single thread calls it. It never waits.
  void exchange(const Move& move, Nanoseconds now, const Command& applied) noexcept;

  bool makes_ticks() const noexcept { return step_.count() > 0; }
  /// Gives a pose at `now`, and waits until the servo has made its tick with it, until `latest` at
  /// most. False: it made none by then. applies() must follow. The thread of exchange() calls it.
  bool step(const Move& move, Nanoseconds now, Nanoseconds latest) noexcept;
  /// Says which force the program applies from now on.
  void applies(const Command& applied) noexcept { applied_ = applied; }
  /// The servo thread: the tick of the last read() can be read by the program.
  void ticked() noexcept;

  const DeviceSpec& spec() const override { return spec_; }
  Nanoseconds longest_tick() const override { return step_; }
  bool await_tick(Nanoseconds latest) noexcept override;
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept override {
    return released() ? Command{} : on_hand;
  }
  void release() noexcept override { released_.store(true); }
  bool released() const noexcept { return released_.load(); }

 private:
  /// A move, and the mean force over the time since the move before.
  struct Offer {
    Move move;
    Command held;
    double span = 0.0;  // [s]
  };
  static Offer joined(const Offer& older, const Offer& newer) noexcept;
  void offer(const Move& move, Nanoseconds now) noexcept;

  static constexpr std::size_t kRoom = 64;  // moves between two ticks of the servo
  DeviceSpec spec_;
  Nanoseconds stale_after_, step_;
  Ring<Offer> offers_{kRoom};
  std::atomic<std::uint64_t> begun_{0}, made_{0};  // steps, counted from 1
  EventDescriptor begins_, done_;                  // another step, or its tick
  std::atomic<bool> released_{false};
  // Members of the program's thread.
  Offer waiting_;  // moves for which the ring had no room
  Command applied_;
  Nanoseconds exchanged_at_{0};
  // Members of the servo thread.
  std::uint64_t taken_ = 0;  // the newest step that await_tick() saw
  Move newest_;
  bool moved_ = false;
  Nanoseconds moved_at_{0};
};

}  // namespace feltwire
