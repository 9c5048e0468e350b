#pragma once
// A device that the program which uses the library is itself: it gives the pose, and applies the
// force that it reads.

#include <atomic>

#include "client/device/device.hpp"
#include "core/base/latest_value.hpp"

namespace feltwire {

class CallerDevice final : public Device {
 public:
  struct Move {
    std::array<double, 3> position{};     // [m] world frame
    std::array<double, 4> orientation{};  // unit quaternion w, x, y, z
    std::uint32_t buttons = 0;
    bool deadman = false;
  };

  /// `stale_after` [s]: without a move for this time the hand gets no force.
  CallerDevice(const DeviceSpec& spec, double stale_after)
      : spec_(spec), stale_after_(from_seconds(stale_after)) {}

  /// A single thread at a time calls it. It never waits.
  void move(const Move& move) noexcept { moves_.put(move); }

  const DeviceSpec& spec() const override { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept override {
    return released_.load() ? Command{} : on_hand;
  }
  void release() noexcept override { released_.store(true); }

 private:
  DeviceSpec spec_;
  Nanoseconds stale_after_;
  LatestValue<Move> moves_;
  std::atomic<bool> released_{false};
  // Members of the servo thread.
  std::uint64_t taken_ = 0;  // moves
  Nanoseconds moved_at_{0};
};

}  // namespace feltwire
