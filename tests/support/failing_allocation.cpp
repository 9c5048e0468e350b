#include "tests/support/failing_allocation.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
thread_local bool spared = false;  // set in the thread that made the FailingAllocation
// allocations before the failure; 0 or below: none fails
std::atomic<std::int64_t> until_failure{-1};

#ifndef FELTWIRE_SANITIZED
/// Returns true if this allocation must fail.
bool fails() {
  if (until_failure.load(std::memory_order_relaxed) <= 0 || spared) return false;
  return until_failure.fetch_sub(1, std::memory_order_relaxed) == 1;
}
#endif
}  // namespace

namespace feltwire::test {

FailingAllocation::FailingAllocation(std::int64_t number) {
  spared = true;
  until_failure = number;
}
FailingAllocation::~FailingAllocation() {
  until_failure = -1;
  spared = false;
}
bool FailingAllocation::happened() const { return until_failure <= 0; }

}  // namespace feltwire::test

#ifndef FELTWIRE_SANITIZED
// If the compiler inlined this function, the compiler would see malloc and free in new and delete,
// and report a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  if (fails()) throw std::bad_alloc();
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  if (fails()) throw std::bad_alloc();
  const auto align = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(align, (size + align - 1) / align * align)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
#endif
