#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace feltwire {

/// The newest value of one thread, for any number of readers. The writer never waits. A reader
/// never waits for a writer that is not run: it copies the newest whole value, and begins again
/// only if the writer has put kSlots - 1 others meanwhile.
template <class T>
requires std::is_trivially_copyable_v<T>
class LatestValue {
 public:
  /// A single thread calls it.
  void put(const T& value) noexcept {
    Words words{};
    std::memcpy(words.data(), &value, sizeof(T));
    const std::uint64_t number = published_.load(std::memory_order_relaxed) + 1;
    // A reader that sees a word of this value also sees that the value before was published.
    std::atomic_thread_fence(std::memory_order_release);
    Slot& slot = slots_[number % kSlots];
    for (std::size_t i = 0; i < kWords; ++i) slot[i].store(words[i], std::memory_order_relaxed);
    published_.store(number, std::memory_order_release);
  }

  /// Any thread. Returns the number of the value, from 1; 0: nothing was put yet.
  std::uint64_t get(T& value) const noexcept {
    Words words{};
    for (;;) {
      const std::uint64_t number = published_.load(std::memory_order_acquire);
      if (number == 0) return 0;
      const Slot& slot = slots_[number % kSlots];
      for (std::size_t i = 0; i < kWords; ++i) words[i] = slot[i].load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      // The writer comes to this slot again after it has published kSlots - 1 other values.
      if (published_.load(std::memory_order_relaxed) - number >= kSlots - 1) continue;
      std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
      return number;
    }
  }

 private:
  static constexpr std::size_t kSlots = 4;
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  using Words = std::array<std::uint64_t, kWords>;
  using Slot = std::array<std::atomic<std::uint64_t>, kWords>;

  std::atomic<std::uint64_t> published_{0};  // the number of the newest whole value
  std::array<Slot, kSlots> slots_{};
};

}  // namespace feltwire
