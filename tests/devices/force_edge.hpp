#pragma once
// Measures how long a stand-in still pulls after a scripted fault, in its device's ticks and by the
// clock. It knows nothing of feltwire.

#include <atomic>
#include <chrono>

namespace stand_in {

class ForceEdge {
 public:
  /// For the stand-in: a tick of the device, and a command with or without a force.
  void tick() noexcept { ++ticks_; }
  void command(bool pulls) noexcept {
    if (pulls || !struck_.load() || ended_.load()) return;
    last_tick_.store(ticks_.load());
    last_.store(Clock::now().time_since_epoch().count());
    ended_.store(true);
  }

  /// For the test, when the fault occurs.
  void strike() noexcept {
    first_tick_ = ticks_.load();
    first_ = Clock::now().time_since_epoch().count();
    ended_.store(false);
    struck_.store(true);
  }
  /// True once a command without a force has come.
  bool ended() const noexcept { return ended_.load(); }
  long ticks() const noexcept { return last_tick_.load() - first_tick_; }
  double seconds() const noexcept {
    return std::chrono::duration<double>(Clock::duration(last_.load() - first_)).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  std::atomic<long> ticks_{0}, last_tick_{0};
  std::atomic<Clock::rep> last_{0};
  std::atomic<bool> struck_{false}, ended_{false};
  // Only the test's thread uses these.
  long first_tick_ = 0;
  Clock::rep first_ = 0;
};

}  // namespace stand_in
