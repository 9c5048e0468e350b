#pragma once
// Asio allocates memory for each operation that is started. It uses the heap if the operation is
// started outside of a handler, or if each run of the loop takes one handler. An operation that is
// started again and again has its own memory here.

#include <array>
#include <cstddef>
#include <new>
#include <utility>

namespace feltwire {

/// Memory for one operation at a time; further or larger ones come from the heap.
class OperationMemory {
 public:
  OperationMemory() = default;
  OperationMemory(const OperationMemory&) = delete;
  OperationMemory& operator=(const OperationMemory&) = delete;

  void* take(std::size_t size) {
    if (taken_ || size > room_.size()) return ::operator new(size);
    taken_ = true;
    return room_.data();
  }
  void give_back(void* memory) noexcept {
    if (memory == room_.data())
      taken_ = false;
    else
      ::operator delete(memory);
  }

 private:
  alignas(std::max_align_t) std::array<std::byte, 512> room_;
  bool taken_ = false;
};

/// As the standard asks of allocators.
template <class T>
class OperationAllocator {
 public:
  using value_type = T;
  explicit OperationAllocator(OperationMemory& memory) noexcept : memory_(&memory) {}
  template <class U>
  OperationAllocator(const OperationAllocator<U>& other) noexcept : memory_(other.memory()) {}
  T* allocate(std::size_t count) {
    static_assert(alignof(T) <= alignof(std::max_align_t));
    return static_cast<T*>(memory_->take(count * sizeof(T)));
  }
  void deallocate(T* memory, std::size_t) noexcept { memory_->give_back(memory); }
  OperationMemory* memory() const noexcept { return memory_; }
  friend bool operator==(const OperationAllocator&, const OperationAllocator&) = default;

 private:
  OperationMemory* memory_;
};

/// A handler whose operation uses that memory, which must outlive it.
template <class Handler>
struct InOperationMemory {
  using allocator_type = OperationAllocator<void*>;
  OperationMemory* memory;
  Handler handler;

  allocator_type get_allocator() const noexcept { return allocator_type(*memory); }
  template <class... Arguments>
  void operator()(Arguments&&... arguments) {
    handler(std::forward<Arguments>(arguments)...);
  }
};
template <class Handler>
InOperationMemory<Handler> in(OperationMemory& memory, Handler handler) {
  return {&memory, std::move(handler)};
}

}  // namespace feltwire
