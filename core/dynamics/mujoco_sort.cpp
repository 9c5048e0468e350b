#include "core/dynamics/mujoco_sort.hpp"

#include <pthread.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace feltwire::mujoco {
namespace {

// Memory of this thread for half of the items to sort. It grows on demand and stays until the
// thread ends.
thread_local std::byte* room_of_thread = nullptr;
thread_local std::size_t size_of_room = 0;

void give_room_back(void* memory) noexcept {
  std::free(memory);
  room_of_thread = nullptr;
  size_of_room = 0;
}

// Use no thread_local object with a destructor: glibc ends the program if there is no memory to
// register the destructor.
pthread_key_t end_of_thread{};
const bool sees_end_of_thread = ::pthread_key_create(&end_of_thread, give_room_back) == 0;

std::byte* room_for(std::size_t bytes) noexcept {
  if (bytes <= size_of_room) return room_of_thread;
  if (!sees_end_of_thread) return nullptr;
  auto* const larger = static_cast<std::byte*>(std::realloc(room_of_thread, 2 * bytes));
  if (larger == nullptr) return nullptr;
  room_of_thread = larger;
  size_of_room = 2 * bytes;
  if (::pthread_setspecific(end_of_thread, larger) == 0) return larger;
  give_room_back(larger);
  return nullptr;
}

/// Merges two sorted halves. If an item of each half is equal, the left item comes first.
void merge_halves(std::byte* left, std::size_t of_left, std::size_t of_right, std::size_t size,
                  Compare compare, void* context, std::byte* room) noexcept {
  std::memcpy(room, left, of_left * size);
  const std::byte *a = room, *const end_of_a = room + of_left * size;
  const std::byte *b = left + of_left * size, *const end_of_b = b + of_right * size;
  std::byte* out = left;
  while (a != end_of_a && b != end_of_b) {
    const bool take_a = compare(a, b, context) <= 0;
    std::memcpy(out, take_a ? a : b, size);
    (take_a ? a : b) += size;
    out += size;
  }
  // The rest of b is already in place.
  std::memcpy(out, a, static_cast<std::size_t>(end_of_a - a));
}

void sort_halves(std::byte* first, std::size_t count, std::size_t size, Compare compare,
                 void* context, std::byte* room) noexcept {
  if (count < 2) return;
  const std::size_t of_left = count / 2;
  sort_halves(first, of_left, size, compare, context, room);
  sort_halves(first + of_left * size, count - of_left, size, compare, context, room);
  merge_halves(first, of_left, count - of_left, size, compare, context, room);
}

/// Sorts without extra memory. This is slow, but also stable.
void sort_in_place(std::byte* first, std::size_t count, std::size_t size, Compare compare,
                   void* context) noexcept {
  for (std::size_t n = 1; n < count; ++n)
    for (std::byte* at = first + n * size; at != first && compare(at - size, at, context) > 0;
         at -= size)
      std::swap_ranges(at - size, at, at);
}

}  // namespace

void sort_stably(void* base, std::size_t count, std::size_t size, Compare compare,
                 void* context) noexcept {
  auto* const first = static_cast<std::byte*>(base);
  if (count < 2 || size == 0) return;
  if (std::byte* const room = room_for(count / 2 * size))
    sort_halves(first, count, size, compare, context, room);
  else
    sort_in_place(first, count, size, compare, context);
}

void bring_own_sort() noexcept {}

}  // namespace feltwire::mujoco

#ifndef FELTWIRE_SANITIZED  // A sanitizer brings its own qsort_r.
extern "C" void qsort_r(void* base, std::size_t count, std::size_t size,
                        feltwire::mujoco::Compare compare, void* context) {
  feltwire::mujoco::sort_stably(base, count, size, compare, context);
}
#endif
