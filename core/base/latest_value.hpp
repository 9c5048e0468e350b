#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace feltwire {

/// The newest value of one thread, for any number of readers. Nobody waits: the writer never, a
/// reader only reads again where the writer came between. Such a sequence lock is that of H.-J.
/// Boehm, "Can seqlocks get along with programming language memory models?" (2012), with atomic
/// words, so that there is no data race.
template <class T>
requires std::is_trivially_copyable_v<T>
class LatestValue {
 public:
  /// For a single thread.
  void put(const T& value) noexcept {
    Words words{};
    copy_in(words, value);
    const std::uint64_t turn = turn_.load(std::memory_order_relaxed);
    turn_.store(turn + 1, std::memory_order_relaxed);
    std::atomic_thread_fence(std::memory_order_release);
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_relaxed);
    turn_.store(turn + 2, std::memory_order_release);
  }

  /// Any thread. False: nothing was put yet.
  bool get(T& value) const noexcept {
    Words words{};
    for (;;) {
      const std::uint64_t before = turn_.load(std::memory_order_acquire);
      if (before == 0) return false;
      for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_relaxed);
      std::atomic_thread_fence(std::memory_order_acquire);
      if (before % 2 == 0 && turn_.load(std::memory_order_relaxed) == before) break;
    }
    copy_out(value, words);
    return true;
  }

  /// Any thread. How many values were put.
  std::uint64_t count() const noexcept { return turn_.load(std::memory_order_acquire) / 2; }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  using Words = std::array<std::uint64_t, kWords>;
  static void copy_in(Words& words, const T& value) noexcept {
    std::memcpy(words.data(), &value, sizeof(T));
  }
  static void copy_out(T& value, const Words& words) noexcept {
    std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
  }

  std::atomic<std::uint64_t> turn_{0};  // odd: a value is being written
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace feltwire
