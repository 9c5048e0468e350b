#include "tests/support/allocation_counter.hpp"

#include <malloc.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstdlib>

namespace {
// Constant initialization avoids an allocation at the first use.
constinit thread_local std::size_t own = 0;
// own, all: number of uses; held, peak: [bytes]
constinit std::atomic<std::size_t> all = 0, held = 0, peak = 0;

[[maybe_unused]] void count() {
  ++own;
  all.fetch_add(1, std::memory_order_relaxed);
}
[[maybe_unused]] void* gained(void* memory) {
  const std::size_t size = ::malloc_usable_size(memory);
  const std::size_t now = held.fetch_add(size, std::memory_order_relaxed) + size;
  std::size_t most = peak.load(std::memory_order_relaxed);
  while (now > most && !peak.compare_exchange_weak(most, now, std::memory_order_relaxed)) {
  }
  return memory;
}
[[maybe_unused]] void lost(std::size_t size) { held.fetch_sub(size, std::memory_order_relaxed); }
}  // namespace

namespace feltwire::test {
std::size_t allocations() { return own; }
std::size_t allocations_of_others() { return all.load() - own; }
std::size_t heap_held() { return held.load(); }
std::size_t heap_peak() { return peak.load(); }
void begin_heap_peak() { peak = held.load(); }
}  // namespace feltwire::test

#ifndef FELTWIRE_SANITIZED
// glibc's own allocator has these names, which remain when a program replaces malloc. The dynamic
// linker prefers a program's malloc to libc's malloc. The counter therefore includes libraries.
extern "C" {
void* __libc_malloc(std::size_t size) noexcept;
void* __libc_calloc(std::size_t number, std::size_t size) noexcept;
void* __libc_realloc(void* memory, std::size_t size) noexcept;
void* __libc_memalign(std::size_t alignment, std::size_t size) noexcept;
void __libc_free(void* memory) noexcept;

void* malloc(std::size_t size) noexcept {
  count();
  return gained(__libc_malloc(size));
}
void* calloc(std::size_t number, std::size_t size) noexcept {
  count();
  return gained(__libc_calloc(number, size));
}
void* realloc(void* memory, std::size_t size) noexcept {
  count();
  const std::size_t before = ::malloc_usable_size(memory);
  void* const made = __libc_realloc(memory, size);
  if (made == nullptr && size > 0) return nullptr;  // The old block is unchanged.
  lost(before);
  return gained(made);
}
void* reallocarray(void* memory, std::size_t number, std::size_t size) noexcept {
  std::size_t bytes = 0;
  if (!__builtin_mul_overflow(number, size, &bytes)) return realloc(memory, bytes);
  count();
  errno = ENOMEM;
  return nullptr;
}
void* memalign(std::size_t alignment, std::size_t size) noexcept {
  count();
  return gained(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
  count();
  return gained(__libc_memalign(alignment, size));
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t size) noexcept {
  count();
  const bool power_of_two = alignment != 0 && (alignment & (alignment - 1)) == 0;
  if (!power_of_two || alignment % sizeof(void*) != 0) return EINVAL;
  void* const made = __libc_memalign(alignment, size);
  if (made == nullptr) return ENOMEM;
  *memory = gained(made);
  return 0;
}
// Freeing counts, because it also locks the heap. Freeing null does nothing.
void free(void* memory) noexcept {
  if (memory == nullptr) return;
  count();
  lost(::malloc_usable_size(memory));
  __libc_free(memory);
}
}
#endif
