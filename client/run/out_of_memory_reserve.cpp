#include "client/run/out_of_memory_reserve.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <new>
#include <system_error>

namespace feltwire {
namespace {

// [bytes] Size of the reserve; a report needs some ten thousand bytes.
constexpr std::size_t kMemory = 1 << 18;

std::atomic<void*> put_by{nullptr};

/// Frees the reserve after a failed operator new. The operator then tries again.
void give_memory_back() {
  void* memory = put_by.exchange(nullptr);
  if (memory == nullptr) throw std::bad_alloc();
  std::free(memory);
}

}  // namespace

OutOfMemoryReserve::OutOfMemoryReserve() : descriptor_(::eventfd(0, EFD_CLOEXEC)) {
  if (descriptor_ < 0)
    throw std::system_error(errno, std::generic_category(),
                            "cannot reserve a file descriptor for the report; raise ulimit -n");
  put_by.store(std::malloc(kMemory));
  if (put_by.load() != nullptr) return;
  ::close(descriptor_);
  throw std::bad_alloc();
}

OutOfMemoryReserve::~OutOfMemoryReserve() {
  std::set_new_handler(nullptr);
  if (descriptor_ >= 0) ::close(descriptor_);
  std::free(put_by.exchange(nullptr));
}

void OutOfMemoryReserve::stand_in() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  std::set_new_handler(give_memory_back);
}

}  // namespace feltwire
