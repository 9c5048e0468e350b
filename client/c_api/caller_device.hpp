#pragma once
// A device that the program which uses the library is itself: it gives the pose, and applies the
// force that it is given.

#include <array>
#include <atomic>

#include "client/device/device.hpp"
#include "core/base/ring.hpp"

namespace feltwire {

/// The program's thread calls exchange(), and applies the returned force until its next call. The
/// account hears of the force that was really applied, so a program that is late makes no energy
/// that nobody has paid for.
class CallerDevice final : public Device {
 public:
  struct Move {
    Pose pose;  // world frame
    std::uint32_t buttons = 0;
    bool deadman = false;
    double gripper = -1.0;  // [m] wanted opening of the robot's gripper; < 0: there is no lever
  };

  /// `stale_after` [s]: without a move for this time the hand gets no force.
  CallerDevice(const DeviceSpec& spec, double stale_after)
      : spec_(spec), stale_after_(from_seconds(stale_after)) {}

  /// Gives a pose at `now` (monotonic), and says which force the program applies from now on. A
  /// single thread calls it. It never waits.
  void exchange(const Move& move, Nanoseconds now, const Command& applied) noexcept;

  const DeviceSpec& spec() const override { return spec_; }
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

  static constexpr std::size_t kRoom = 64;  // moves between two ticks of the servo
  DeviceSpec spec_;
  Nanoseconds stale_after_;
  Ring<Offer> offers_{kRoom};
  std::atomic<bool> released_{false};
  // Members of the program's thread.
  Offer waiting_;  // moves for which the ring had no room
  Command applied_;
  Nanoseconds exchanged_at_{0};
  // Members of the servo thread.
  Move newest_;
  bool moved_ = false;
  Nanoseconds moved_at_{0};
};

}  // namespace feltwire
