#include "protocol/sequence.hpp"

namespace feltwire {

bool PacketWindow::take(std::uint64_t number) noexcept {
  if (number == 0) return false;
  if (number > highest_) {
    // The places that the window moves over belonged to older numbers.
    const std::uint64_t moved = number - highest_;
    if (moved >= kWidth) {
      seen_.reset();
    } else {
      for (std::uint64_t n = 1; n <= moved; ++n) seen_.reset((highest_ + n) % kWidth);
    }
    highest_ = number;
  } else if (highest_ - number >= kWidth || seen_.test(number % kWidth)) {
    return false;
  }
  seen_.set(number % kWidth);
  return true;
}

}  // namespace feltwire
