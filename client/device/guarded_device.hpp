#pragma once
// Stands between the servo thread and its device, so that other threads can release the device.

#include <array>
#include <atomic>
#include <cstdint>
#include <string_view>

#include "client/device/device.hpp"

namespace feltwire {

/// A call of the device in which a servo thread is.
enum class DeviceCall : std::uint8_t { none, await_tick, read, write, lower_tool };
inline constexpr std::array<std::string_view, 5> kDeviceCallNames = {"none", "await_tick", "read",
                                                                     "write", "lower_tool"};

/// The device for the servo thread. After release() no force stays on the hand: a write() that was
/// under way takes its force back, later ones write nothing, and read() says that the device has
/// ended.
class GuardedDevice final : public Device {
 public:
  explicit GuardedDevice(Device& device) : device_(device) {}

  const DeviceSpec& spec() const override { return device_.spec(); }
  double motion_scale() const override { return device_.motion_scale(); }
  Nanoseconds longest_tick() const override { return device_.longest_tick(); }
  bool await_tick(Nanoseconds latest) noexcept override;
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept override;
  bool lower_tool(Nanoseconds now) noexcept override;
  /// For any thread and any signal handler; it may be called more than once.
  void release() noexcept override;

  bool released() const noexcept { return released_.load(); }
  /// Whether the device holds a force: the last write was not zero and the device was not released
  /// since.
  bool pulls() const noexcept { return pulls_.load() && !released(); }
  /// The number of calls of write() that have returned.
  std::uint64_t writes() const noexcept { return writes_.load(std::memory_order_acquire); }
  /// The number of calls of the device that have returned.
  std::uint64_t calls() const noexcept { return calls_.load(std::memory_order_acquire); }
  /// The time with which read() was called last: the beginning of the newest tick.
  Nanoseconds tick() const noexcept { return tick_.load(std::memory_order_acquire); }
  DeviceCall call() const noexcept { return call_.load(std::memory_order_acquire); }

  /// For another thread, after release(): abandons a servo thread that does not return from the
  /// device. If it returns later, it stops there for ever. True while it is in the device: then its
  /// data may be read.
  bool abandon() noexcept;

 private:
  enum class Where : std::uint8_t { outside, in_device, abandoned };
  void enter(DeviceCall call) noexcept {
    call_.store(call, std::memory_order_release);
    where_.store(Where::in_device);
  }
  void leave() noexcept;

  Device& device_;
  std::atomic<bool> released_{false}, pulls_{false};
  std::atomic<std::uint64_t> writes_{0}, calls_{0};
  std::atomic<Nanoseconds> tick_{Nanoseconds(0)};
  std::atomic<DeviceCall> call_{DeviceCall::none};
  static_assert(std::atomic<Nanoseconds>::is_always_lock_free);
  std::atomic<Where> where_{Where::outside};
};

}  // namespace feltwire
