#pragma once
// Counts every use of the heap in the whole program: malloc, calloc, realloc, the aligned ones and
// free are replaced, so operator new and the libraries (MuJoCo, OpenSSL, libsodium, libc)
// are counted too. A test program gets this by listing allocation_counter.cpp in its sources. Under
// sanitizers, which replace malloc themselves, nothing is counted: skip such tests there.
// tests/protocol/allocation_counter_test.cpp shows what is seen.

#include <cstddef>

namespace feltwire::test {

/// The number of times that the calling thread has allocated or freed memory of the heap so far.
std::size_t allocations();
/// The same of all other threads of the program, those that have ended too.
std::size_t allocations_of_others();

/// [bytes] of the heap that the whole program holds now, and the most since the last
/// begin_heap_peak() or the beginning. 0 under sanitizers.
std::size_t heap_held();
std::size_t heap_peak();
void begin_heap_peak();

}  // namespace feltwire::test
