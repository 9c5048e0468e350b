#pragma once
// Counts every use of the heap in the whole program. It replaces malloc, calloc, realloc, the
// aligned functions and free, so operator new and the libraries (MuJoCo, OpenSSL, libsodium, libc)
// are counted too. A test program lists allocation_counter.cpp in its sources to get this. Under
// sanitizers, which replace malloc themselves, nothing is counted: skip such tests there.
// tests/protocol/allocation_counter_test.cpp shows the counted uses.

#include <cstddef>

namespace feltwire::test {

/// How often the calling thread has allocated or freed heap memory so far.
std::size_t allocations();
/// This count for all other threads of the program, including ended ones.
std::size_t allocations_of_others();

/// [bytes] of heap that the whole program holds now, and the maximum since the last
/// begin_heap_peak() or the program's start. 0 under sanitizers.
std::size_t heap_held();
std::size_t heap_peak();
void begin_heap_peak();

}  // namespace feltwire::test
