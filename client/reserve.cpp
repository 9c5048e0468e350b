#include "client/reserve.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace feltwire {
namespace {

constexpr std::size_t kMemory = 1 << 18;  // [bytes] a report is some ten thousand

}  // namespace

Reserve::Reserve()
    : descriptor_(::eventfd(0, EFD_CLOEXEC)), memory_(std::make_unique<std::byte[]>(kMemory)) {
  if (descriptor_ < 0)
    throw std::system_error(errno, std::generic_category(), "cannot put a descriptor by");
}

void Reserve::give_back() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  memory_.reset();
}

}  // namespace feltwire
