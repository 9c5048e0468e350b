#pragma once

#include <bitset>
#include <cstdint>

namespace feltwire {

/// Which packet numbers were seen: a window behind the highest, so that each is taken once and
/// reordering is no loss.
class PacketWindow {
 public:
  static constexpr std::uint64_t kWidth = 1024;
  /// As if `highest` was the highest seen, and none below it; 0: none at all.
  explicit PacketWindow(std::uint64_t highest = 0) noexcept;
  /// Whether the number is neither 0, nor seen, nor kWidth and more behind the highest.
  bool fresh(std::uint64_t number) const noexcept;
  /// It is seen from now on. Precondition: it is fresh.
  void mark(std::uint64_t number) noexcept;
  std::uint64_t highest() const { return highest_; }

 private:
  std::bitset<kWidth> seen_;
  std::uint64_t highest_ = 0;
};

}  // namespace feltwire
