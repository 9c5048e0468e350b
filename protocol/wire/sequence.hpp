#pragma once

#include <bitset>
#include <cstdint>

namespace feltwire {

/// The packet numbers that were seen, in a window behind the highest. So each is accepted once, and
/// a reordered datagram is not lost.
class PacketWindow {
 public:
  static constexpr std::uint64_t kWidth = 1024;
  /// Begins as if only `highest` had been seen; 0: none.
  explicit PacketWindow(std::uint64_t highest = 0) noexcept;
  /// Whether the number is not 0, not seen, and less than kWidth behind the highest.
  bool fresh(std::uint64_t number) const noexcept;
  /// Marks the number as seen. Precondition: fresh(number).
  void mark(std::uint64_t number) noexcept;
  std::uint64_t highest() const { return highest_; }

 private:
  std::bitset<kWidth> seen_;
  std::uint64_t highest_ = 0;
};

}  // namespace feltwire
