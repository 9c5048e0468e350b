#pragma once
// qsort_r without the heap. MuJoCo sorts the geoms of a scene in every step, and glibc's qsort_r
// takes memory from the heap for more than a kilobyte (some 64 geoms): a tick would allocate. The
// dynamic linker takes the program's own qsort_r before libc's. This one sorts stably, as glibc's
// does, so that a simulation keeps its bits.

#include <cstddef>

namespace feltwire::mujoco {

using Compare = int (*)(const void*, const void*, void*);

/// Replaces qsort_r(). Its memory belongs to the calling thread and grows only for a larger array
/// than ever before; without memory it sorts in place, slowly.
void sort_stably(void* base, std::size_t count, std::size_t size, Compare compare,
                 void* context) noexcept;

/// Does nothing. A call links this file's qsort_r into the program.
void bring_own_sort() noexcept;

}  // namespace feltwire::mujoco
