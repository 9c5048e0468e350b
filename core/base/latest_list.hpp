#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

namespace feltwire {

/// The newest list of values of one thread, for any number of readers: LatestValue for a number of
/// values that changes. The writer never waits. A reader never waits for a writer that is not run:
/// it copies the newest whole list, and begins again only if the writer has put kSlots - 1 others
/// meanwhile. All memory is allocated at construction.
template <class T>
requires(std::is_trivially_copyable_v<T> &&
         sizeof(T) % sizeof(std::uint64_t) == 0) class LatestList {
 public:
  /// `most`: the largest number of values. Further ones are left out.
  explicit LatestList(std::size_t most) : most_(most) {
    for (Slot& slot : slots_) slot.words = std::vector<Word>(most * kWords);
  }

  /// A single thread calls it.
  void put(std::span<const T> values) noexcept {
    const std::uint64_t number = published_.load(std::memory_order_relaxed) + 1;
    // A reader that sees a word of this list also sees that the list before was published.
    std::atomic_thread_fence(std::memory_order_release);
    Slot& slot = slots_[number % kSlots];
    const std::size_t count = std::min(values.size(), most_);
    slot.count.store(count, std::memory_order_relaxed);
    for (std::size_t i = 0; i < count; ++i) {
      std::array<std::uint64_t, kWords> words;
      std::memcpy(words.data(), &values[i], sizeof(T));
      for (std::size_t k = 0; k < kWords; ++k)
        slot.words[i * kWords + k].store(words[k], std::memory_order_relaxed);
    }
    published_.store(number, std::memory_order_release);
  }

  /// Any thread. Copies the first values to `to`, at most `most`, one in each `step` bytes (a
  /// multiple of 8): bytes of T beyond `step` are left out, bytes beyond T become zero. Sets
  /// `count` to the number of values. Returns the number of the list, from 1; 0: nothing was put
  /// yet.
  std::uint64_t get(void* to, std::size_t step, std::size_t most,
                    std::size_t& count) const noexcept {
    const std::size_t kept = std::min(step / sizeof(std::uint64_t), kWords);
    for (;;) {
      const std::uint64_t number = published_.load(std::memory_order_acquire);
      count = 0;
      if (number == 0) return 0;
      const Slot& slot = slots_[number % kSlots];
      count = std::min(slot.count.load(std::memory_order_relaxed), most);
      auto* place = static_cast<unsigned char*>(to);
      for (std::size_t i = 0; i < count; ++i, place += step) {
        const Word* words = &slot.words[i * kWords];
        for (std::size_t k = 0; k < kept; ++k) {
          const std::uint64_t word = words[k].load(std::memory_order_relaxed);
          std::memcpy(place + k * sizeof word, &word, sizeof word);
        }
        std::memset(place + kept * sizeof(std::uint64_t), 0, step - kept * sizeof(std::uint64_t));
      }
      std::atomic_thread_fence(std::memory_order_acquire);
      // The writer comes to this slot again after it has published kSlots - 1 other lists.
      if (published_.load(std::memory_order_relaxed) - number < kSlots - 1) return number;
    }
  }

 private:
  static constexpr std::size_t kSlots = 4;
  static constexpr std::size_t kWords = sizeof(T) / sizeof(std::uint64_t);
  using Word = std::atomic<std::uint64_t>;
  struct Slot {
    std::atomic<std::size_t> count{0};
    std::vector<Word> words{};
  };

  std::size_t most_;
  std::atomic<std::uint64_t> published_{0};  // the number of the newest whole list
  std::array<Slot, kSlots> slots_{};
};

}  // namespace feltwire
