#pragma once
// A queue of datagrams that leave at their due time.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <numeric>
#include <optional>
#include <vector>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Holds at most `capacity` datagrams and returns them in the order of their due times. Datagrams
/// with equal due times keep the order of push(). It allocates only at construction. A datagram
/// longer than kMaxDatagram is cut to one byte more than that, so that its receiver still detects
/// that it is too long.
class DelayQueue {
 public:
  struct Entry {
    Nanoseconds due{0};
    Nanoseconds entered{0};
    std::uint64_t ordinal = 0;  // chosen by the caller
    std::uint64_t pushed = 0;   // counts push()
    std::uint32_t slot = 0;
    std::uint32_t size = 0;  // [bytes]
  };

  explicit DelayQueue(std::size_t capacity)
      // Not initialised: pages that are never used cost no memory.
      : bytes_(std::make_unique_for_overwrite<std::uint8_t[]>(capacity * kSlot)), free_(capacity) {
    std::iota(free_.rbegin(), free_.rend(), 0u);  // the lowest is used first
    heap_.reserve(capacity);
  }

  /// Returns false if the queue is full.
  bool push(Bytes datagram, Nanoseconds due, Nanoseconds entered, std::uint64_t ordinal) noexcept {
    if (free_.empty()) return false;
    const std::uint32_t slot = free_.back();
    free_.pop_back();
    const std::size_t size = std::min(datagram.size(), kSlot);
    if (size > 0) std::memcpy(bytes_.get() + slot * kSlot, datagram.data(), size);
    heap_.push_back({due, entered, ordinal, pushed_++, slot, static_cast<std::uint32_t>(size)});
    std::push_heap(heap_.begin(), heap_.end(), later);
    return true;
  }

  std::size_t size() const noexcept { return heap_.size(); }
  std::optional<Nanoseconds> next_due() const noexcept {
    if (heap_.empty()) return std::nullopt;
    return heap_.front().due;
  }

  /// Takes out the next one. Its bytes() are valid until the next push(). Precondition: size() > 0.
  Entry pop() noexcept {
    std::pop_heap(heap_.begin(), heap_.end(), later);
    const Entry entry = heap_.back();
    heap_.pop_back();
    free_.push_back(entry.slot);
    return entry;
  }
  Bytes bytes(const Entry& entry) const noexcept {
    return {bytes_.get() + entry.slot * kSlot, entry.size};
  }

 private:
  static constexpr std::size_t kSlot = kMaxDatagram + 1;
  static bool later(const Entry& a, const Entry& b) noexcept {
    return a.due != b.due ? a.due > b.due : a.pushed > b.pushed;
  }

  std::unique_ptr<std::uint8_t[]> bytes_;
  std::vector<std::uint32_t> free_;  // slots
  std::vector<Entry> heap_;          // the next one in front
  std::uint64_t pushed_ = 0;
};

}  // namespace feltwire
