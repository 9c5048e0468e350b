#pragma once

#include <bitset>
#include <cstdint>

namespace feltwire {

/// Which packet numbers were seen: a window behind the highest, so that each is taken once and
/// reordering is no loss.
class PacketWindow {
 public:
  static constexpr std::uint64_t kWidth = 1024;
  /// True, once, for a number not seen before and not older than the window.
  bool take(std::uint64_t number) noexcept;
  std::uint64_t highest() const { return highest_; }

 private:
  std::bitset<kWidth> seen_;
  std::uint64_t highest_ = 0;
};

}  // namespace feltwire
