#include "protocol/wire/sequence.hpp"

namespace feltwire {

PacketWindow::PacketWindow(std::uint64_t highest) noexcept {
  if (highest > 0) mark(highest);
}

bool PacketWindow::fresh(std::uint64_t number) const noexcept {
  if (number == 0) return false;
  return number > highest_ || (highest_ - number < kWidth && !seen_.test(number % kWidth));
}

void PacketWindow::mark(std::uint64_t number) noexcept {
  if (number > highest_) {
    // Clear the bits of older numbers that the window now uses for newer numbers.
    const std::uint64_t moved = number - highest_;
    if (moved >= kWidth) {
      seen_.reset();
    } else {
      for (std::uint64_t n = 1; n <= moved; ++n) seen_.reset((highest_ + n) % kWidth);
    }
    highest_ = number;
  }
  seen_.set(number % kWidth);
}

}  // namespace feltwire
