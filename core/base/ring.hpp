#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <span>
#include <type_traits>
#include <vector>

namespace feltwire {

/// A queue from one thread to one other thread, without locks. The writer never waits: a full queue
/// refuses the value. Copying T must not throw. All memory is allocated at construction.
template <class T>
class Ring {
 public:
  /// Allocates room for at least `capacity` values.
  explicit Ring(std::size_t capacity) : values_(std::bit_ceil(capacity)) {}

  /// Writer only. False if the queue is full.
  bool push(const T& value) noexcept {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == values_.size()) return false;
    values_[written & (values_.size() - 1)] = value;
    written_.store(written + 1, std::memory_order_release);
    return true;
  }

  /// Writer only. Adds all of them, or none if there is no room for all.
  bool push(std::span<const T> values) noexcept {
    const std::size_t written = written_.load(std::memory_order_relaxed);
    const std::size_t used = written - read_.load(std::memory_order_acquire);
    if (values.size() > values_.size() - used) return false;
    const std::size_t at = written & (values_.size() - 1);
    const std::size_t first = std::min(values.size(), values_.size() - at);
    std::copy_n(values.begin(), first, values_.begin() + static_cast<std::ptrdiff_t>(at));
    std::copy(values.begin() + static_cast<std::ptrdiff_t>(first), values.end(), values_.begin());
    written_.store(written + values.size(), std::memory_order_release);
    return true;
  }

  /// Reader only. Takes as many as `values` has, or none if there are fewer. For values that need
  /// no destructor.
  bool pop(std::span<T> values) noexcept requires std::is_trivially_destructible_v<T> {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (written_.load(std::memory_order_acquire) - read < values.size()) return false;
    const std::size_t at = read & (values_.size() - 1);
    const std::size_t first = std::min(values.size(), values_.size() - at);
    std::copy_n(values_.begin() + static_cast<std::ptrdiff_t>(at), first, values.begin());
    std::copy_n(values_.begin(), values.size() - first,
                values.begin() + static_cast<std::ptrdiff_t>(first));
    read_.store(read + values.size(), std::memory_order_release);
    return true;
  }

  /// Reader only. False if the queue is empty.
  bool pop(T& value) noexcept {
    const std::size_t read = read_.load(std::memory_order_relaxed);
    if (written_.load(std::memory_order_acquire) == read) return false;
    T& slot = values_[read & (values_.size() - 1)];
    value = slot;
    // Keys wipe themselves when they are destroyed; so do not leave a copy in the slot.
    if constexpr (!std::is_trivially_destructible_v<T>) slot = T{};
    read_.store(read + 1, std::memory_order_release);
    return true;
  }

 private:
  // Each has a cache line of its own, so that the two threads do not invalidate each other's.
  static constexpr std::size_t kLine = 64;
  std::vector<T> values_;
  alignas(kLine) std::atomic<std::size_t> written_{0};
  alignas(kLine) std::atomic<std::size_t> read_{0};
};

}  // namespace feltwire
