#pragma once
// The resources of this process, by the kernel and the allocator.

#include <cstddef>

namespace feltwire::soak {

/// [bytes] resident.
std::size_t resident_memory();
/// [bytes] that the allocator has given out and not got back, all threads.
std::size_t heap_in_use();
/// Open descriptors.
std::size_t descriptors();

}  // namespace feltwire::soak
